// Mip levels: texels are means of the image, lookups select the level whose texels fit the footprint.
#include "scene/compile/textures/mip_levels.h"

#include "core/image/exr.h"
#include "core/io/file_cache.h"
#include "scene/textures/lookups/bitmap.h"
#include "scene/textures/tiled_image.h"
#include "tests/scene/textures/texture_lookups.h"
#include "tests/support/capture.h"
#include "tests/support/files/image_files.h"
#include "tests/support/near.h"
#include "tests/support/same_bits.h"

#include <doctest/doctest.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <string>
#include <vector>

namespace sheaf::test_mip_levels {

using namespace texture_lookups;

namespace {

/// An image of random values in a file: bytes, halves or floats.
std::filesystem::path make_image(const TemporaryFolder& folder, int width, int height, int channels, int bits) {
  if (bits == 8) {
    std::vector<int> values;
    for (int i = 0; i < width * height * channels; ++i)
      values.push_back(static_cast<int>(256 * uniform(static_cast<std::uint32_t>(i), 1)));
    write_pnm(folder / "a.ppm", width, height, channels, 255, values);
    return folder / "a.ppm";
  }
  Image image(width, height, channels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"});
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    const float r = uniform(static_cast<std::uint32_t>(i), 1);
    image.data[i] = bits == 16 ? std::floor(512 * r) / 512 : r;
  }
  write_exr(folder / "a.exr", image);
  return folder / "a.exr";
}

TextureDescription describe(const std::filesystem::path& file, bool raw = false) {
  BitmapDescription model;
  model.file = file;
  model.raw = raw;
  TextureDescription texture;
  texture.model = model;
  return texture;
}

/// Materials that use the textures as reflectances.
MaterialTables materials_with(std::initializer_list<std::uint32_t> textures) {
  MaterialTables materials;
  for (const std::uint32_t texture : textures) materials.bindings.push_back({texture, 0, 4, TextureRole::kReflectance});
  return materials;
}

/// The levels of a texture's image; null if it has none.
const MipLevels* levels_of(const TextureTables& textures, std::uint32_t texture) {
  const std::uint32_t image = textures.rows[texture].data<BitmapRow>().image;
  const TiledImage& tiled = *textures.tiled_images[image];
  for (const auto& levels : {tiled.mip_levels, tiled.srgb_mip_levels})
    if (levels && levels->tiles.data() == textures.images[image].mip_tiles) return levels.get();
  return nullptr;
}

BitmapRow row_of(const TextureTables& textures, std::uint32_t i) { return textures.rows[i].data<BitmapRow>(); }

/// The query at the center of texel (x, y) of a level, with a footprint of its texels.
TextureQuery<Scalar> texel_query(const BitmapRow& bitmap, std::uint32_t level, int x, int y) {
  const auto along = [level](std::uint32_t size) { return static_cast<float>(std::max(size >> level, 1u)); };
  TextureQuery<Scalar> query = query_at((static_cast<float>(x) + 0.5f) / along(bitmap.width),
                                        (static_cast<float>(y) + 0.5f) / along(bitmap.height));
  const auto texels = static_cast<float>(1u << level);
  const float u = texels / static_cast<float>(bitmap.width), v = texels / static_cast<float>(bitmap.height);
  query.footprint = {u * u * 1.01f, v * v * 1.01f};
  return query;
}

using Channel = float Spectrum<Scalar>::*;

/// Mean of a channel over [x0, x1] x [y0, y1] of the image, in texels.
double mean_of(const TextureView& view, const BitmapRow& bitmap, Channel channel, double x0, double x1, double y0,
               double y1) {
  double sum = 0;
  for (int y = static_cast<int>(y0); y < y1; ++y)
    for (int x = static_cast<int>(x0); x < x1; ++x) {
      const double area =
          (std::min(x1, x + 1.0) - std::max(x0, double(x))) * (std::min(y1, y + 1.0) - std::max(y0, double(y)));
      sum += area * static_cast<double>(lookup_texture<Scalar>(view, 0, texel_query(bitmap, 0, x, y)).*channel);
    }
  return sum / ((x1 - x0) * (y1 - y0));
}

}  // namespace

TEST_CASE("mip levels: texels are means of the texels that they cover") {
  const TemporaryFolder folder;
  for (const int channels : {1, 3})
    for (const int bits : {8, 16, 32})
      for (const bool raw : {false, true})
        for (const auto& [width, height] : {std::pair{32, 32}, {64, 4}, {128, 16}, {37, 21}, {1, 9}}) {
          CAPTURE_BINDING(width);
          CAPTURE(channels);
          CAPTURE(bits);
          TextureTables textures = compile_textures({describe(make_image(folder, width, height, channels, bits), raw)});
          add_mip_levels(materials_with({0}), textures)();
          const BitmapRow bitmap = row_of(textures, 0);
          REQUIRE(levels_of(textures, 0) != nullptr);
          const std::vector<MipLevel>& levels = levels_of(textures, 0)->levels;
          REQUIRE(levels.size() == mip_level_count(bitmap.width, bitmap.height));
          const TextureView view = view_of(textures);
          for (std::uint32_t level = 1; level <= levels.size(); ++level) {
            const MipLevel& extent = levels[level - 1];
            const double x_step = static_cast<double>(width) / extent.width,
                         y_step = static_cast<double>(height) / extent.height;
            // Levels of odd sizes divide the texels of the previous level, which are constant, or of the image
            const bool divides = std::max(width, 1) % 2 + height % 2 > 0;
            if (level != 1 && level != 3 && divides && extent.width * extent.height > 1) continue;
            double difference = 0;
            for (int y = 0; y < static_cast<int>(extent.height); ++y)
              for (int x = 0; x < static_cast<int>(extent.width); ++x) {
                const auto texel = lookup_texture<Scalar>(view, 0, texel_query(bitmap, level, x, y));
                CHECK(texel.c3 == 0);
                for (const Channel channel : {&Spectrum<Scalar>::c1, &Spectrum<Scalar>::c2}) {
                  const double found = texel.*channel,
                               expected = mean_of(view, bitmap, channel, x * x_step, (x + 1) * x_step, y * y_step,
                                                  (y + 1) * y_step);
                  // Bytes: each level rounds by up to one step, which is 0.009 at white
                  CHECK(found == within(expected, bits == 8 ? 0.02 : bits == 16 ? 1e-3 : 1e-6));
                  if (channel == &Spectrum<Scalar>::c1) difference += found - expected;
                }
              }
            // Rounding errors cancel
            const double count = static_cast<double>(extent.width) * extent.height;
            if (bits == 8) CHECK(std::fabs(difference / count) < 0.015 / std::sqrt(count));
          }
        }
}

TEST_CASE("mip levels: the rounding of bytes keeps the mean") {
  const TemporaryFolder folder;
  std::vector<int> values;
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x) values.push_back((x + y) % 2 == 0 ? 0 : 255);
  write_pnm(folder / "a.pgm", 256, 256, 1, 255, values);
  TextureTables textures = compile_textures({describe(folder / "a.pgm"), describe(folder / "a.pgm", true)});
  add_mip_levels(materials_with({0, 1}), textures)();
  const TextureView view = view_of(textures);
  for (const std::uint32_t texture : {0u, 1u}) {
    const BitmapRow bitmap = row_of(textures, texture);
    double sum = 0;
    for (int y = 0; y < 128; ++y)
      for (int x = 0; x < 128; ++x)
        sum += static_cast<double>(lookup_texture<Scalar>(view, texture, texel_query(bitmap, 1, x, y)).c0);
    // To the nearest byte it would be 0.503 and 0.502
    CHECK(sum / (128 * 128) == within(0.5, 1e-4));
  }
}

TEST_CASE("mip levels: only bilinear images that are reflectances and nothing else have levels") {
  const TemporaryFolder folder;
  const auto file = make_image(folder, 8, 8, 3, 8);
  TextureDescription nearest = describe(file), product;
  std::get<BitmapDescription>(nearest.model).filter = TextureFilter::kNearest;
  product.model = ProductTextureDescription{TextureId{0}, SpectrumDescription::constant(0.5f)};
  // 0: through a product, 1: linear, 2: nearest, 3: normal map, 4: complex index of refraction, 5: scalar, 6: product
  TextureTables textures = compile_textures(
      {describe(file), describe(file, true), nearest, describe(file, true), describe(file), describe(file), product});
  MaterialTables materials = materials_with({1, 2, 3, 4, 6});
  materials.bindings.push_back({4, 4, 4, TextureRole::kUnbounded});
  materials.bindings.push_back({5, 4, 1, TextureRole::kScalar});
  materials.normal_maps.push_back({3});
  add_mip_levels(materials, textures)();
  CHECK(levels_of(textures, 0) != nullptr);
  CHECK(levels_of(textures, 1) != nullptr);
  CHECK(levels_of(textures, 0) != levels_of(textures, 1));  // decoded and not
  for (const std::uint32_t i : {2u, 3u, 4u, 5u}) CHECK(levels_of(textures, i) == nullptr);
  CHECK(textures.images.size() == 1 + 2);
  const TextureView view = view_of(textures);
  TextureQuery<Scalar> query = query_at(0.3f, 0.4f), point = query;
  query.footprint = {1, 1};
  CHECK(lookup_texture<Scalar>(view, 6, query).c0 == 0.5f * lookup_texture<Scalar>(view, 0, query).c0);
  CHECK(lookup_texture<Scalar>(view, 0, query).c0 != lookup_texture<Scalar>(view, 0, point).c0);
  // Scalars ignore footprints
  CHECK(lookup_scalar<Scalar>(view, 0, query) == lookup_scalar<Scalar>(view, 0, point));
}

TEST_CASE("mip levels: the level has the widest texels that fit into the narrower axis of the footprint") {
  BitmapRow bitmap{};
  bitmap.width = 1024;
  bitmap.height = 512;
  TextureRow row;
  const auto level = [&](double u, double v) {
    const Vec2f footprint{static_cast<float>(u * u), static_cast<float>(v * v)};
    return bitmap_detail::mip_level<Scalar>(bitmap, bitmap_detail::squared_texels<Scalar>(row, bitmap, footprint));
  };
  CHECK(level(0, 0) == 0);
  CHECK(level(1.99 / 1024, 1.99 / 512) == 0);
  CHECK(level(2.01 / 1024, 2.01 / 512) == 1);
  CHECK(level(3.99 / 1024, 3.99 / 512) == 1);
  CHECK(level(4.01 / 1024, 99.0 / 512) == 2);
  CHECK(level(99.0 / 1024, 4.01 / 512) == 2);
  CHECK(level(99, 99) == 10);
  CHECK(level(1e15, 1e15) == 10);
  CHECK(level(std::nan(""), std::nan("")) <= 10);
  row.to_uv[0] = row.to_uv[4] = 4;
  CHECK(level(4.01 / 1024, 4.01 / 512) == 4);
  const float turned[] = {0, 2, 0, 2, 0, 0};
  std::copy_n(turned, 6, row.to_uv);
  CHECK(level(4.01 / 512, 1) == 3);
  CHECK(level(1, 4.01 / 1024) == 3);
}

TEST_CASE("mip levels: lookups average points along the axis of the footprint") {
  const TemporaryFolder folder;
  TextureTables textures = compile_textures({describe(make_image(folder, 64, 32, 3, 32))});
  textures.rows[0].to_uv[1] = 0.5f;
  add_mip_levels(materials_with({0}), textures)();
  const TextureView view = view_of(textures);
  // A footprint of two texels, moved by a number of them
  for (const auto& [texels, count] : {std::pair{0.9f, 1}, {1.1f, 2}, {5.4f, 4}, {13.8f, 8}, {40.0f, 8}}) {
    CAPTURE_BINDING(texels);
    TextureQuery<Scalar> query = query_at(0.3f, 0.2f);
    query.footprint = {4.01f / (64 * 64), 4.01f / (32 * 32)};
    query.footprint_axis = {0, texels / std::hypot(0.5f * 64, 32.0f)};
    double sum = 0;
    for (int k = 0; k < count; ++k) {
      TextureQuery<Scalar> point = query;
      point.footprint_axis = {0, 0};
      if (count > 1)
        point.uv.y += query.footprint_axis.y * (static_cast<float>(k) / static_cast<float>(count - 1) - 0.5f);
      sum += static_cast<double>(lookup_texture<Scalar>(view, 0, point).c1);
    }
    CHECK(static_cast<double>(lookup_texture<Scalar>(view, 0, query).c1) == near(sum / count, 1e-4));
  }
}

TEST_CASE("mip levels: texels are computed after the tables have moved") {
  const TemporaryFolder folder;
  const TextureDescription texture = describe(make_image(folder, 50, 30, 3, 8));
  TextureTables textures = compile_textures({texture}), moved = compile_textures({texture});
  add_mip_levels(materials_with({0}), textures)();
  const std::function<void()> compute = add_mip_levels(materials_with({0}), moved);
  const TextureTables elsewhere = std::move(moved);
  compute();
  REQUIRE(elsewhere.texel_bytes() == textures.texel_bytes());
  const TextureView view = view_of(textures), later = view_of(elsewhere);
  for (std::uint32_t i = 0; i < 200; ++i) {
    TextureQuery<Scalar> query = random_query(i);
    query.footprint = {0.2f, 0.1f};
    CHECK(same(lookup_texture<Scalar>(later, 0, query).c1, lookup_texture<Scalar>(view, 0, query).c1));
  }
}

TEST_CASE("mip levels: scenes that share an image through a FileCache compute its levels once") {
  const TemporaryFolder folder;
  const TextureDescription texture = describe(make_image(folder, 50, 30, 3, 8));
  const FileCache cache;
  TextureTables first = compile_textures({texture}), second = compile_textures({texture});
  add_mip_levels(materials_with({0}), first)();
  const std::function<void()> compute = add_mip_levels(materials_with({0}), second);
  CHECK(first.images[0].tiles == second.images[0].tiles);
  REQUIRE(first.images[1].mip_tiles == second.images[1].mip_tiles);
  CHECK(first.texel_bytes() == second.texel_bytes());
  MipLevels& levels = *first.tiled_images[0]->srgb_mip_levels;
  const auto first_byte = [&](std::uint32_t level) -> std::uint8_t& {
    return (levels.tiles[0].bytes + levels.levels[level - 1].first_tile * bytes_per_tile(levels.format))[0];
  };
  const std::uint8_t changed = first_byte(3) ^ 1;
  first_byte(3) = changed;
  compute();
  CHECK(first_byte(3) == changed);
  // Fine levels are computed when they are needed
  const TextureView views[] = {view_of(first), view_of(second)};
  const auto look_up = [&](int scene, std::uint32_t level) {
    return lookup_texture<Scalar>(views[scene], 0, texel_query(row_of(first, 0), level, 0, 0)).c0;
  };
  look_up(0, 0);
  look_up(0, 3);
  CHECK(!levels.has_fine);
  const float before = look_up(0, 2);
  CHECK(levels.has_fine);
  first_byte(2) ^= 1;
  CHECK(look_up(1, 2) != before);
  CHECK(first_byte(3) == changed);
}

TEST_CASE("mip levels: threads that need fine levels at once see the same texels") {
  const TemporaryFolder folder;
  const TextureDescription texture = describe(make_image(folder, 640, 480, 3, 8));
  TextureTables textures = compile_textures({texture}), shared = compile_textures({texture});
  add_mip_levels(materials_with({0}), textures)();
  add_mip_levels(materials_with({0}), shared)();
  const TextureView view = view_of(textures), threads_view = view_of(shared);
  const auto look_up = [](const TextureView& at, std::uint32_t i) {
    TextureQuery<Scalar> query = random_query(i);
    query.footprint = {6.0f / (640 * 640), 6.0f / (480 * 480)};  // level 1
    return lookup_texture<Scalar>(at, 0, query).c1;
  };
  std::vector<float> values(4096);
  tbb::parallel_for(0u, 4096u, [&](std::uint32_t i) { values[i] = look_up(threads_view, i); });
  CHECK(levels_of(shared, 0)->has_fine);
  std::size_t different = 0;
  for (std::uint32_t i = 0; i < values.size(); ++i) different += same(values[i], look_up(view, i)) ? 0 : 1;
  CHECK(different == 0);
}

TEST_CASE("mip levels: lanes agree with single lookups, and footprints of 0 with images without levels") {
  const TemporaryFolder folder;
  for (const int bits : {8, 16, 32})
    for (const int channels : {1, 3})
      for (const TextureWrap wrap : {TextureWrap::kRepeat, TextureWrap::kMirror, TextureWrap::kClamp}) {
        TextureDescription texture = describe(make_image(folder, 50, 30, channels, bits));
        auto& model = std::get<BitmapDescription>(texture.model);
        model.wrap_u = wrap;
        TextureTables textures = compile_textures({texture});
        const TextureTables plain = compile_textures({texture});
        add_mip_levels(materials_with({0}), textures)();
        const TextureView view = view_of(textures);
        for (std::uint32_t i = 0; i < 200; ++i)
          CHECK(lanes_agree(view, 0, [&](int k) {
            const std::uint32_t n = i * kWidth + static_cast<std::uint32_t>(k);
            TextureQuery<Scalar> query = random_query(n);
            const float size = std::exp2(-8 * uniform(n, 7));
            if (n % 3 != 0) query.footprint = {size, size * (0.5f + uniform(n, 8))};
            if (n % 4 != 0) query.footprint_axis = {uniform(n, 9), uniform(n, 10) - 0.5f};
            return query;
          }));
        for (std::uint32_t i = 0; i < 50; ++i)
          CHECK(same(lookup_texture<Scalar>(view, 0, random_query(i)).c1,
                     lookup_texture<Scalar>(view_of(plain), 0, random_query(i)).c1));
      }
}

}  // namespace sheaf::test_mip_levels
