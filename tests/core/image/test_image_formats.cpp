// Reading of the formats without a library: BMP, TGA, Radiance, PBM, PGM, PPM and PFM.
#include "core/image/image.h"
#include "core/io/error.h"
#include "tests/support/contains.h"
#include "tests/support/files/image_files.h"

#include <doctest/doctest.h>

#include <bit>

namespace sheaf::test_image_formats {

namespace {

using namespace std::string_literals;
using test::contains;
using Bytes = std::vector<std::uint8_t>;
using Floats = std::vector<float>;

StoredImage read(const std::string& name, const std::string& bytes) {
  const TemporaryFolder folder;
  write_bytes(folder / name, bytes);
  return read_stored_image(folder / name);
}

std::string error_of(const std::string& name, const std::string& bytes) {
  try {
    (void)read(name, bytes);
  } catch (const SceneError& error) { return error.what(); }
  return "";
}

/// A BMP file with a header of 40 bytes. `tables`: masks and palette.
std::string bmp(int width, int height, std::uint32_t bits, std::uint32_t compression, const std::string& tables,
                const std::string& pixels, std::uint32_t colors = 0) {
  std::string bytes = "BM";
  bytes.append(8, '\0');
  append_little(bytes, 54 + static_cast<std::uint32_t>(tables.size()), 4);
  for (const std::uint32_t field : {40u, static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)})
    append_little(bytes, field, 4);
  append_little(bytes, 1, 2);
  append_little(bytes, bits, 2);
  for (const std::uint32_t field : {compression, 0u, 0u, 0u, colors, 0u}) append_little(bytes, field, 4);
  return bytes + tables + pixels;
}

/// Two colors of a palette: (3, 2, 1) and (6, 5, 4).
const std::string kTwoColors("\1\2\3\0\4\5\6\0", 8);

std::string tga(int type, int bits, int width, int height, int attributes, const std::string& data) {
  std::string bytes{0, 0, static_cast<char>(type), 0, 0, 0, 0, 0, 0, 0, 0, 0};
  append_little(bytes, static_cast<std::uint32_t>(width), 2);
  append_little(bytes, static_cast<std::uint32_t>(height), 2);
  bytes += static_cast<char>(bits);
  bytes += static_cast<char>(attributes);
  return bytes + data;
}

}  // namespace

TEST_CASE("BMP: palettes, masks and alpha") {
  CHECK(read("a", bmp(2, 1, 1, 0, kTwoColors, "\x40\0\0\0"s, 2)).bytes == Bytes{3, 2, 1, 6, 5, 4});
  CHECK(read("a", bmp(2, 2, 4, 0, kTwoColors, "\x10\0\0\0\x01\0\0\0"s, 2)).bytes ==
        Bytes{3, 2, 1, 6, 5, 4, 6, 5, 4, 3, 2, 1});
  CHECK(read("a", bmp(2, -2, 4, 0, kTwoColors, "\x10\0\0\0\x01\0\0\0"s, 2)).bytes ==
        Bytes{6, 5, 4, 3, 2, 1, 3, 2, 1, 6, 5, 4});
  const StoredImage gray = read("a", bmp(2, 1, 8, 0, "\1\1\1\0\7\7\7\0"s, "\1\0\0\0"s, 2));
  CHECK(gray.channels == std::vector<std::string>{"Y"});
  CHECK(gray.bytes == Bytes{7, 1});
  CHECK(read("a", bmp(1, 1, 8, 0, kTwoColors, "\x99\0\0\0"s, 2)).bytes == Bytes{6, 5, 4});  // beyond the palette
  CHECK(read("a", bmp(2, 1, 16, 0, "", "\x1f\x7c\x10\x00"s)).bytes == Bytes{255, 0, 255, 0, 0, 132});
  const std::string masks("\0\xf8\0\0\xe0\7\0\0\x1f\0\0\0", 12);  // 5, 6 and 5 bits
  CHECK(read("a", bmp(2, 1, 16, 3, masks, "\xe0\x07\x20\x08"s)).bytes == Bytes{0, 255, 0, 8, 4, 0});
  CHECK(read("a", bmp(1, 1, 32, 0, "", "\1\2\3\4"s)).bytes == Bytes{3, 2, 1, 4});
  CHECK(contains(error_of("a", bmp(1, 1, 24, 4, "", "\1\2\3\4"s)), "unknown BMP encoding: compression 4 with 24 bits"));
  CHECK(contains(error_of("a", bmp(1, 1, 8, 0, "", ""s, 300)), "ends too early"));
  CHECK(contains(error_of("a", bmp(1, 2, 32, 0, "", "\1\2\3\4"s)), "ends too early"));
}

TEST_CASE("BMP: run-length encoding") {
  const auto indices = [](const StoredImage& image) {
    std::string text;
    for (std::size_t i = 0; i < image.bytes.size(); i += 3) text += image.bytes[i] == 6 ? '1' : '0';
    return text;
  };
  // A run, a literal with padding, the end of the row, a move, and the end of the image with and without one of the row
  for (const std::string& end : {"\0\1"s, "\0\0\0\1"s}) {
    CHECK(indices(read("a", bmp(6, 2, 8, 1, kTwoColors, "\2\1\0\3\0\1\0\0\0\0\0\2\3\0\3\1"s + end, 2))) ==
          "000111110100"
          "");
    CHECK(indices(read("a", bmp(6, 2, 4, 2, kTwoColors, "\5\x10\0\0\0\3\x01\x10"s + end, 2))) == "011000101010");
  }
  CHECK(contains(error_of("a", bmp(6, 2, 8, 1, kTwoColors, "\2\1"s, 2)), "ends too early"));
  CHECK(contains(error_of("a", bmp(6, 1, 8, 1, kTwoColors, "\0\0\2\1\0\1"s, 2)), "cannot read the image"));
}

TEST_CASE("TGA: depths, palettes, directions and runs") {
  constexpr int kTop = 0x20, kRight = 0x10, kAlpha = 8;
  CHECK(read("a.tga", tga(3, 8, 2, 2, kTop, "\1\2\3\4")).bytes == Bytes{1, 2, 3, 4});
  CHECK(read("a.tga", tga(3, 8, 2, 2, 0, "\1\2\3\4")).bytes == Bytes{3, 4, 1, 2});
  CHECK(read("a.tga", tga(3, 8, 2, 2, kTop | kRight, "\1\2\3\4")).bytes == Bytes{2, 1, 4, 3});
  CHECK(read("a.tga", tga(11, 8, 3, 2, kTop, "\x81\5\3\1\2\3\4"s)).bytes == Bytes{5, 5, 1, 2, 3, 4});
  const StoredImage gray = read("a.tga", tga(3, 16, 1, 1, kTop | kAlpha, "\1\2"));
  CHECK(gray.channels == std::vector<std::string>{"Y", "A"});
  CHECK(gray.bytes == Bytes{1, 2});
  CHECK(read("a.tga", tga(2, 16, 1, 1, kTop, "\x1f\x42"s)).bytes == Bytes{132, 132, 255});
  CHECK(read("a.tga", tga(2, 32, 1, 1, kTop, "\1\2\3\4")).bytes == Bytes{3, 2, 1, 4});
  std::string palette = tga(1, 8, 2, 1, kTop, "\1\2\3\4\5\6\x0b\x0a");
  palette[1] = 1;
  palette[3] = 10;  // index of the first color
  palette[5] = 2;
  palette[7] = 24;
  CHECK(read("a.tga", palette).bytes == Bytes{6, 5, 4, 3, 2, 1});
  palette.back() = 12;
  CHECK(contains(error_of("a.tga", palette), "cannot read the image"));
  CHECK(contains(error_of("a.tga", tga(2, 8, 1, 1, 0, "x")), "unknown TGA encoding: type 2 with 8 bits"));
  CHECK(contains(error_of("a.tga", tga(3, 8, 2, 2, 0, "\1\2\3")), "ends too early"));
  CHECK(contains(error_of("a.tga", tga(11, 8, 3, 2, 0, "\x81\5\3\1")), "ends too early"));
}

TEST_CASE("PBM, PGM and PPM: text and binary, scaled to the largest value") {
  CHECK(read("a", "P1 # two rows\n3 2\n1 0 1\n01\n0").bytes == Bytes{0, 255, 0, 255, 0, 255});
  CHECK(read("a", "P4 9 1 \xaa\x80").bytes == Bytes{0, 255, 0, 255, 0, 255, 0, 255, 0});
  CHECK(read("a", "P2 3 1 10 0 5 # half\n 11").bytes == Bytes{0, 127, 255});
  CHECK(read("a", "P3\n1 1\n255\n1 2 3").bytes == Bytes{1, 2, 3});
  CHECK(read("a", "P5 2 1 100\n\x32\x64"s).bytes == Bytes{127, 255});
  CHECK(read("a", "P6 1 1 65535\n\xff\xff\x80\0\0\1"s).floats == Floats{1, 0x8000 * (1 / 65535.0f), 1 / 65535.0f});
  for (const char* const text : {"P2 3 1 10 0 5", "P5 2 1 255 x", "P1 2 1 1 2", "P4 9 1 x"})
    CHECK(contains(error_of("a", text), "ends too early"));
  for (const char* const text : {"P2 3 1", "P5 2 1 0 x", "P5 2 1 65536 xx", "P5 x"})
    CHECK(contains(error_of("a", text), "expected a width, a height and a largest value"));
}

TEST_CASE("PFM: rows from the bottom in either byte order, multiplied by the scale") {
  std::string little, big;
  for (const float value : {1.0f, 2.0f, 3.0f}) append_little(little, std::bit_cast<std::uint32_t>(value), 4);
  for (std::size_t i = 0; i < little.size(); ++i) big += little[i / 4 * 4 + 3 - i % 4];
  CHECK(read("a", "Pf\n1 3\n-1.0\n" + little).floats == Floats{3, 2, 1});
  CHECK(read("a", "Pf\n1 3\n2\n" + big).floats == Floats{6, 4, 2});
  CHECK(read("a", "PF\n1 1\n-0.5\n" + little).floats == Floats{0.5f, 1, 1.5f});
  CHECK(contains(error_of("a", "PF\n1 2\n-1\n" + little), "ends too early"));
  CHECK(contains(error_of("a", "PF\n1 1\n0\n" + little), "expected a width, a height and a scale"));
}

TEST_CASE("Radiance: runs, and errors of the header") {
  const std::string head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";
  const std::string row = "\2\2\0\x08\x88\1\x84\2\4\3\4\5\6\x88\0\x88\x89"s;  // 1; 2 2 2 2 3 4 5 6; 0; exponent 137
  const StoredImage image = read("a", head + "-Y 1 +X 8\n" + row);
  CHECK_FALSE(image.integers);
  CHECK(Floats(image.floats.begin(), image.floats.begin() + 3) == Floats{2, 4, 0});
  CHECK(Floats(image.floats.end() - 3, image.floats.end()) == Floats{2, 12, 0});
  CHECK(read("a", head + "-Y 1 +X 1\n\1\2\3\0"s).floats == Floats{0, 0, 0});
  CHECK(contains(error_of("a", head + "-Y 1 +X 8\n" + row.substr(0, row.size() - 1)), "ends too early"));
  CHECK(contains(error_of("a", head + "-Y 1 +X 9\n" + row), "ends too early"));
  CHECK(contains(error_of("a", "#?RADIANCE\n\n-Y 1 +X 1\nabcd"), "expected FORMAT=32-bit_rle_rgbe"));
  CHECK(contains(error_of("a", head + "-Y 1 -Y 1\nabcd"), "expected a resolution"));
}

}  // namespace sheaf::test_image_formats
