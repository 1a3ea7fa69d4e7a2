// Reading of TIFF files: kinds of samples, colors and planes, and damage. test_image_orientation.cpp covers orientation
// and byte order, test_image.cpp hostile strips and tiles, test_image_encoding.cpp writing.
#include "core/image/formats/tiff.h"
#include "core/image/image.h"
#include "core/io/error.h"
#include "tests/support/contains.h"
#include "tests/support/files/tiff_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <limits>

namespace sheaf::test_tiff {

namespace {

using test::contains;
using test::tiff_file;
using test::TiffSample;
using Names = std::vector<std::string>;

StoredImage read(const TiffSample& sample, const std::string& strips) {
  const TemporaryFolder folder;
  write_bytes(folder / "a.tif", tiff_file(sample, strips));
  return read_stored_image(folder / "a.tif");
}

std::string little(const std::vector<std::uint32_t>& values, int bytes) {
  std::string text;
  for (const std::uint32_t value : values) append_little(text, value, bytes);
  return text;
}

std::string error_of(const TiffSample& sample, const std::string& strips) {
  try {
    (void)read(sample, strips);
  } catch (const SceneError& error) { return error.what(); }
  return "";
}

}  // namespace

TEST_CASE("TIFF: integers and floats of all sizes") {
  const auto values = [](std::uint32_t bits, std::uint32_t format, const std::string& strip) {
    return read({.width = 2, .bits = bits, .format = format}, strip).floats;
  };
  CHECK(read({.width = 2}, "\x80\xff").bytes == std::vector<std::uint8_t>{128, 255});
  CHECK(values(8, 2, std::string("\x7f\x81")) == std::vector<float>{1, -1});
  CHECK(values(16, 1, little({0xffff, 0}, 2)) == std::vector<float>{1, 0});
  CHECK(values(16, 2, little({0x7fff, 0x8001}, 2)) == std::vector<float>{1, -1});
  CHECK(values(32, 1, little({0xffffffff, 0x80000000}, 4)) == std::vector<float>{1, 0.5f});
  CHECK(values(32, 2, little({0x7fffffff, 0xc0000000}, 4)) == std::vector<float>{1, -0.5f});
  CHECK(values(16, 3, little({0x3e00, 0x8001}, 2)) == std::vector<float>{1.5f, -0x1p-24f});
  CHECK(values(16, 3, little({0x7bff, 0x0400}, 2)) == std::vector<float>{65504, 0x1p-14f});
  CHECK(values(16, 3, little({0x7c00, 0xfc00}, 2)) ==
        std::vector<float>{std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()});
  CHECK(values(32, 3, little({std::bit_cast<std::uint32_t>(-2.5f), 0}, 4)) == std::vector<float>{-2.5f, 0});
  CHECK(values(64, 3, little({0, 0x3ff80000, 0, 0xc0000000}, 4)) == std::vector<float>{1.5f, -2});
  CHECK(contains(error_of({.bits = 24}, "abc"), "unsupported samples in a TIFF file of 24 bits per sample"));
  CHECK(contains(error_of({.bits = 16, .format = 4}, "ab"), "unsupported samples"));
  for (const std::uint32_t bits : {1u, 12u, 64u})
    CHECK(contains(error_of({.bits = bits, .format = 2}, "12345678"), "unsupported samples"));
  CHECK(contains(error_of({.bits = 0}, "12345678"), "cannot read the image"));
  CHECK(contains(error_of({.bits = 8, .format = 3}, "a"), "unsupported samples"));
}

TEST_CASE("TIFF: packed integers, and white as zero") {
  CHECK(read({.width = 3, .bits = 1}, "\xa0").bytes == std::vector<std::uint8_t>{255, 0, 255});
  CHECK(read({.width = 3, .bits = 2}, "\x1c").bytes == std::vector<std::uint8_t>{0, 85, 255});
  CHECK(read({.width = 3, .bits = 4}, std::string("\x0f\x50", 2)).bytes == std::vector<std::uint8_t>{0, 255, 85});
  const StoredImage twelve = read({.width = 2, .bits = 12}, std::string("\xff\xf8\x00", 3));
  CHECK(twelve.floats == std::vector<float>{1, (0x800 * 65535 / 4095) * (1 / 65535.0f)});
  CHECK(read({.width = 2, .bits = 4, .photometric = 0}, "\x0f").bytes == std::vector<std::uint8_t>{255, 0});
  CHECK(read({.width = 2, .photometric = 0}, std::string("\x01\x00", 2)).bytes == std::vector<std::uint8_t>{254, 255});
  CHECK(read({.width = 2, .bits = 16, .photometric = 0}, little({0xffff, 0}, 2)).floats == std::vector<float>{0, 1});
}

TEST_CASE("TIFF: names of channels") {
  const auto names = [](std::uint32_t samples, std::uint32_t photometric, const std::vector<std::uint32_t>& extra) {
    const TiffSample sample{.samples = samples, .photometric = photometric, .extra_samples = extra};
    return read(sample, std::string(samples, 'x')).channels;
  };
  CHECK(names(1, 1, {}) == Names{"Y"});
  CHECK(names(2, 1, {2}) == Names{"Y", "A"});
  CHECK(names(2, 1, {0}) == Names{"R", "G"});
  CHECK(names(3, 2, {}) == Names{"R", "G", "B"});
  CHECK(names(4, 2, {1}) == Names{"R", "G", "B", "A"});
  CHECK(names(4, 2, {0}) == Names{"R", "G", "B", "channel3"});
  CHECK(names(5, 2, {2, 0}) == Names{"R", "G", "B", "A", "channel4"});
  CHECK(names(5, 2, {0, 2}) == Names{"R", "G", "B", "channel3", "A"});
  CHECK(names(5, 5, {}) == Names{"ink0", "ink1", "ink2", "ink3", "ink4"});
}

TEST_CASE("TIFF: colors are as stored whether they are multiplied by alpha or not") {
  for (const std::uint32_t kind : {1u, 2u}) {
    const TiffSample sample{.samples = 4, .photometric = 2, .extra_samples = {kind}};
    CHECK(read(sample, "\x10\x20\x30\x40").bytes == std::vector<std::uint8_t>{16, 32, 48, 64});
  }
}

TEST_CASE("TIFF: planes, palettes and CMYK become interleaved RGB") {
  const std::vector<std::uint8_t> rgb{1, 2, 3, 4, 5, 6};
  CHECK(read({.width = 2, .samples = 3, .photometric = 2, .is_separate = true}, "\1\4\2\5\3\6").bytes == rgb);
  TiffSample palette{.width = 2, .bits = 1, .photometric = 3};
  palette.palette = {1 * 257 + 100, 4 * 257, 2 * 257, 5 * 257, 3 * 257, 6 * 257};
  CHECK(read(palette, "\x40").bytes == rgb);
  CHECK(contains(error_of({.bits = 1, .photometric = 3}, "\x40"), "cannot read the image"));
  const std::vector<std::uint8_t> mixed{255, 0, 102, 102, 102, 102};  // 0.8 x 0.5 of 255
  const TiffSample cmyk{.width = 2, .samples = 4, .photometric = 5};
  const std::string contiguous("\x00\xff\x99\x00\x33\x33\x33\x80", 8), separate("\x00\x33\xff\x33\x99\x33\x00\x80", 8);
  CHECK(read(cmyk, contiguous).bytes == mixed);
  TiffSample planes = cmyk;
  planes.is_separate = true;
  CHECK(read(planes, separate).bytes == mixed);
  CHECK(contains(error_of({.bits = 32, .samples = 4, .photometric = 5}, std::string(16, '\0')), "unsupported CMYK"));
}

TEST_CASE("TIFF: a truncated or damaged file is an error with its name, or read") {
  const TemporaryFolder folder;
  const std::string whole = tiff_file({.width = 5, .height = 3, .samples = 3, .photometric = 2}, std::string(45, 'x'));
  for (std::size_t at = 4; at < whole.size(); ++at)
    for (const std::string& bytes : {whole.substr(0, at), whole.substr(0, at) + '\xff' + whole.substr(at + 1)}) {
      CAPTURE(at);
      write_bytes(folder / "a.tif", bytes);
      try {
        (void)read_stored_image(folder / "a.tif");
      } catch (const std::exception& error) { CHECK(contains(error.what(), "a.tif")); }
    }
}

TEST_CASE("TIFF: errors of libtiff are reported, and unknown orientations ignored") {
  const TemporaryFolder folder;
  const std::vector<std::uint8_t> values(64 * 64, 7);
  std::string problem;
  std::vector<unsigned char> bytes = encode_tiff({64, 64, 1, false, 8, values.data()}, "", problem);
  const auto message = [&] {
    write_bytes(folder / "a.tif", std::string(bytes.begin(), bytes.end()));
    try {
      (void)read_stored_image(folder / "a.tif");
    } catch (const SceneError& error) { return std::string(error.what()); }
    return std::string();
  };
  CHECK(message().empty());
  const std::string orientation("\x12\x01\x03\0\x01\0\0\0\x01", 9);  // tag 274, one value
  const auto tag = std::search(bytes.begin(), bytes.end(), orientation.begin(), orientation.end());
  REQUIRE(tag != bytes.end());
  for (const unsigned char unknown : {0, 9}) {
    tag[8] = unknown;
    CHECK(message().empty());
  }
  for (std::size_t i = 10; i < 20; ++i) bytes[i] = 0xff;  // in the first strip
  CHECK(contains(message(), "ecoding error"));
}

TEST_CASE("TIFF: encoded values are read as they were") {
  const TemporaryFolder folder;
  std::vector<std::uint16_t> values(7 * 70 * 4);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::uint16_t>(i * 7919);
  for (const int bits : {8, 16})
    for (const int channels : {1, 2, 3, 4}) {
      CAPTURE(bits);
      CAPTURE(channels);
      std::string problem;
      const IntegerPixels pixels{7, 70, channels, channels % 2 == 0, bits, values.data()};
      const std::vector<unsigned char> bytes = encode_tiff(pixels, "a description", problem);
      CHECK(problem.empty());
      const std::string text(bytes.begin(), bytes.end());
      CHECK(contains(text, "a description"));
      write_bytes(folder / "a.tif", text);
      const StoredImage image = read_stored_image(folder / "a.tif");
      CHECK(image.width == 7);
      CHECK(image.height == 70);
      CHECK(image.channels.back() == (channels == 1 ? "Y" : channels == 3 ? "B" : "A"));
      const std::size_t count = 7 * 70 * static_cast<std::size_t>(channels);
      bool is_equal = (bits == 8 ? image.bytes.size() : image.floats.size()) == count;
      for (std::size_t i = 0; is_equal && i < count; ++i)
        is_equal = bits == 8 ? image.bytes[i] == reinterpret_cast<const std::uint8_t*>(values.data())[i]
                             : image.floats[i] == static_cast<float>(values[i]) * (1 / 65535.0f);
      CHECK(is_equal);
    }
}

}  // namespace sheaf::test_tiff
