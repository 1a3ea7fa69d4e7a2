// Image files in memory, and WebP files.
#include "core/image/image.h"
#include "core/io/error.h"
#include "tests/support/contains.h"
#include "tests/support/files/image_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cstdlib>

namespace sheaf::test_encoded_image {

namespace {

using test::contains;

EncodedImage encoded(const std::string& bytes) { return {{bytes.begin(), bytes.end()}, "model.glb: image 3"}; }

std::string error_of(const std::string& bytes) {
  try {
    (void)read_stored_image(encoded(bytes));
  } catch (const SceneError& error) { return error.what(); }
  return "";
}

/// A PNG file of 3 x 2 pixels with alpha.
std::string png_bytes(const TemporaryFolder& folder) {
  Image image(3, 2, {"R", "G", "B", "A"});
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<float>(i % 7) / 7;
  write_png(folder / "a.png", image);
  return read_bytes(folder / "a.png");
}

std::string jpeg_bytes(const TemporaryFolder& folder) {
  write_jpeg(folder / "a.jpg", 200);
  return read_bytes(folder / "a.jpg");
}

const std::vector<int> kRgba = {200, 30, 7, 255, 100, 30, 7, 128, 200, 90, 7, 255,
                                100, 90, 7, 128, 200, 30, 7, 128, 100, 90, 7, 255};

}  // namespace

TEST_CASE("encoded images: PNG, JPEG and WebP in memory are read like files") {
  const TemporaryFolder folder;
  const std::string files[] = {png_bytes(folder), jpeg_bytes(folder), webp_bytes(3, 2, kRgba)};
  for (const std::string& bytes : files) {
    write_bytes(folder / "any", bytes);
    const StoredImage from_file = read_stored_image(folder / "any"), image = read_stored_image(encoded(bytes));
    CHECK(!image.bytes.empty());
    CHECK(image.bytes == from_file.bytes);
    CHECK(image.channels == from_file.channels);
    CHECK(image.integers);
    CHECK(image.width == from_file.width);
    CHECK(image.height == from_file.height);
  }
  const StoredImage png = read_stored_image(encoded(files[0]));
  CHECK(png.width == 3);
  CHECK(png.height == 2);
  CHECK(png.channels == std::vector<std::string>{"R", "G", "B", "A"});
  CHECK(read_stored_image(encoded(files[1])).bytes == std::vector<std::uint8_t>(64, 200));
}

TEST_CASE("encoded images: colors of WebP files are not multiplied by alpha") {
  const TemporaryFolder folder;
  const StoredImage image = read_stored_image(encoded(webp_bytes(3, 2, kRgba)));
  REQUIRE(image.bytes.size() == kRgba.size());
  for (std::size_t i = 0; i < kRgba.size(); ++i) CHECK(std::abs(int{image.bytes[i]} - kRgba[i]) <= 1);
  for (std::size_t i = 0; i < kRgba.size(); i += 4) {
    CHECK(image.bytes[i + 3] == kRgba[i + 3]);
    if (kRgba[i + 3] == 255) CHECK(image.bytes[i] == kRgba[i]);
  }
  write_bytes(folder / "a.webp", webp_bytes(3, 2, kRgba));
  const Image floats = read_image(folder / "a.webp");
  // To one level, and the rounding of halves
  for (std::size_t i = 0; i < kRgba.size(); ++i) CHECK(floats.data[i] == within(kRgba[i] / 255.0, 1.05 / 255));
  // Without alpha, and with colors that are invisible
  const StoredImage opaque = read_stored_image(encoded(webp_bytes(1, 2, {1, 2, 3, 255, 4, 5, 6, 255}, false)));
  CHECK(opaque.channels.size() == 3);
  CHECK(opaque.bytes == std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6});
  CHECK(read_stored_image(encoded(webp_bytes(1, 1, {9, 9, 9, 0}))).bytes[3] == 0);
}

TEST_CASE("encoded images: the first frame of a WebP animation lies on transparent black") {
  const std::string frame = webp_bytes(3, 2, kRgba).substr(12);  // its chunk
  const auto chunk = [](const std::string& name, const std::string& data) {
    std::string bytes = name;
    append_little(bytes, static_cast<std::uint32_t>(data.size()), 4);
    return bytes + data;
  };
  const auto animation = [&](char flags, int width) {
    const std::string size{static_cast<char>(width - 1), 0, 0, 3, 0, 0};  // x 4
    const std::string place("\1\0\0\1\0\0\2\0\0\1\0\0\x20\0\0\0", 16);    // at 2, 2: 3 x 2 pixels
    std::string bytes = "WEBP" + chunk("VP8X", std::string{flags, 0, 0, 0} + size) +
                        chunk("ANIM", std::string(6, '\0')) + chunk("ANMF", place + frame) +
                        chunk("ANMF", place + frame);
    return chunk("RIFF", bytes);
  };
  const StoredImage image = read_stored_image(encoded(animation(0x12, 6)));
  CHECK(image.channels.size() == 4);
  REQUIRE(image.bytes.size() == 6 * 4 * 4);
  for (std::size_t y = 0; y < 4; ++y)
    for (std::size_t x = 0; x < 6; ++x)
      for (std::size_t c = 0; c < 4; ++c) {
        const bool is_inside = x >= 2 && x < 5 && y >= 2;
        const int expected = is_inside ? kRgba[((y - 2) * 3 + x - 2) * 4 + c] : 0;
        CHECK(std::abs(int{image.bytes[(y * 6 + x) * 4 + c]} - expected) <= 1);
      }
  CHECK(read_stored_image(encoded(animation(0x02, 6))).channels.size() == 3);  // the header declares no alpha
  // Frames beyond the canvas, and files that end after the first header
  CHECK(contains(error_of(animation(0x12, 4)), "ends too early"));
  CHECK(contains(error_of(animation(0x12, 6).substr(0, 60)), "ends too early"));
  // Bytes after the end of the file do not count
  const TemporaryFolder folder;
  write_bytes(folder / "a.webp", animation(0x12, 6) + std::string(1000, 'x'));
  CHECK(read_stored_image(folder / "a.webp").bytes == image.bytes);
}

TEST_CASE("encoded images: large WebP images of one color are valid") {
  std::vector<int> values;
  for (int i = 0; i < 1024 * 1024; ++i) values.insert(values.end(), {128, 128, 255, 255});
  const std::string bytes = webp_bytes(1024, 1024, values, false);
  CHECK(bytes.size() < 64);
  CHECK(read_stored_image(encoded(bytes)).bytes.size() == std::size_t{3} << 20);
}

TEST_CASE("encoded images: other formats and damaged files are errors with the name") {
  const TemporaryFolder folder;
  const std::vector<int> rgb = {0, 1, 2, 50, 51, 52, 100, 101, 102, 150, 151, 152, 200, 201, 202, 250, 251, 252};
  write_tiff(folder / "a.tif", 3, 2, 3, 16, rgb);
  write_hdr(folder / "a.hdr", 3, 2, rgb);
  write_bmp(folder / "a.bmp", 3, 2, rgb);
  write_tga(folder / "a.tga", 3, 2, 3, rgb);
  write_pnm(folder / "a.ppm", 3, 2, 3, 255, rgb);
  for (const char* const name : {"a.tif", "a.hdr", "a.bmp", "a.tga", "a.ppm"})
    CHECK(error_of(read_bytes(folder / name)) ==
          "model.glb: image 3: cannot read the image: expected PNG, JPEG or WebP");
  CHECK(contains(error_of("v/1\x01 and so on"), "expected PNG, JPEG or WebP"));
  CHECK(contains(error_of(""), "expected PNG, JPEG or WebP"));
  for (const std::string& bytes : {png_bytes(folder), jpeg_bytes(folder), webp_bytes(3, 2, kRgba)}) {
    // The libraries accept files without their last chunk, marker or padding, at most 12 bytes.
    for (std::size_t size = 0; size + 12 < bytes.size(); ++size) {
      CAPTURE(size);
      CHECK(contains(error_of(bytes.substr(0, size)), "model.glb: image 3: "));
    }
  }
}

TEST_CASE("encoded images: sizes are checked before the library allocates") {
  const TemporaryFolder folder;
  // A PNG chunk of 1.8 GB
  std::string png = png_bytes(folder);
  png.insert(png.find("IEND") - 4, std::string("\x6c\0\0\5tEXta\0b c\0\0\0\0", 17));
  CHECK(contains(error_of(png), "ends too early"));
  // WebP files of each kind that claim too many pixels
  std::string lossless = webp_bytes(3, 2, kRgba);
  CHECK(error_of(lossless).empty());
  lossless.replace(21, 4, "\xff\xff\xff\x1f");
  CHECK(contains(error_of(lossless), "the header claims 16384 x 16384 pixels with 4 channels"));
  const auto webp = [](const std::string& chunk) { return "RIFF" + std::string("\x40\0\0\0", 4) + "WEBP" + chunk; };
  const std::string lossy("VP8 \x20\0\0\0\0\0\0\x9d\x01\x2a\xff\x3f\xff\x3f", 18);
  CHECK(contains(error_of(webp(lossy)), "the header claims 16383 x 16383 pixels"));
  const std::string extended("VP8X\x0a\0\0\0\0\0\0\0\xff\xff\xff\x01\0\0", 18);
  CHECK(contains(error_of(webp(extended)), "the image is too large: 16777216 x 2 pixels"));
  const std::string high("VP8X\x0a\0\0\0\0\0\0\0\1\0\0\xff\xff\xff", 18);
  CHECK(contains(error_of(webp(high)), "the image is too large: 2 x 16777216 pixels"));
  for (const std::string& chunk : {"ABCD\x04" + std::string(20, '\0'), std::string()})
    CHECK(contains(error_of(webp(chunk)), "the WebP header is damaged"));
}

}  // namespace sheaf::test_encoded_image
