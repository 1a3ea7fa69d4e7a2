// JPEG and TIFF files, read back. tests/core/image/test_image.cpp covers PNG.
#include "core/color/color.h"
#include "core/image/image_encoding.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_image_encoding {

namespace {

/// A smooth image with alpha if there is a fourth channel; colors are premultiplied.
Image gradient(std::vector<std::string> channels) {
  Image image(40, 24, std::move(channels));
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const float alpha = image.channels.size() == 4 ? static_cast<float>(y + 1) / 24 : 1.0f;
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = alpha * static_cast<float>(x + 10 * c) / 60;
      if (image.channels.size() == 4) image.at(x, y, 3) = alpha;
    }
  return image;
}

IntegerEncoding encoding(IntegerFormat format) {
  IntegerEncoding encoding;
  encoding.format = format;
  return encoding;
}

/// Largest difference from the sRGB-encoded colors, straight or over black.
float max_error(const Image& file, const Image& image, bool straight) {
  float error = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const float alpha = straight && image.channels.size() == 4 ? image.at(x, y, 3) : 1.0f;
        error = std::max(error, std::abs(file.at(x, y, c) - linear_to_srgb(image.at(x, y, c) / alpha)));
      }
  return error;
}

}  // namespace

TEST_CASE("TIFF: 16 bits with straight alpha") {
  const TemporaryFolder folder;
  for (const bool has_alpha : {false, true}) {
    CAPTURE(has_alpha);
    const Image image =
        gradient(has_alpha ? std::vector<std::string>{"R", "G", "B", "A"} : std::vector<std::string>{"R", "G", "B"});
    write_encoded_image(folder / "a.tif", image, encoding(IntegerFormat::kTiff));
    const Image back = read_image(folder / "a.tif");
    REQUIRE(back.channels.size() == image.channels.size());
    CHECK(max_error(back, image, true) < 1.0f / 65535);
    if (has_alpha) CHECK(back.at(3, 5, 3) == near(0.25f, 1e-4));
    CHECK(read_stored_image(folder / "a.tif").bytes.empty());  // more than 8 bits
    write_encoded_image(folder / "b.tif", image, encoding(IntegerFormat::kTiff));
    CHECK(read_bytes(folder / "a.tif") == read_bytes(folder / "b.tif"));
  }
}

TEST_CASE("JPEG: colors over black, and a quality") {
  const TemporaryFolder folder;
  const Image image = gradient({"R", "G", "B", "A"});
  IntegerEncoding options = encoding(IntegerFormat::kJpeg);
  write_encoded_image(folder / "good.jpg", image, options);
  options.quality = 10;
  write_encoded_image(folder / "small.jpg", image, options);
  const Image good = read_image(folder / "good.jpg"), small = read_image(folder / "small.jpg");
  REQUIRE(good.channels.size() == 3);
  CHECK(max_error(good, image, false) < 0.04f);
  CHECK(max_error(small, image, false) > max_error(good, image, false));
  CHECK(read_bytes(folder / "small.jpg").size() < read_bytes(folder / "good.jpg").size());
}

TEST_CASE("JPEG and TIFF: gray images, descriptions and images without pixels") {
  const TemporaryFolder folder;
  Image gray(5, 4, {"depth"});
  for (float& value : gray.data) value = 0.5f;
  for (const IntegerFormat format : {IntegerFormat::kJpeg, IntegerFormat::kTiff}) {
    IntegerEncoding options = encoding(format);
    options.description = "the render was interrupted";
    write_encoded_image(folder / "grey", gray, options);
    const Image back = read_image(folder / "grey");
    CHECK(back.channels.size() == 1);
    CHECK(back.data[0] == near(linear_to_srgb(0.5f), 0.01));
    CHECK(read_bytes(folder / "grey").find("the render was interrupted") != std::string::npos);
    CHECK_THROWS(encode_image(Image(), options));
  }
}

}  // namespace sheaf::test_image_encoding
