// Radiance HDR and TIFF files whose first pixel is not top left, whose colors are CIE XYZ, or that omit BitsPerSample.
#include "core/image/image.h"
#include "core/image/image_orientation.h"
#include "core/io/error.h"
#include "tests/support/contains.h"
#include "tests/support/files/image_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <functional>

namespace sheaf::test_image_orientation {

using test::contains;

namespace {

/// 3 x 2 pixels in rows, top left first.
constexpr int kWidth = 3, kHeight = 2;
const std::vector<int> kUpright{1, 2, 3, 4, 5, 6};

/// The pixels in the order of a file. `first` and `second` are the axes of its resolution string.
std::vector<int> stored(const std::string& first, const std::string& second) {
  const auto positions = [](const std::string& axis) {
    std::vector<int> all;
    for (int i = 0; i < (axis[1] == 'X' ? kWidth : kHeight); ++i) all.push_back(i);
    if (axis == "-X" || axis == "+Y") std::reverse(all.begin(), all.end());
    return all;
  };
  std::vector<int> out;
  for (const int i : positions(first))
    for (const int j : positions(second)) {
      const int x = first[1] == 'X' ? i : j, y = first[1] == 'X' ? j : i;
      out.push_back(kUpright[static_cast<std::size_t>(kWidth * y + x)]);
    }
  return out;
}

std::string size_of(const std::string& axis) { return std::to_string(axis[1] == 'X' ? kWidth : kHeight); }

void check_upright(const std::filesystem::path& file, const std::function<float(int)>& value) {
  const Image image = read_image(file);
  const StoredImage stored = read_stored_image(file);
  REQUIRE(image.width == kWidth);
  REQUIRE(image.height == kHeight);
  REQUIRE(image.frame_width == kWidth);
  REQUIRE(image.frame_height == kHeight);
  REQUIRE(stored.width == kWidth);
  REQUIRE(stored.height == kHeight);
  const std::size_t channels = image.channels.size();
  for (std::size_t i = 0; i < kUpright.size(); ++i) {
    const float expected = value(kUpright[i]);
    CHECK(image.data[channels * i] == near(expected));
    CHECK((stored.bytes.empty() ? stored.floats[channels * i]
                                : static_cast<float>(stored.bytes[channels * i]) / 255.0f) == near(expected));
  }
}

/// TIFF orientations as axes of a resolution string.
const std::vector<std::pair<std::string, std::string>> kOrders{{"-Y", "+X"}, {"-Y", "-X"}, {"+Y", "-X"}, {"+Y", "+X"},
                                                               {"+X", "-Y"}, {"-X", "-Y"}, {"-X", "+Y"}, {"+X", "+Y"}};

/// A big-endian or little-endian TIFF with one strip.
class TiffBytes {
 public:
  explicit TiffBytes(bool big_endian) : big_endian_(big_endian) {
    bytes_ = big_endian ? "MM" : "II";
    number(42, 2);
  }
  void number(std::uint32_t value, int count) {
    for (int i = 0; i < count; ++i) bytes_ += static_cast<char>(value >> 8 * (big_endian_ ? count - 1 - i : i) & 0xffu);
  }
  /// The strip is at offset 8, the directory follows it.
  std::string finish(std::string strip, const std::vector<TiffEntry>& entries) {
    if (strip.size() % 2 != 0) strip += '\0';
    number(8 + static_cast<std::uint32_t>(strip.size()), 4);
    bytes_ += strip;
    number(static_cast<std::uint32_t>(entries.size()), 2);
    for (const auto& [tag, type, count, value] : entries) {
      number(tag, 2);
      number(type, 2);
      number(count, 4);
      number(value, type == 3 ? 2 : 4);
      if (type == 3) number(0, 2);
    }
    number(0, 4);
    return bytes_;
  }

 private:
  bool big_endian_;
  std::string bytes_;
};

/// Directory entries of a bilevel image of 12 x 2 pixels in `strip_bytes`, without BitsPerSample and SamplesPerPixel.
std::vector<TiffEntry> bilevel(std::uint32_t photometric, std::uint32_t compression, std::uint32_t strip_bytes) {
  return {{256, 4, 1, 12}, {257, 4, 1, 2}, {259, 3, 1, compression}, {262, 3, 1, photometric},
          {273, 4, 1, 8},  {278, 4, 1, 2}, {279, 4, 1, strip_bytes}};
}

}  // namespace

TEST_CASE("image orientation: Radiance files are read upright in all eight orders") {
  const TemporaryFolder folder;
  for (const auto& order : kOrders) {
    const std::string &first = order.first, &second = order.second;
    CAPTURE(first);
    CAPTURE(second);
    std::string bytes = "#?RADIANCE\n# a comment\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1\n\n" + first + " " +
                        size_of(first) + " " + second + " " + size_of(second) + "\n";
    for (const int value : stored(first, second)) {
      for (int c = 0; c < 3; ++c) bytes += static_cast<char>(value);
      bytes += static_cast<char>(128 + 8);
    }
    write_bytes(folder / "a.hdr", bytes);
    check_upright(folder / "a.hdr", [](int value) { return static_cast<float>(value); });
  }
}

TEST_CASE("image orientation: TIFF files are read upright in all eight orders and in tiles and in either byte order") {
  const TemporaryFolder folder;
  for (std::uint32_t orientation = 1; orientation <= 8; ++orientation) {
    CAPTURE(orientation);
    const auto& [first, second] = kOrders[orientation - 1];
    const std::vector<int> values = stored(first, second);
    const bool transposed = first[1] == 'X';
    const auto width = static_cast<std::uint32_t>(transposed ? kHeight : kWidth),
               height = static_cast<std::uint32_t>(transposed ? kWidth : kHeight);
    for (const bool big_endian : {false, true})
      for (const std::uint32_t bits : {8u, 16u}) {
        std::string strip;
        for (const int value : values) {
          if (bits == 16 && big_endian) strip += '\0';
          strip += static_cast<char>(value);
          if (bits == 16 && !big_endian) strip += '\0';
        }
        const auto size = static_cast<std::uint32_t>(strip.size());
        write_bytes(folder / "a.tif", TiffBytes(big_endian)
                                          .finish(strip, {{256, 4, 1, width},
                                                          {257, 4, 1, height},
                                                          {258, 3, 1, bits},
                                                          {259, 3, 1, 1},
                                                          {262, 3, 1, 1},
                                                          {273, 4, 1, 8},
                                                          {274, 3, 1, orientation},
                                                          {277, 3, 1, 1},
                                                          {278, 4, 1, height},
                                                          {279, 4, 1, size}}));
        check_upright(folder / "a.tif",
                      [&](int value) { return static_cast<float>(value) / (bits == 8 ? 255.0f : 65535.0f); });
      }
    std::string tile(256, '\0');
    for (std::size_t i = 0; i < values.size(); ++i) tile[i / width * 16 + i % width] = static_cast<char>(values[i]);
    write_bytes(folder / "b.tif", TiffBytes(false).finish(tile, {{256, 4, 1, width},
                                                                 {257, 4, 1, height},
                                                                 {258, 3, 1, 8},
                                                                 {259, 3, 1, 1},
                                                                 {262, 3, 1, 1},
                                                                 {274, 3, 1, orientation},
                                                                 {277, 3, 1, 1},
                                                                 {322, 4, 1, 16},
                                                                 {323, 4, 1, 16},
                                                                 {324, 4, 1, 8},
                                                                 {325, 4, 1, 256}}));
    check_upright(folder / "b.tif", [](int value) { return static_cast<float>(value) / 255.0f; });
  }
}

TEST_CASE("image orientation: channels of a pixel stay together") {
  const std::vector<int> pixels{1, 10, 2, 20, 3, 30, 4, 40, 5, 50, 6, 60};
  CHECK(oriented(pixels, 3, 2, 2, 3) == std::vector<int>{6, 60, 5, 50, 4, 40, 3, 30, 2, 20, 1, 10});
  CHECK(oriented(pixels, 3, 2, 2, 6) == std::vector<int>{4, 40, 1, 10, 5, 50, 2, 20, 6, 60, 3, 30});
}

TEST_CASE("images: bilevel TIFF files without BitsPerSample have one bit in both photometric interpretations") {
  const TemporaryFolder folder;
  // Two rows of 12 pixels: 1 1 1 1 0 0 0 0 1 0 1 0 and 0 0 0 0 0 0 0 1 1 1 1 1.
  const std::string rows("\xf0\xa0\x01\xf0", 4);
  const std::string packed("\x01\xf0\xa0\x01\x01\xf0", 6);  // PackBits: two bytes follow
  const std::vector<int> set{1, 1, 1, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1};
  for (const bool big_endian : {false, true})
    for (const std::uint32_t photometric : {0u, 1u})
      for (const bool is_packed : {false, true}) {
        CAPTURE(big_endian);
        CAPTURE(photometric);
        CAPTURE(is_packed);
        const std::string& strip = is_packed ? packed : rows;
        write_bytes(folder / "a.tif", TiffBytes(big_endian)
                                          .finish(strip, bilevel(photometric, is_packed ? 32773 : 1,
                                                                 static_cast<std::uint32_t>(strip.size()))));
        const StoredImage image = read_stored_image(folder / "a.tif");
        REQUIRE(image.width == 12);
        REQUIRE(image.height == 2);
        REQUIRE(image.bytes.size() == 24);
        for (std::size_t i = 0; i < 24; ++i) {
          const bool is_white = (set[i] == 1) == (photometric == 1);
          CHECK(static_cast<int>(image.bytes[i]) == (is_white ? 255 : 0));
        }
      }
}

TEST_CASE("images: a wrong or truncated TIFF directory is reported or left to the library") {
  const TemporaryFolder folder;
  const std::string whole = TiffBytes(false).finish("\xf0\xa0\x01\xf0", bilevel(1, 1, 4));
  for (std::size_t size = 4; size < whole.size(); ++size) {
    write_bytes(folder / "a.tif", whole.substr(0, size));
    try {
      (void)read_stored_image(folder / "a.tif");
    } catch (const SceneError& error) { CHECK(contains(error.what(), "a.tif")); }
  }
  for (const std::string& end : {std::string("\xff\xff\xff\x7f"), std::string("\x04\0\0\0", 4)}) {
    write_bytes(folder / "a.tif", "II*" + std::string(1, '\0') + end + whole.substr(8));
    CHECK_THROWS_AS(read_stored_image(folder / "a.tif"), SceneError);
  }
}

TEST_CASE("images: Radiance files of CIE XYZ are converted to Rec.709 unless raw") {
  const TemporaryFolder folder;
  std::string bytes = "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n";
  for (const int byte : {102, 204, 51, 128}) bytes += static_cast<char>(byte);
  write_bytes(folder / "a.hdr", bytes);
  const StoredImage raw = read_stored_image(folder / "a.hdr", true), image = read_stored_image(folder / "a.hdr");
  REQUIRE(raw.floats.size() == 3);
  const double x = 102 / 256.0, y = 204 / 256.0, z = 51 / 256.0;
  CHECK(raw.floats[0] == near(x, 0.01));
  CHECK(image.floats[0] == near(3.2409699 * x - 1.5373832 * y - 0.4986108 * z, 0.02));
  CHECK(image.floats[1] == near(-0.9692436 * x + 1.8759675 * y + 0.0415551 * z, 0.02));
  CHECK(image.floats[2] == near(0.0556301 * x - 0.2039770 * y + 1.0569715 * z, 0.02));
}

}  // namespace sheaf::test_image_orientation
