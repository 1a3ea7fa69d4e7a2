// Single channels of images as textures, and textures of encoded images in memory.
#include "core/color/color.h"
#include "core/image/exr.h"
#include "core/image/image.h"
#include "core/io/error.h"
#include "scene/compile/textures/compile_textures.h"
#include "scene/textures/texture_lookup.h"
#include "tests/scene/textures/texture_lookups.h"
#include "tests/support/contains.h"
#include "tests/support/files/image_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <vector>

namespace sheaf::test_texture_channels {

using namespace texture_lookups;
using test::contains;
using Channel = BitmapDescription::Channel;

namespace {

constexpr Channel kChannels[] = {Channel::kRed, Channel::kGreen, Channel::kBlue, Channel::kAlpha};

TextureDescription texture_of(BitmapDescription bitmap) {
  bitmap.filter = TextureFilter::kNearest;
  return {bitmap, {1, 0, 0, 0, 1, 0}, "wood", {"scene.xml", 12}};
}
TextureDescription channel_of(const std::filesystem::path& file, Channel channel, bool raw = false) {
  BitmapDescription bitmap;
  bitmap.file = file;
  bitmap.channel = channel;
  bitmap.raw = raw;
  return texture_of(bitmap);
}

std::shared_ptr<const EncodedImage> encoded(const std::string& bytes) {
  return std::make_shared<EncodedImage>(EncodedImage{{bytes.begin(), bytes.end()}, "model.glb: image 3"});
}
TextureDescription texture_of(const std::shared_ptr<const EncodedImage>& image, bool raw = false) {
  BitmapDescription bitmap;
  bitmap.encoded = image;
  bitmap.raw = raw;
  return texture_of(bitmap);
}

/// Maximum error of the decoding of sRGB bytes (decode_srgb_byte()), and of rounding.
constexpr double kDecodingError = 6.5e-6;

double decoded(int byte) { return srgb_to_linear(static_cast<float>(byte) / 255.0f); }

/// Pixels (10, 60, 110, 160), (20, 70, 120, 170) from the left.
std::filesystem::path write_two_pixels(const TemporaryFolder& folder) {
  write_tga(folder / "two.tga", 2, 1, 4, {10, 60, 110, 160, 20, 70, 120, 170});
  return folder / "two.tga";
}

BitmapRow row_of(const TextureTables& textures, std::size_t i) { return textures.rows.at(i).data<BitmapRow>(); }

}  // namespace

TEST_CASE("texture channels: bytes stay bytes, and alpha is never decoded") {
  const TemporaryFolder folder;
  const auto file = write_two_pixels(folder);
  std::vector<TextureDescription> descriptions;
  for (const bool raw : {false, true})
    for (const Channel channel : kChannels) descriptions.push_back(channel_of(file, channel, raw));
  const TextureTables textures = compile_textures(descriptions);
  const TextureView view = view_of(textures);
  CHECK(textures.images.size() == 4);
  for (std::uint32_t i = 0; i < 8; ++i) {
    CAPTURE(i);
    const bool linear = i >= 4 || i == 3;
    CHECK(row_of(textures, i).format == (linear ? TexelFormat::kByte1 : TexelFormat::kSrgbByte1));
    CHECK(row_of(textures, i).image == row_of(textures, i % 4).image);
    for (int x = 0; x < 2; ++x) {
      const int byte = 10 + 10 * x + 50 * static_cast<int>(i % 4);
      const TextureQuery<Scalar> query = query_at(0.25f + 0.5f * static_cast<float>(x), 0.5f);
      const double expected = linear ? byte / 255.0 : decoded(byte);
      const Near value = linear ? near(expected) : within(expected, kDecodingError);
      CHECK(lookup_scalar<Scalar>(view, i, query) == value);
      CHECK(lookup_texture<Scalar>(view, i, query).c2 == value);
    }
    CHECK(lanes_agree(view, i, [](int k) { return random_query(static_cast<std::uint32_t>(k)); }));
  }
}

TEST_CASE("texture channels: gray images have their gray in all colors, and images without alpha are opaque") {
  const TemporaryFolder folder;
  write_pnm(folder / "grey.pgm", 2, 1, 1, 255, {40, 50});
  write_pnm(folder / "rgb.ppm", 2, 1, 3, 255, {1, 2, 3, 4, 5, 6});
  std::vector<TextureDescription> descriptions;
  for (const Channel channel : kChannels) descriptions.push_back(channel_of(folder / "grey.pgm", channel));
  descriptions.push_back(channel_of(folder / "rgb.ppm", Channel::kAlpha));
  descriptions.push_back(channel_of(folder / "rgb.ppm", Channel::kColor));
  const TextureTables textures = compile_textures(descriptions);
  const TextureView view = view_of(textures);
  for (std::uint32_t i = 0; i < 3; ++i)
    CHECK(lookup_scalar<Scalar>(view, i, query_at(0.75f, 0.5f)) == within(decoded(50), kDecodingError));
  for (const std::uint32_t alpha : {3u, 4u})
    for (std::uint32_t i = 0; i < 20; ++i) CHECK(lookup_scalar<Scalar>(view, alpha, random_query(i)) == 1.0f);
  CHECK(lookup_texture<Scalar>(view, 5, query_at(0.75f, 0.5f)).c1 == within(decoded(5), kDecodingError));
}

TEST_CASE("texture channels: wide integers, floats and color transforms") {
  const TemporaryFolder folder;
  write_tiff(folder / "wide.tif", 1, 1, 3, 16, {10000, 20000, 30000});
  Image image(1, 1, {"R", "G", "B", "A"});
  image.data = {2, 3, 4, 0.25f};
  write_exr(folder / "a.exr", image);
  TextureDescription scaled = channel_of(write_two_pixels(folder), Channel::kAlpha);
  std::get<BitmapDescription>(scaled.model).change = {.scale = 3, .invert = true};
  TextureDescription green = channel_of(folder / "two.tga", Channel::kGreen);
  std::get<BitmapDescription>(green.model).change = {.scale = 0.5f};
  const TextureTables textures = compile_textures(
      {channel_of(folder / "wide.tif", Channel::kGreen), channel_of(folder / "wide.tif", Channel::kGreen, true),
       channel_of(folder / "a.exr", Channel::kBlue), channel_of(folder / "a.exr", Channel::kAlpha), scaled, green});
  const TextureView view = view_of(textures);
  const auto value = [&](std::uint32_t i) { return lookup_scalar<Scalar>(view, i, query_at(0.25f, 0.5f)); };
  CHECK(value(0) == near(srgb_to_linear(20000.0f / 65535), 1e-5));
  CHECK(value(1) == near(20000.0 / 65535));
  CHECK(value(2) == 4.0f);
  CHECK(value(3) == 0.25f);
  CHECK(value(4) == near(std::max(0.0, 1 - 3 * 160 / 255.0)));
  CHECK(value(5) == near(0.5 * decoded(60), 1e-5));
  for (std::size_t i = 0; i < 6; ++i) CHECK(!holds_bytes(row_of(textures, i).format));
}

TEST_CASE("texture channels: scaling a texture scales its channel") {
  const TemporaryFolder folder;
  const TextureDescription plain = channel_of(write_two_pixels(folder), Channel::kAlpha);
  TextureDescription twice = plain;
  twice.model = scaled_texture(plain.model, 2, [](const SpectrumInput& color) { return color; });
  const TextureTables textures = compile_textures({plain, twice});
  const TextureView view = view_of(textures);
  CHECK(lookup_scalar<Scalar>(view, 0, query_at(0.25f, 0.5f)) == near(160 / 255.0));
  CHECK(lookup_scalar<Scalar>(view, 1, query_at(0.25f, 0.5f)) == near(2 * 160 / 255.0));
}

TEST_CASE("encoded images: textures of one image share its texels") {
  const std::vector<int> values = {200, 30, 7, 255, 100, 90, 9, 255};
  const auto image = encoded(webp_bytes(2, 1, values, false)), other = encoded(webp_bytes(2, 1, values, false));
  BitmapDescription red;
  red.encoded = image;
  red.channel = Channel::kRed;
  const TextureTables textures = compile_textures(
      {texture_of(image), texture_of(image, true), texture_of(other), texture_of(red), texture_of(image)});
  CHECK(row_of(textures, 0).image == row_of(textures, 1).image);
  CHECK(row_of(textures, 0).image == row_of(textures, 4).image);
  CHECK(row_of(textures, 0).image != row_of(textures, 2).image);
  CHECK(row_of(textures, 0).image != row_of(textures, 3).image);
  CHECK(textures.images.size() == 3);
  CHECK(row_of(textures, 0).format == TexelFormat::kSrgbByte3);
  CHECK(row_of(textures, 1).format == TexelFormat::kByte3);
  CHECK(row_of(textures, 3).format == TexelFormat::kSrgbByte1);
  const TextureView view = view_of(textures);
  CHECK(lookup_texture<Scalar>(view, 0, query_at(0.75f, 0.5f)).c0 == within(decoded(100), kDecodingError));
  CHECK(lookup_texture<Scalar>(view, 1, query_at(0.75f, 0.5f)).c1 == near(90 / 255.0));
  CHECK(lookup_scalar<Scalar>(view, 3, query_at(0.25f, 0.5f)) == within(decoded(200), kDecodingError));
}

TEST_CASE("encoded images: errors name the texture and the image") {
  try {
    compile_textures({texture_of(encoded("GIF89a"))});
    FAIL("the format is not supported");
  } catch (const SceneError& error) {
    const std::string message = error.what();
    CHECK(message.starts_with("scene.xml:12: texture 'wood': model.glb: image 3: "));
    CHECK(contains(message, "expected PNG, JPEG or WebP"));
  }
}

}  // namespace sheaf::test_texture_channels
