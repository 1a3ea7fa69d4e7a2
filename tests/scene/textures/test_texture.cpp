// Compiling textures: images of every format and their tiles, sharing, checkerboards, mesh attributes, and errors.
#include "scene/compile/textures/compile_textures.h"
#include "scene/tables/texture.h"

#include "core/color/color.h"
#include "core/image/exr.h"
#include "core/math/half.h"
#include "scene/compile/textures/texture_image.h"
#include "tests/support/capture.h"
#include "tests/support/contains.h"
#include "tests/support/files/image_files.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

namespace sheaf::test_texture {

using test::contains;

namespace {

/// 0, step, 2 step ... modulo `modulus`.
std::vector<int> ramp(int count, int step = 7, int modulus = 256) {
  std::vector<int> values;
  for (int i = 0; i < count; ++i) values.push_back(i * step % modulus);
  return values;
}

/// The stored value of a texel, counted from the lower left, with bytes as 0 .. 255.
double stored(const TiledImage& image, int x, int y, int channel = 0) {
  const TileShift shift = tile_shift(image.format);
  const int columns = 1 << shift.x, rows = 1 << shift.y;
  const auto tile = static_cast<std::size_t>(y / rows) * image.tiles_per_row + static_cast<std::size_t>(x / columns);
  const auto texel = static_cast<std::size_t>(y % rows * columns + x % columns);
  const std::uint8_t* const bytes =
      image.tiles[0].bytes + tile * bytes_per_tile(image.format) + texel * bytes_per_texel(image.format);
  if (holds_bytes(image.format)) return bytes[channel];
  if (holds_halves(image.format)) {
    std::uint16_t half = 0;
    std::memcpy(&half, bytes + 2 * channel, sizeof(half));
    return half_to_float(half);
  }
  float out = 0;
  std::memcpy(&out, bytes + 4 * channel, sizeof(float));
  return out;
}

/// Whether the tiles hold `expected` (from the upper left, interleaved), each value decoded by `decode`.
bool holds(
    const TiledImage& image, const std::vector<int>& expected, int channels, double tolerance = 0,
    const std::function<double(int)>& decode = [](int v) { return v; }) {
  std::size_t i = 0;
  for (int y = static_cast<int>(image.height) - 1; y >= 0; --y)
    for (int x = 0; x < static_cast<int>(image.width); ++x)
      for (int c = 0; c < channels; ++c)
        if (std::fabs(stored(image, x, y, c) - decode(expected[i++])) > tolerance) return false;
  return i == expected.size();
}

TextureDescription bitmap(const std::filesystem::path& file, bool raw = false) {
  BitmapDescription model;
  model.file = file;
  model.raw = raw;
  TextureDescription texture;
  texture.model = model;
  texture.id = "wood";
  texture.where = {"scene.xml", 12};
  return texture;
}

TextureDescription board(SpectrumInput color0, SpectrumInput color1) {
  TextureDescription texture;
  texture.model = CheckerboardDescription{std::move(color0), std::move(color1)};
  texture.where = {"scene.xml", 7};
  return texture;
}

/// Reads an image file with the defaults of BitmapDescription.
TiledImage load_image(const std::filesystem::path& file, bool raw) {
  BitmapDescription bitmap;
  bitmap.file = file;
  bitmap.raw = raw;
  return *load_tiled_image(bitmap, {});
}

std::string message_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const SceneError& error) { return error.what(); }
  return "";
}
std::string compile_error(const std::vector<TextureDescription>& textures) {
  return message_of([&] { compile_textures(textures); });
}

/// What every kind of textures declares.
struct CommonKind {
  [[maybe_unused]] static constexpr TextureDomain kDomain = TextureDomain::kUv;
  static constexpr auto fields(auto&) { return std::tie(); }
  static constexpr auto colors(auto&) { return std::tie(); }
};
struct CompleteKind : CommonKind {
  [[maybe_unused]] static constexpr auto kPlugins = kNoPlugins;
  void scale_by(float by);
  void make_row(TextureRowBuilder& row) const;
};
struct WithoutScale : CommonKind {
  [[maybe_unused]] static constexpr auto kPlugins = kNoPlugins;
  void make_row(TextureRowBuilder& row) const;
};
struct WithoutRow : CommonKind {
  [[maybe_unused]] static constexpr auto kPlugins = kNoPlugins;
  void scale_by(float by);
};
struct WithoutReader : CommonKind {
  [[maybe_unused]] static constexpr std::array kPlugins = {"unread"};
  void scale_by(float by);
  void make_row(TextureRowBuilder& row) const;
};
static_assert(CompleteTexture<CompleteKind>);
static_assert(!CompleteTexture<WithoutScale> && !CompleteTexture<WithoutRow> && !CompleteTexture<WithoutReader>);

}  // namespace

TEST_CASE("texture: 8-bit images are stored as bytes in tiles from the lower left") {
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair{1, 1}, {4, 4}, {9, 6}, {8, 17}, {30, 3}, {257, 2}}) {
    CAPTURE_BINDING(width);
    CAPTURE_BINDING(height);
    const std::vector<int> gray = ramp(width * height), color = ramp(3 * width * height);
    write_pnm(folder / "grey.pgm", width, height, 1, 255, gray);
    write_pnm(folder / "color.ppm", width, height, 3, 255, color);
    const TiledImage one = load_image(folder / "grey.pgm", false), three = load_image(folder / "color.ppm", false);
    CHECK(one.format == TexelFormat::kByte1);
    CHECK(three.format == TexelFormat::kByte3);
    REQUIRE(one.width == static_cast<std::uint32_t>(width));
    REQUIRE(three.height == static_cast<std::uint32_t>(height));
    CHECK(holds(one, gray, 1));
    CHECK(holds(three, color, 3));
    CHECK(three.tiles.size() == ((width + 3) / 4 * ((height + 3) / 4) * 48 + 63) / 64 + 1);
  }
}

TEST_CASE("texture: images of every format are read") {
  const TemporaryFolder folder;
  const std::vector<int> color = ramp(9 * 6 * 3), wide = ramp(9 * 6 * 3, 1237, 65536);
  write_bmp(folder / "a.bmp", 9, 6, color);
  write_tga(folder / "a.tga", 9, 6, 3, color);
  write_tiff(folder / "a8.tif", 9, 6, 3, 8, color);
  for (const char* name : {"a.bmp", "a.tga", "a8.tif"}) {
    CAPTURE(name);
    const TiledImage image = load_image(folder / name, false);
    CHECK(image.format == TexelFormat::kByte3);
    CHECK(holds(image, color, 3));
  }
  write_jpeg(folder / "a.jpg", 200);
  const TiledImage jpeg = load_image(folder / "a.jpg", false);
  CHECK(jpeg.format == TexelFormat::kByte1);
  CHECK(holds(jpeg, std::vector<int>(64, 200), 1));

  write_hdr(folder / "a.hdr", 9, 6, color);
  const TiledImage hdr = load_image(folder / "a.hdr", false);
  CHECK(hdr.format == TexelFormat::kHalf4);
  CHECK(holds(hdr, color, 3, 0.5 + 1e-6));  // some libraries add half a step

  write_tiff(folder / "a16.tif", 9, 6, 3, 16, wide);
  write_pnm(folder / "a16.ppm", 9, 6, 3, 65535, wide);
  for (const char* name : {"a16.tif", "a16.ppm"}) {
    CAPTURE(name);
    CHECK(load_image(folder / name, true).format == TexelFormat::kFloat4);
    constexpr double kStep = 1.01 / 65535;  // the PPM reader rounds by up to a step
    CHECK(holds(load_image(folder / name, true), wide, 3, kStep, [](int v) { return v / 65535.0; }));
    CHECK(holds(load_image(folder / name, false), wide, 3, 3 * kStep,
                [](int v) { return static_cast<double>(srgb_to_linear(static_cast<float>(v / 65535.0))); }));
  }
}

TEST_CASE("texture: OpenEXR images are linear and have named channels") {
  const TemporaryFolder folder;
  Image image(5, 3, {"A", "B", "G", "R"});
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 5; ++x)
      for (int c = 0; c < 4; ++c) image.at(x, y, c) = static_cast<float>(100 * c + 10 * y + x) - 50;
  write_exr(folder / "color.exr", image);
  for (const bool raw : {false, true}) {
    const TiledImage color = load_image(folder / "color.exr", raw);
    REQUIRE(color.format == TexelFormat::kHalf4);
    CHECK(stored(color, 4, 2, 0) == 300 + 4 - 50);
    CHECK(stored(color, 4, 0, 1) == 200 + 20 + 4 - 50);
    CHECK(stored(color, 0, 1, 2) == 100 + 10 - 50);
  }
  image.channels = {"A", "U", "V", "Z"};
  write_exr(folder / "uv.exr", image);
  CHECK(contains(message_of([&] { load_image(folder / "uv.exr", false); }),
                 "the channels A, U, V, Z (expected R, G and B"));
  Image gray(5, 3, {"A", "Y"});
  gray.at(1, 0, 1) = 0.25f;
  write_exr(folder / "grey.exr", gray);
  const TiledImage tiled = load_image(folder / "grey.exr", false);
  CHECK(tiled.format == TexelFormat::kHalf1);
  CHECK(stored(tiled, 1, 2) == 0.25);
  CHECK(stored(tiled, 1, 0) == 0.0);
}

TEST_CASE("texture: halves of OpenEXR files are read as such") {
  const TemporaryFolder folder;
  Image image(19, 7, {"A", "B", "G", "R"});
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = std::sin(static_cast<float>(i));
  ExrMetadata metadata;
  metadata.half_channels = image.channels;
  using Channel = BitmapDescription::Channel;
  for (const bool frame : {true, false}) {
    // A data window within the display window
    if (!frame) image.frame_width = 21, image.frame_height = 8, image.x0 = 1;
    write_exr(folder / "a.exr", image, metadata);
    for (const Channel channel : {Channel::kColor, Channel::kGreen, Channel::kAlpha}) {
      BitmapDescription bitmap;
      bitmap.file = folder / "a.exr";
      bitmap.channel = channel;
      const TiledImage tiled = *load_tiled_image(bitmap, {});
      REQUIRE(tiled.format == (channel == Channel::kColor ? TexelFormat::kHalf4 : TexelFormat::kHalf1));
      REQUIRE(static_cast<int>(tiled.width) == image.frame_width);
      const int column = channel == Channel::kAlpha ? 0 : 2;
      for (int y = 0; y < 7; ++y)
        for (int x = 0; x < 19; ++x)
          CHECK(stored(tiled, x + image.x0, image.frame_height - 1 - y, channel == Channel::kColor ? 1 : 0) ==
                static_cast<double>(half_to_float(float_to_half(image.at(x, y, column)))));
    }
  }
  image.at(3, 2, 3) = std::numeric_limits<float>::infinity();
  write_exr(folder / "a.exr", image, metadata);
  CHECK(contains(message_of([&] { load_image(folder / "a.exr", false); }), "is not a finite number"));
}

TEST_CASE("texture: floats are stored as halves if all of them are exact as such") {
  const TemporaryFolder folder;
  constexpr float kSmallest = 0x1p-24f, kLargest = 65504;
  for (const auto& [last, format] : {std::pair{1.0f / 3, TexelFormat::kFloat1},
                                     {65536.0f, TexelFormat::kFloat1},
                                     {kSmallest / 2, TexelFormat::kFloat1},
                                     {-kLargest, TexelFormat::kHalf1}}) {
    Image image(19, 7, {"Y"});
    for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<float>(i) / 64;
    image.data[0] = kSmallest;
    image.data[1] = -1000 * kSmallest;
    image.data.back() = last;
    write_exr(folder / "a.exr", image);
    const TiledImage tiled = load_image(folder / "a.exr", false);
    REQUIRE(tiled.format == format);
    for (int y = 0; y < 7; ++y)
      for (int x = 0; x < 19; ++x) CHECK(stored(tiled, x, 6 - y) == static_cast<double>(image.at(x, y, 0)));
  }
}

TEST_CASE("texture: alpha is dropped without unpremultiplying") {
  const TemporaryFolder folder;
  std::vector<int> rgba, rgb;
  for (int i = 0; i < 12; ++i) {
    for (const int v : {200, 100 + i, 50}) {
      rgba.push_back(v);
      rgb.push_back(v);
    }
    rgba.push_back(20 * i);
  }
  write_tga(folder / "alpha.tga", 4, 3, 4, rgba);
  CHECK(holds(load_image(folder / "alpha.tga", false), rgb, 3));

  Image image(2, 1, {"R", "G", "B", "A"});
  image.data = {0.25f, 0.125f, 0.5f, 0.5f, 0, 0, 0, 0};
  write_png(folder / "alpha.png", image);
  const TiledImage png = load_image(folder / "alpha.png", false);
  CHECK(png.format == TexelFormat::kByte3);
  CHECK(stored(png, 0, 0, 2) == 255);
  CHECK(stored(png, 0, 0, 0) == std::lround(255 * linear_to_srgb(0.5f)));

  Image gray(2, 1, {"Y", "A"});
  gray.data = {0.5f, 1, 0.25f, 0.5f};
  write_png(folder / "grey.png", gray);
  const TiledImage two = load_image(folder / "grey.png", false);
  CHECK(two.format == TexelFormat::kByte1);
  CHECK(stored(two, 1, 0) == std::lround(255 * linear_to_srgb(0.5f)));
}

TEST_CASE("texture: compiled rows match their descriptions") {
  const TemporaryFolder folder;
  write_pnm(folder / "a.ppm", 9, 5, 3, 255, ramp(135));
  TextureDescription texture = bitmap(folder / "a.ppm");
  auto& model = std::get<BitmapDescription>(texture.model);
  model.filter = TextureFilter::kNearest;
  model.wrap_u = TextureWrap::kMirror;
  model.wrap_v = TextureWrap::kClamp;
  texture.to_uv = {2, 0, 0.5f, 0, -1, 1};
  const TextureTables compiled = compile_textures(
      {texture, bitmap(folder / "a.ppm", true), board(SpectrumDescription::rgb(1, 0.5f, 2), TextureId{0})});
  REQUIRE(compiled.rows.size() == 4);
  const TextureRow& row = compiled.rows[0];
  REQUIRE(row.kind == kTextureKind<BitmapDescription>);
  const auto bitmap_row = row.data<BitmapRow>();
  CHECK(bitmap_row.width == 9);
  CHECK(bitmap_row.height == 5);
  CHECK(bitmap_row.tiles_per_row == 3);
  CHECK(bitmap_row.filter == TextureFilter::kNearest);
  CHECK(bitmap_row.wrap_u == TextureWrap::kMirror);
  CHECK(bitmap_row.wrap_v == TextureWrap::kClamp);
  CHECK(bitmap_row.format == TexelFormat::kSrgbByte3);
  CHECK(row.to_uv[0] == 2.0f);
  CHECK(row.to_uv[5] == 1.0f);
  CHECK(compiled.rows[1].data<BitmapRow>().format == TexelFormat::kByte3);
  REQUIRE(compiled.rows[2].kind == kTextureKind<CheckerboardDescription>);
  REQUIRE(compiled.rows[2].input_count == 2);
  CHECK(compiled.rows[2].inputs[0] == 3);
  CHECK(compiled.rows[2].inputs[1] == 0);
  REQUIRE(compiled.rows[3].kind == kTextureKind<ConstantTextureDescription>);
  CHECK(compiled.rows[3].data<ConstantRow>().rgb[2] == 2.0f);
  CHECK(compiled.rows[3].data<ConstantRow>().scalar == luminance({1, 0.5f, 2}));
  CHECK(reinterpret_cast<std::uintptr_t>(compiled.images[0].tiles) % 64 == 0);
}

TEST_CASE("texture: a file is loaded once for each way of reading it") {
  const TemporaryFolder folder;
  write_pnm(folder / "a.pgm", 16, 16, 1, 255, ramp(256));
  write_pnm(folder / "b.pgm", 16, 16, 1, 65535, ramp(256, 300, 65536));
  const auto again = folder.path() / "." / "a.pgm";
  for (const bool raw_first : {false, true}) {
    const TextureTables compiled = compile_textures(
        {bitmap(folder / "a.pgm", raw_first), bitmap(again, !raw_first), bitmap(folder / "b.pgm", raw_first),
         bitmap(folder / "b.pgm", !raw_first), bitmap(folder / "b.pgm", raw_first)});
    const auto image = [&](std::size_t i) { return compiled.rows[i].data<BitmapRow>().image; };
    CHECK(image(0) == image(1));
    CHECK((compiled.rows[0].data<BitmapRow>().format == TexelFormat::kSrgbByte1) == !raw_first);
    CHECK((compiled.rows[1].data<BitmapRow>().format == TexelFormat::kSrgbByte1) == raw_first);
    CHECK(image(2) == image(4));
    CHECK(image(2) != image(3));
    CHECK(compiled.images.size() == 3);
    CHECK(compiled.texel_bytes() == (4 + 2 * 16 + 3) * sizeof(TexelLine));  // with one tile of padding each
  }
}

TEST_CASE("texture: unreadable files are errors with the line of the scene") {
  const TemporaryFolder folder;
  const std::string missing = compile_error({bitmap(folder / "none.png")});
  CHECK(contains(missing, "scene.xml:12: "));
  CHECK(contains(missing, "texture 'wood'"));
  CHECK(contains(missing, "none.png: image file not found"));
  CHECK(contains(compile_error({bitmap(folder.path())}), "image file not found"));
  write_bytes(folder / "text.png", "not an image");
  CHECK(contains(compile_error({bitmap(folder / "text.png")}), "scene.xml:12: "));
  write_bytes(folder / "empty.png", "");
  CHECK(contains(compile_error({bitmap(folder / "empty.png")}), "empty.png: "));

  write_pnm(folder / "a.ppm", 9, 6, 3, 255, ramp(162));
  write_tga(folder / "a.tga", 9, 6, 3, ramp(162));
  write_bmp(folder / "a.bmp", 9, 6, ramp(162));
  write_hdr(folder / "a.hdr", 9, 6, ramp(162));
  write_tiff(folder / "a.tif", 9, 6, 3, 8, ramp(162));
  write_jpeg(folder / "a.jpg", 200);
  write_exr(folder / "a.exr", Image(9, 6, {"R", "G", "B"}));
  for (const char* name : {"a.ppm", "a.tga", "a.bmp", "a.hdr", "a.tif", "a.jpg", "a.exr"}) {
    const std::string bytes = read_bytes(folder / name);
    for (const std::size_t percent : {5u, 30u, 60u, 90u}) {
      CAPTURE(name);
      CAPTURE(percent);
      const auto cut = folder.path() / (std::string("cut_") + name);
      write_bytes(cut, bytes.substr(0, bytes.size() * percent / 100));
      CHECK(contains(compile_error({bitmap(cut)}), "scene.xml:12: "));
    }
  }
}

TEST_CASE("texture: sizes of zero and sizes that the file cannot hold are rejected") {
  const TemporaryFolder folder;
  for (const char* header :
       {"P6 0 4 255\n", "P6 4 0 255\n", "P6 60000 60000 255\n", "P5 65536 65536 255\n", "P6 4000000000 4 255\n"}) {
    CAPTURE(header);
    write_bytes(folder / "a.ppm", std::string(header) + "abcdefghijkl");
    CHECK(contains(compile_error({bitmap(folder / "a.ppm")}), "scene.xml:12: "));
  }
}

TEST_CASE("texture: pixels and transforms must be finite") {
  const TemporaryFolder folder;
  Image image(4, 3, {"A", "B", "G", "R"});
  image.at(1, 2, 0) = std::numeric_limits<float>::quiet_NaN();
  write_exr(folder / "alpha.exr", image);
  CHECK_NOTHROW(load_image(folder / "alpha.exr", false));
  image.at(3, 1, 2) = std::numeric_limits<float>::infinity();
  write_exr(folder / "a.exr", image);
  CHECK(contains(compile_error({bitmap(folder / "a.exr")}), "channel G of the pixel in column 3, row 1"));
  TextureDescription texture = board(SpectrumDescription::constant(1), SpectrumDescription::constant(0));
  texture.to_uv[4] = std::numeric_limits<float>::quiet_NaN();
  CHECK(contains(compile_error({texture}), "scene.xml:7: texture: the transform"));
}

TEST_CASE("texture: checkerboards may be nested to a limited depth but not contain themselves") {
  const auto white = SpectrumDescription::constant(1);
  std::vector<TextureDescription> chain;
  for (std::uint32_t i = 1; i < kMaxTextureDepth; ++i) chain.push_back(board(TextureId{i}, white));
  chain.push_back(board(white, white));
  CHECK(compile_error(chain).empty());
  chain.back() = board(white, TextureId{kMaxTextureDepth});
  chain.push_back(board(white, white));
  CHECK(contains(compile_error(chain), "more than 8 nested textures"));
  std::vector<TextureDescription> reversed{board(white, white)};
  for (std::uint32_t i = 0; i < kMaxTextureDepth; ++i) reversed.push_back(board(white, TextureId{i}));
  CHECK(contains(compile_error(reversed), "more than 8 nested textures"));
  reversed.pop_back();
  CHECK(compile_error(reversed).empty());

  CHECK(contains(compile_error({board(TextureId{0}, white)}), "contains itself"));
  CHECK(contains(compile_error({board(white, TextureId{1}), board(TextureId{0}, white)}), "contains itself"));
  CHECK(contains(compile_error({board(white, TextureId{5})}), "does not exist"));
  std::vector<TextureDescription> longest;
  for (std::uint32_t i = 1; i < 100000; ++i) longest.push_back(board(TextureId{i}, TextureId{i}));
  longest.push_back(board(white, white));
  CHECK(contains(compile_error(longest), "more than 8 nested textures"));
}

TEST_CASE("texture: rows know what their lookups read, also in nested textures") {
  const auto white = SpectrumDescription::constant(1);
  TextureDescription attribute, frame, mix;
  attribute.model = MeshAttributeDescription{"vertex_color"};
  frame.model = WireframeDescription{};
  mix.model = MixTextureDescription{white, white, TextureId{0}};
  const TextureTables compiled = compile_textures(
      {attribute, frame, mix, board(white, TextureId{2}), board(white, TextureId{5}), board(white, white)});
  for (const std::size_t row : {0u, 1u, 2u, 3u}) CHECK(compiled.rows[row].needs == kTextureNeedsMesh);
  for (const std::size_t row : {4u, 5u}) CHECK(compiled.rows[row].needs == 0);
  // Wireframes read attributes that every mesh has.
  REQUIRE(compiled.required_attributes.size() == 1);
  CHECK(compiled.required_attributes[0].first == 0);
  CHECK(compiled.attribute_names[compiled.required_attributes[0].second] == "vertex_color");
}

TEST_CASE("texture: the attribute table holds all attributes that textures read") {
  TextureDescription color, weight;
  color.model = MeshAttributeDescription{"vertex_color", 2};
  weight.model = MeshAttributeDescription{"face_weight", 1};
  const TextureTables textures = compile_textures({weight, color, color});
  REQUIRE(textures.attribute_names.size() == 2);
  AttributeTable table(textures.attribute_names);
  CHECK(table.wants("face_weight"));
  CHECK_FALSE(table.wants("face_color"));
  table.add(2, 10, 1, 3, {"vertex_color", 3, {1, 2, 3, 4, 5, 6, 7, 8, 9}}, {});
  table.add(2, 10, 1, 3, {"face_color", 3, {1, 2, 3}}, {});
  table.add(0, 5, 2, 4, {"face_weight", 1, {0.5f, 0.25f}}, {});
  table.finish(3);
  REQUIRE(table.entries().size() == 6);
  const auto entry = [&](std::size_t row, std::uint32_t shape) {
    return table.entries()[3 * textures.rows[row].data<MeshAttributeRow>().attribute + shape];
  };
  CHECK(textures.rows[1].data<MeshAttributeRow>().scale == 2.0f);
  CHECK(entry(1, 2).layout == 3);
  CHECK(entry(2, 2).first_triangle == 10);
  CHECK(entry(0, 0).layout == (1 | AttributeEntry::kPerFace));
  CHECK(entry(0, 0).triangle_count == 2);
  CHECK(table.values()[entry(0, 0).first_value + 1] == 0.25f);
  CHECK(table.values()[entry(1, 2).first_value + 8] == 9.0f);
  for (const auto& [row, shape] : {std::pair{0, 1u}, {0, 2u}, {1, 0u}, {1, 1u}})
    CHECK(entry(static_cast<std::size_t>(row), shape).layout == 0);
  CHECK(table.values().size() == 9 + 2 + 3);
}

TEST_CASE("texture: invalid attributes are errors with the line of the shape") {
  AttributeTable table({"vertex_a"});
  const SourceLocation where{"scene.xml", 33};
  const auto error = [&](const Mesh::Attribute& attribute) {
    return message_of([&] { table.add(0, 0, 2, 4, attribute, where); });
  };
  CHECK(
      contains(error({"vertex_a", 1, {1, 2, 3}}), "scene.xml:33: mesh attribute 'vertex_a' has 3 values (expected 4)"));
  CHECK(contains(error({"face_a", 3, {1, 2, 3}}), "has 3 values (expected 6)"));
  CHECK(contains(error({"vertex_a", 2, {1, 2, 3, 4, 5, 6, 7, 8}}), "2 channels"));
  CHECK(contains(error({"color", 1, {1, 2, 3, 4}}), "begins neither"));
  CHECK(contains(error({"vertex_a", 1, {1, 2, std::numeric_limits<float>::quiet_NaN(), 4}}), "not finite"));
  CHECK(error({"vertex_a", 1, {1, 2, 3, 4}}).empty());
  CHECK(contains(error({"vertex_a", 1, {1, 2, 3, 4}}), "twice"));
  TextureDescription texture;
  texture.model = MeshAttributeDescription{"color", 1};
  CHECK(contains(compile_error({texture}), "'color' is not a mesh attribute"));
}

}  // namespace sheaf::test_texture
