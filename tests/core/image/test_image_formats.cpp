// Reading of the formats without a library: BMP, TGA, Radiance, PBM, PGM, PPM and PFM.
#include "core/image/image.h"

#include "core/image/exr.h"
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

TEST_CASE("image files: the header gives the memory of the values") {
  const TemporaryFolder folder;
  Image image(5, 3, {"R", "G", "B", "A"});
  image.frame_width = 8;
  image.x0 = 1;
  write_exr(folder / "a.exr", image, {});
  CHECK(stored_image_bytes(folder / "a.exr") == 8 * 3 * 4 * 4);
  write_bytes(folder / "a.bmp", bmp(2, 1, 8, 0, "\1\1\1\0\7\7\7\0"s, "\1\0\0\0"s, 2));
  CHECK(stored_image_bytes(folder / "a.bmp") == 2);
  write_bytes(folder / "a.pfm", "PF\n2 1\n-1\n" + std::string(24, '\0'));
  CHECK(stored_image_bytes(folder / "a.pfm") == 2 * 3 * 4);
  write_bytes(folder / "a.ppm", "P6 9");
  CHECK(stored_image_bytes(folder / "a.ppm") == 0);
  CHECK(stored_image_bytes(folder / "none.png") == 0);
}

TEST_CASE("BMP: palettes, masks and alpha") {
  CHECK(read("a", bmp(2, 1, 1, 0, kTwoColors, "\x40\0\0\0"s, 2)).bytes == Bytes{3, 2, 1, 6, 5, 4});
  CHECK(read("a", bmp(2, 2, 4, 0, kTwoColors, "\x10\0\0\0\x01\0\0\0"s, 2)).bytes ==
        Bytes{3, 2, 1, 6, 5, 4, 6, 5, 4, 3, 2, 1});
  CHECK(read("a", bmp(2, -2, 4, 0, kTwoColors, "\x10\0\0\0\x01\0\0\0"s, 2)).bytes ==
        Bytes{6, 5, 4, 3, 2, 1, 3, 2, 1, 6, 5, 4});
  const StoredImage gray = read("a", bmp(2, 1, 8, 0, "\1\1\1\0\7\7\7\0"s, "\1\0\0\0"s, 2));
  CHECK(gray.channels == std::vector<std::string>{"Y"});
  CHECK(gray.bytes == Bytes{7, 1});
  CHECK(read("a", bmp(1, 1, 8, 0, kTwoColors, "\x98\0\0\0"s, 2)).bytes == Bytes{6, 5, 4});  // beyond the palette
  CHECK(read("a", bmp(2, 1, 16, 0, "", "\x1f\x7c\x10\x00"s)).bytes == Bytes{255, 0, 255, 0, 0, 132});
  const std::string masks("\0\xf8\0\0\xe0\7\0\0\x1f\0\0\0", 12);  // 5, 6 and 5 bits
  CHECK(read("a", bmp(2, 1, 16, 3, masks, "\xe0\x07\x20\x08"s)).bytes == Bytes{0, 255, 0, 8, 4, 0});
  CHECK(read("a", bmp(2, 1, 24, 0, "", "\1\2\3\4\5\6\0\0"s)).bytes == Bytes{3, 2, 1, 6, 5, 4});
  CHECK(read("a", bmp(1, 1, 32, 0, "", "\1\2\3\4"s)).bytes == Bytes{3, 2, 1, 4});
  CHECK(contains(error_of("a", bmp(1, 1, 24, 4, "", "\1\2\3\4"s)), "unknown BMP encoding: compression 4 with 24 bits"));
  for (const std::string& colors : {""s, std::string(1200, '\1')})
    CHECK(contains(error_of("a", bmp(1, 1, 8, 0, colors, "\0\0\0\0"s, 300)), "ends too early"));
  CHECK(contains(error_of("a", bmp(1, 2, 32, 0, "", "\1\2\3\4"s)), "ends too early"));
}

TEST_CASE("BMP: masks of 32 bits, and headers of other sizes") {
  const std::string reversed("\xff\0\0\0\0\xff\0\0\0\0\xff\0", 12);  // red in the lowest byte
  const std::string pixel = "\1\2\3\4"s;
  CHECK(read("a", bmp(1, 1, 32, 3, reversed, pixel)).bytes == Bytes{1, 2, 3, 4});
  const std::string ten_bits("\0\0\xf0\x3f\0\xfc\x0f\0\xff\3\0\0", 12);
  CHECK(read("a", bmp(1, 1, 32, 3, ten_bits, "\xff\xfb\xff\x1f"s)).bytes[2] == 255);
  CHECK(read("a", bmp(1, 1, 32, 3, ten_bits, "\xff\3\0\0"s)).bytes == Bytes{0, 0, 255, 0});
  CHECK(contains(error_of("a", bmp(1, 1, 32, 3, std::string(12, '\0'), pixel)), "a BMP color without bits"));
  // Headers from 56 bytes on have a mask of alpha; masks count only if the compression says so
  const auto longer = [&](std::uint32_t size, std::uint32_t compression, std::uint32_t bits, const std::string& masks,
                          const std::string& pixels) {
    std::string bytes = bmp(1, 1, bits, compression, masks + std::string(size - 40 - masks.size(), '\x7f'), pixels);
    bytes[14] = static_cast<char>(size);
    return read("a", bytes).bytes;
  };
  const std::string opaque("\0\0\0\0", 4), low_alpha("\1\0\0\0", 4);
  for (const std::uint32_t size : {56u, 108u, 124u}) {
    CAPTURE(size);
    CHECK(longer(size, 3, 32, reversed + opaque, pixel) == Bytes{1, 2, 3, 255});
    CHECK(longer(size, 3, 32, reversed + low_alpha, pixel) == Bytes{1, 2, 3, 255});
    CHECK(longer(size, 0, 32, reversed + opaque, pixel) == Bytes{3, 2, 1, 4});
    CHECK(longer(size, 0, 16, reversed + opaque, "\x1f\x7c\0\0"s) == Bytes{255, 0, 255});
  }
  CHECK(longer(52, 3, 32, reversed, pixel) == Bytes{1, 2, 3, 4});
  std::string unknown = bmp(1, 1, 24, 0, "", pixel);
  unknown[14] = 41;
  CHECK(contains(error_of("a", unknown), "unknown BMP header of 41 bytes"));
  // OS/2: sizes of 16 bits, and a palette of 3 bytes per color
  std::string old = "BM" + std::string(8, '\0') + "\x20\0\0\0\x0c\0\0\0\2\0\2\0\1\0\1\0"s;
  CHECK(read("a", old + "\1\2\3\4\5\6" + "\x40\0\0\0\x80\0\0\0"s).bytes == Bytes{6, 5, 4, 3, 2, 1, 3, 2, 1, 6, 5, 4});
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
  CHECK(indices(read("a", bmp(2, 2, 8, 1, kTwoColors, "\0\2\1\1\1\1\0\1"s, 2))) == "0100");  // moves up
  // Rows are stored from the bottom even if the height is negative; runs and literals end at the edge of the image
  CHECK(indices(read("a", bmp(2, -2, 8, 1, kTwoColors, "\2\1\0\0\2\0\0\1"s, 2))) == "0011");
  CHECK(indices(read("a", bmp(2, 2, 8, 1, kTwoColors, "\xff\1\0\0\0\4\1\1\1\1\0\1"s, 2))) == "1111");
  CHECK(contains(error_of("a", bmp(6, 2, 4, 1, kTwoColors, "\0\1"s, 2)), "compression 1 with 4 bits"));
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
  CHECK(read("a.tga", tga(3, 16, 2, 1, kTop, "\1\2\3\4")).bytes == Bytes{1, 3});
  CHECK(read("a.tga", tga(2, 16, 1, 1, kTop, "\x1f\x42"s)).bytes == Bytes{132, 132, 255});
  CHECK(read("a.tga", tga(2, 32, 1, 1, kTop, "\1\2\3\4")).bytes == Bytes{3, 2, 1, 4});
  std::string palette = tga(1, 8, 2, 1, kTop, "\1\2\3\4\5\6\x0b\x0a");
  palette[1] = 1;
  palette[3] = 10;  // index of the first color
  palette[5] = 2;
  palette[7] = 24;
  CHECK(read("a.tga", palette).bytes == Bytes{6, 5, 4, 3, 2, 1});
  for (const char outside : {9, 12}) {
    palette.back() = outside;
    CHECK(contains(error_of("a.tga", palette), "cannot read the image"));
  }
  // Pixels of two bytes, a run across rows, an image without a color map, and one with a name before it
  std::string indexed = tga(9, 16, 2, 2, kTop, "\x10\x20\x30\x40\x50\x60\x70\x80\x82\1\0\0\0\0"s);
  indexed[1] = 1;
  indexed[5] = 2;
  indexed[7] = 32;
  const StoredImage colors = read("a.tga", indexed);
  CHECK(colors.channels == std::vector<std::string>{"R", "G", "B", "A"});
  CHECK(colors.bytes ==
        Bytes{0x70, 0x60, 0x50, 0x80, 0x70, 0x60, 0x50, 0x80, 0x70, 0x60, 0x50, 0x80, 0x30, 0x20, 0x10, 0x40});
  std::string coarse = tga(1, 8, 2, 1, kTop, "\x00\x7c\x1f\0\1\0"s);
  coarse[1] = 1;
  coarse[5] = 2;
  coarse[7] = 15;
  CHECK(read("a.tga", coarse).bytes == Bytes{0, 0, 255, 255, 0, 0});
  std::string named = tga(2, 24, 1, 1, kTop, "name\1\2\3\4\5\6\7\x08\x09");
  named[0] = 4;
  named[1] = 1;
  named[5] = 2;
  named[7] = 24;
  CHECK(read("a.tga", named).bytes == Bytes{9, 8, 7});
  CHECK(contains(error_of("a.tga", named.substr(0, 25)), "ends too early"));
  for (const int type : {0, 4, 8, 12, 32, 33})
    CHECK(contains(error_of("a.tga", tga(type, 24, 1, 1, 0, "abc")), "unknown TGA encoding"));
  CHECK(contains(error_of("a.tga", "short"), "ends too early"));
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
  CHECK(read("a", "P4 8 2 \x7f\xfe").bytes == Bytes{255, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 255});
  CHECK(read("a", "P4 9 2 \x80\x80\x7f\x7f").bytes ==
        Bytes{0, 255, 255, 255, 255, 255, 255, 255, 0, 255, 0, 0, 0, 0, 0, 0, 0, 255});
  CHECK(read("a", "P5 2 1 256 \1\0\xff\xff"s).floats == Floats{1, 1});  // larger values are clamped
  CHECK(read("a", "P3 1 1 300 0 150 99999999999").floats == Floats{0, 32767 * (1 / 65535.0f), 1});
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
  CHECK(read("a", "Pf\n1 1\n+2e0\n" + big).floats == Floats{2});
  for (const char* const scale : {"0", "x", "nan", "-inf", "1e99"}) {
    CAPTURE(std::string(scale));
    CHECK(contains(error_of("a", std::string("PF\n1 1\n") + scale + "\n" + little), "expected a width, a height"));
  }
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
  CHECK(contains(error_of("a", head + "-Y 1 +X 99999999999\nabcd"), "expected a resolution"));
  CHECK(contains(error_of("a", head + "-Y -1 +X 1\nabcd"), "the image is empty"));
  // Wide rows without runs, and runs that are longer than the row or empty
  std::string flat;
  for (int i = 0; i < 9; ++i) flat += "\2\3\4\x88"s;
  CHECK(read("a", head + "-Y 1 +X 9\n" + flat).floats.back() == 4);
  const std::string component = "\x88\1";  // 8 times 1
  const auto runs = [&](const std::string& bytes) { return error_of("a", head + "-Y 1 +X 8\n" + bytes); };
  const std::string three = "\2\2\0\x08"s + component + component + component;
  CHECK(runs(three + component).empty());
  for (const char* const bytes : {"\x89\1", "\x87\1\x82\1",
                                  "\x09"
                                  "123456789",
                                  "\x07"
                                  "1234567\x82\1"})
    CHECK(contains(runs(three + bytes), "ends too early"));
  CHECK(contains(runs(three + "\0"s + component), "ends too early"));
  CHECK(contains(runs("\2\2\0\7"s + three.substr(4) + component), "ends too early"));  // rows of another width
}

}  // namespace sheaf::test_image_formats
