// PNG files of all kinds, and the chunks of written ones.
#include "core/image/formats/png.h"
#include "core/image/image.h"
#include "core/io/error.h"
#include "tests/support/files/png_files.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <utility>

namespace sheaf::test_png {

namespace {

using test::png_chunk;
using test::png_file;
using test::PngSample;
using Names = std::vector<std::string>;

StoredImage read(const std::string& bytes) {
  return read_stored_image(EncodedImage{{bytes.begin(), bytes.end()}, "a.png"});
}

std::string error_of(const std::string& bytes) {
  try {
    (void)read(bytes);
  } catch (const SceneError& error) { return error.what(); }
  return "";
}

/// 13 x 9 pixels, so that all passes of interlaced files have pixels and the last byte of rows is not full.
PngSample sample(int color_type, int bits) {
  PngSample made;
  made.width = 13;
  made.height = 9;
  made.color_type = color_type;
  made.bits = bits;
  const int channels = color_type == 2 ? 3 : color_type == 4 ? 2 : color_type == 6 ? 4 : 1;
  for (int i = 0; i < made.width * made.height * channels; ++i) made.values.push_back(i * 7919 % (1 << bits));
  return made;
}

/// Checks the values of a file, plain and interlaced. `max`: of the stored values.
void check_values(PngSample made, const Names& channels, const std::vector<int>& expected, int max) {
  for (const bool interlaced : {false, true}) {
    CAPTURE(interlaced);
    made.interlaced = interlaced;
    const StoredImage image = read(png_file(made));
    CHECK(image.width == 13);
    CHECK(image.height == 9);
    CHECK(image.channels == channels);
    CHECK(image.integers);
    const TemporaryFolder folder;
    write_bytes(folder / "a.png", png_file(made));
    const Image floats = read_image(folder / "a.png");
    const bool is_wide = made.bits == 16;
    REQUIRE((is_wide ? image.floats.size() : image.bytes.size()) == expected.size());
    REQUIRE(floats.data.size() == expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const float value = static_cast<float>(expected[i]) * (1.0f / static_cast<float>(max));
      if (is_wide) REQUIRE(image.floats[i] == value);
      if (!is_wide) REQUIRE(int{image.bytes[i]} == expected[i] * 255 / max);
      REQUIRE(floats.data[i] == (is_wide ? value : static_cast<float>(expected[i] * 255 / max) * (1.0f / 255)));
    }
  }
}

/// Names and data of the chunks of a file.
std::vector<std::pair<std::string, std::string>> chunks_of(const std::vector<unsigned char>& file) {
  const std::string bytes(file.begin(), file.end());
  std::vector<std::pair<std::string, std::string>> chunks;
  for (std::size_t at = 8, size = 0; at + 12 <= bytes.size(); at += 12 + size) {
    size = 0;
    for (std::size_t i = 0; i < 4; ++i) size = size << 8 | static_cast<unsigned char>(bytes[at + i]);
    chunks.emplace_back(bytes.substr(at + 4, 4), bytes.substr(at + 8, size));
  }
  return chunks;
}

}  // namespace

TEST_CASE("PNG: all numbers of bits and channels, interlaced or not") {
  for (const int bits : {1, 2, 4, 8, 16}) {
    CAPTURE(bits);
    const PngSample gray = sample(0, bits);
    check_values(gray, {"Y"}, gray.values, (1 << bits) - 1);
  }
  for (const int bits : {8, 16}) {
    CAPTURE(bits);
    for (const auto& [type, channels] :
         {std::pair{2, Names{"R", "G", "B"}}, std::pair{4, Names{"Y", "A"}}, std::pair{6, Names{"R", "G", "B", "A"}}}) {
      const PngSample made = sample(type, bits);
      check_values(made, channels, made.values, (1 << bits) - 1);
    }
  }
}

TEST_CASE("PNG: palettes become colors, and their transparency alpha") {
  for (const int bits : {1, 2, 4, 8}) {
    CAPTURE(bits);
    PngSample made = sample(3, bits);
    std::string palette;
    for (int i = 0; i < 3 << bits; ++i) palette += static_cast<char>(255 - i);
    const std::string alphas("\x40\0", 2);  // of the first two entries; the others are opaque
    std::vector<int> opaque, transparent;
    for (const int index : made.values) {
      for (int c = 0; c < 3; ++c) {
        opaque.push_back(255 - (3 * index + c) % 256);
        transparent.push_back(opaque.back());
      }
      transparent.push_back(index == 0 ? 0x40 : index == 1 ? 0 : 255);
    }
    made.chunks = png_chunk("PLTE", palette);
    check_values(made, {"R", "G", "B"}, opaque, 255);
    made.chunks += png_chunk("tRNS", alphas);
    check_values(made, {"R", "G", "B", "A"}, transparent, 255);
  }
}

TEST_CASE("PNG: a transparent color becomes alpha") {
  for (const int bits : {1, 2, 4, 8, 16}) {
    CAPTURE(bits);
    PngSample gray = sample(0, bits);
    const int max = (1 << bits) - 1, transparent = gray.values[1];
    gray.chunks = png_chunk("tRNS", test::big_endian(static_cast<std::uint32_t>(transparent)).substr(2));
    std::vector<int> expected;
    for (const int value : gray.values) {
      expected.push_back(value);
      expected.push_back(value == transparent ? 0 : max);
    }
    check_values(gray, {"Y", "A"}, expected, max);
  }
  PngSample colors = sample(2, 16);
  std::string key;
  for (std::size_t c = 0; c < 3; ++c)
    key += test::big_endian(static_cast<std::uint32_t>(colors.values[3 + c])).substr(2);
  colors.chunks = png_chunk("tRNS", key);
  std::vector<int> expected;
  for (std::size_t i = 0; i < colors.values.size(); i += 3) {
    expected.insert(expected.end(), {colors.values[i], colors.values[i + 1], colors.values[i + 2]});
    expected.push_back(i == 3 ? 0 : 65535);
  }
  check_values(colors, {"R", "G", "B", "A"}, expected, 65535);
}

TEST_CASE("PNG: gamma, profiles and texts leave the pixels as they are, and may be damaged") {
  PngSample made = sample(2, 8);
  std::string damaged = png_chunk("tEXt", std::string("Comment\0text", 12));
  damaged.back() = static_cast<char>(damaged.back() ^ 1);
  const std::string profile = std::string("name\0\0", 6) + test::deflated("not a profile");
  made.chunks = png_chunk("gAMA", test::big_endian(100000)) + png_chunk("iCCP", profile) + png_chunk("sBIT", "\1\1\1") +
                png_chunk("oFFs", test::big_endian(4) + test::big_endian(~3u) + std::string(1, '\0')) +
                png_chunk("zTXt", std::string("Huge\0\0", 6) + test::deflated(std::string(1 << 24, 'x'))) + damaged;
  check_values(made, {"R", "G", "B"}, made.values, 255);
}

TEST_CASE("PNG: errors have the name of the file and the reason") {
  const PngSample made = sample(2, 8);
  const std::string whole = png_file(made);
  std::string bytes = whole;
  bytes[bytes.find("IDAT") + 20] ^= 1;
  CHECK(error_of(bytes) == "a.png: cannot read the image: IDAT: incorrect data check");
  bytes = whole;
  bytes.replace(8, 25, png_chunk("IHDR", test::big_endian(13) + test::big_endian(9) + std::string("\5\2\0\0\0", 5)));
  CHECK(error_of(bytes) == "a.png: cannot read the image: Invalid IHDR data");
  bytes.replace(8, 25,
                png_chunk("IHDR", test::big_endian(70000) + test::big_endian(1) + std::string("\x8\2\0\0\0", 5)));
  CHECK(error_of(bytes) == "a.png: the image is too large: 70000 x 1 pixels with 3 channels");
  bytes.replace(8, 25, png_chunk("IHDR", test::big_endian(9000) + test::big_endian(9) + std::string("\x8\2\0\0\0", 5)));
  CHECK(error_of(bytes) == "a.png: cannot read the image: Not enough image data");
}

TEST_CASE("PNG: written files are labeled as sRGB and have no other chunks than needed") {
  const std::vector<std::uint8_t> bytes = {1, 2, 3, 4, 5, 6, 7, 8};
  const std::vector<std::uint16_t> wide = {1, 60000, 258, 4};
  std::string problem;
  const auto names = [](const std::vector<unsigned char>& file) {
    std::string all;
    for (const auto& [name, data] : chunks_of(file)) all += name + ' ';
    return all;
  };
  const std::vector<unsigned char> rgba = encode_png({2, 1, 4, true, 8, bytes.data()}, 6, "", problem);
  CHECK(names(rgba) == "IHDR gAMA sRGB cHRM IDAT IEND ");
  const std::vector<unsigned char> text = encode_png({2, 1, 4, true, 8, bytes.data()}, 6, "stopped", problem);
  CHECK(names(text) == "IHDR gAMA sRGB cHRM tEXt IDAT IEND ");
  CHECK(chunks_of(text)[4].second == std::string("Description\0stopped", 19));
  CHECK(read({rgba.begin(), rgba.end()}).bytes == bytes);
  // 16 bits, with and without alpha
  for (const bool has_alpha : {false, true}) {
    const int channels = has_alpha ? 2 : 1;
    const std::vector<unsigned char> file =
        encode_png({4 / channels, 1, channels, has_alpha, 16, wide.data()}, 9, "", problem);
    const StoredImage image = read({file.begin(), file.end()});
    CHECK(image.channels == (has_alpha ? Names{"Y", "A"} : Names{"Y"}));
    for (std::size_t i = 0; i < wide.size(); ++i)
      CHECK(image.floats[i] == static_cast<float>(wide[i]) * (1.0f / 65535));
  }
  const std::vector<std::uint8_t> flat(3 * 64 * 64, 7);
  const IntegerPixels pixels{64, 64, 3, false, 8, flat.data()};
  CHECK(encode_png(pixels, 0, "", problem).size() > flat.size());
  CHECK(encode_png(pixels, 9, "", problem).size() < flat.size() / 10);
  CHECK(problem.empty());
  CHECK(encode_png({0, 1, 3, false, 8, flat.data()}, 6, "", problem).empty());
  CHECK(problem == "Invalid IHDR data");
}

}  // namespace sheaf::test_png
