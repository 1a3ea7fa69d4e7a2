// Lookups of bitmaps against a reference in double precision: formats, wrap modes, filters and slopes. Checkerboards of
// bitmaps.
#include "scene/textures/texture_lookup.h"

#include "core/color/color.h"
#include "core/image/exr.h"
#include "scene/compile/textures/compile_textures.h"
#include "scene/textures/lookups/bitmap.h"
#include "tests/scene/textures/texture_lookups.h"
#include "tests/support/capture.h"
#include "tests/support/files/image_files.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

namespace sheaf::test_bitmap_lookup {

using namespace texture_lookups;

namespace {

using Wrap = TextureWrap;
using Filter = TextureFilter;
constexpr Wrap kWraps[] = {Wrap::kRepeat, Wrap::kMirror, Wrap::kClamp};

/// An image as a file stores it, with its linear values.
struct TestImage {
  std::filesystem::path file;
  int width = 0, height = 0, channels = 0;
  bool raw = false;
  std::vector<double> linear;  ///< from the lower left

  double at(int x, int y, int c) const { return linear[static_cast<std::size_t>((y * width + x) * channels + c)]; }
};

/// Writes an image of random values: 8 or 16 bits, or floats in [-1, 2] for `bits` 32.
TestImage make_image(const TemporaryFolder& folder, int width, int height, int channels, int bits, bool raw) {
  TestImage image{folder / (bits == 32 ? "a.exr" : bits == 16 ? "a.tif" : "a.ppm"), width, height, channels, raw, {}};
  const int max_value = bits == 16 ? 65535 : 255;
  std::vector<int> values;
  Image floats(width, height, channels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"});
  for (std::size_t i = 0; i < floats.data.size(); ++i) {
    const float r = uniform(static_cast<std::uint32_t>(i), 1);
    floats.data[i] = 3 * r - 1;
    values.push_back(static_cast<int>(r * static_cast<float>(max_value + 1)));
  }
  if (bits == 32) write_exr(image.file, floats);
  if (bits == 16) write_tiff(image.file, width, height, channels, 16, values);
  if (bits == 8) write_pnm(image.file, width, height, channels, 255, values);
  for (int y = 0; y < height; ++y)
    for (int i = 0; i < width * channels; ++i) {
      const auto source = static_cast<std::size_t>((height - 1 - y) * width * channels + i);
      const double v = static_cast<double>(values[source]) / max_value;
      const double decoded = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
      image.linear.push_back(bits == 32 ? static_cast<double>(floats.data[source]) : raw ? v : decoded);
    }
  return image;
}

int wrap_index(Wrap wrap, long long i, int n) {
  if (wrap == Wrap::kClamp) return static_cast<int>(std::clamp(i, 0LL, n - 1LL));
  const long long period = wrap == Wrap::kMirror ? 2 * n : n;
  const auto folded = static_cast<int>((i % period + period) % period);
  return folded < n ? folded : 2 * n - 1 - folded;
}

/// A position in texels: (0, 0) is the lower left corner of the image.
struct Place {
  double x, y;
};

Place position_of(const TextureDescription& texture, const TestImage& image, double u, double v) {
  const auto& m = texture.to_uv;
  return {(m[0] * u + m[1] * v + m[2]) * image.width, (m[3] * u + m[4] * v + m[5]) * image.height};
}

/// The value of a channel in double precision.
double reference(const TextureDescription& texture, const TestImage& image, double u, double v, int c) {
  const auto& model = std::get<BitmapDescription>(texture.model);
  const Place at = position_of(texture, image, u, v);
  const auto texel = [&](double x, double y) {
    return image.at(wrap_index(model.wrap_u, static_cast<long long>(x), image.width),
                    wrap_index(model.wrap_v, static_cast<long long>(y), image.height), c);
  };
  if (model.filter == Filter::kNearest) return texel(std::floor(at.x), std::floor(at.y));
  const double x = std::floor(at.x - 0.5), y = std::floor(at.y - 0.5), s = at.x - 0.5 - x, t = at.y - 0.5 - y;
  return (1 - t) * ((1 - s) * texel(x, y) + s * texel(x + 1, y)) +
         t * ((1 - s) * texel(x, y + 1) + s * texel(x + 1, y + 1));
}

double luminance_of(const TextureDescription& texture, const TestImage& image, double u, double v) {
  if (image.channels == 1) return reference(texture, image, u, v, 0);
  return 0.2126390 * reference(texture, image, u, v, 0) + 0.7151687 * reference(texture, image, u, v, 1) +
         0.0721923 * reference(texture, image, u, v, 2);
}

/// Distance in texels from the nearest line where the value (nearest) or its slope (bilinear) is discontinuous.
double distance_from_jump(const TextureDescription& texture, Place at) {
  const double shift = std::get<BitmapDescription>(texture.model).filter == Filter::kNearest ? 0 : 0.5;
  return std::min(std::fabs(at.x - shift - std::round(at.x - shift)),
                  std::fabs(at.y - shift - std::round(at.y - shift)));
}

TextureDescription describe(const TestImage& image, Filter filter, Wrap wrap_u, Wrap wrap_v) {
  BitmapDescription model;
  model.file = image.file;
  model.filter = filter;
  model.wrap_u = wrap_u;
  model.wrap_v = wrap_v;
  model.raw = image.raw;
  TextureDescription texture;
  texture.model = model;
  return texture;
}

/// Largest errors of the lookups of one texture at random positions.
struct Errors {
  double color = 0, scalar = 0, gradient = 0;
};

Errors measure(const TextureDescription& texture, const TestImage& image, const TextureView& view,
               std::uint32_t queries) {
  constexpr double kMargin = 1e-3, kStep = 1e-5;
  Errors errors;
  for (std::uint32_t i = 0; i < queries; ++i) {
    const TextureQuery<Scalar> q = random_query(i);
    const double u = q.uv.x, v = q.uv.y;
    if (distance_from_jump(texture, position_of(texture, image, u, v)) < kMargin) continue;
    const Spectrum4 color = lookup_texture<Scalar>(view, 0, q);
    const float channels[] = {color.c0, color.c1, color.c2};
    for (int c = 0; c < 3; ++c) {
      const double expected = reference(texture, image, u, v, image.channels == 1 ? 0 : c);
      errors.color = std::max(errors.color, std::fabs(static_cast<double>(channels[c]) - expected));
    }
    errors.color = std::max(errors.color, std::fabs(static_cast<double>(color.c3)));
    errors.scalar = std::max(errors.scalar, std::fabs(static_cast<double>(lookup_scalar<Scalar>(view, 0, q)) -
                                                      luminance_of(texture, image, u, v)));
    const Vec2f gradient = lookup_scalar_gradient<Scalar>(view, 0, q);
    const auto slope = [&](double du, double dv) {
      return (luminance_of(texture, image, u + du, v + dv) - luminance_of(texture, image, u - du, v - dv)) /
             (2 * kStep);
    };
    errors.gradient = std::max({errors.gradient, std::fabs(static_cast<double>(gradient.x) - slope(kStep, 0)),
                                std::fabs(static_cast<double>(gradient.y) - slope(0, kStep))});
  }
  return errors;
}

}  // namespace

TEST_CASE("texture lookup: bytes are decoded by the sRGB transfer function") {
  float last = -1;
  for (int i = 0; i < 256; ++i) {
    const double v = i / 255.0, exact = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
    const auto byte = static_cast<float>(i);
    const float decoded = decode_srgb_byte(byte);
    CHECK(std::fabs(static_cast<double>(decoded) - exact) < 6e-6);
    CHECK(decoded > last);
    CHECK(same(decode_srgb_byte(WideFloat(byte))[kWidth - 1], decoded));
    last = decoded;
  }
  CHECK(decode_srgb_byte(0.0f) == 0.0f);
  CHECK(last == 1.0f);
}

TEST_CASE("texture lookup: bytes are gathered from any address") {
  std::vector<std::uint8_t> bytes(103);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(37 * i + 1);
  const WideUint got =
      gather_bytes(bytes.data(), wide_uints([](int k) { return static_cast<std::uint32_t>(99 - 5 * k); }));
  for (int k = 0; k < kWidth; ++k) CHECK(got[k] == bytes[static_cast<std::size_t>(99 - 5 * k)]);
}

TEST_CASE("texture lookup: every format and wrap mode and filter matches the reference") {
  const TemporaryFolder folder;
  for (const auto& [channels, bits, raw] : {std::tuple{1, 8, false},
                                            {1, 8, true},
                                            {3, 8, false},
                                            {3, 8, true},
                                            {1, 16, false},
                                            {3, 16, true},
                                            {1, 32, false},
                                            {3, 32, true}})
    for (const auto& [width, height] : {std::pair{1, 1}, {5, 3}, {16, 16}, {33, 9}}) {
      const TestImage image = make_image(folder, width, height, channels, bits, raw);
      for (const Filter filter : {Filter::kBilinear, Filter::kNearest})
        for (const Wrap wrap_u : kWraps)
          for (const Wrap wrap_v : kWraps) {
            const TextureDescription texture = describe(image, filter, wrap_u, wrap_v);
            const TextureTables compiled = compile_textures({texture});
            const TextureView view = view_of(compiled);
            const Errors errors = measure(texture, image, view, 60);
            CAPTURE_BINDING(channels);
            CAPTURE_BINDING(bits);
            CAPTURE_BINDING(width);
            CAPTURE(static_cast<int>(filter));
            CAPTURE(static_cast<int>(wrap_u));
            CAPTURE(static_cast<int>(wrap_v));
            // Rounding of u moves the position by about 1e-5 texels, which changes values by up to three times as much
            // for floats.
            CHECK(errors.color < 6e-5);
            CHECK(errors.scalar < 6e-5);
            CHECK(errors.gradient < 6e-5 * 33);
            for (int i = 0; i < 4; ++i)
              CHECK(lanes_agree(view, 0,
                                [&](int k) { return random_query(static_cast<std::uint32_t>(i * kWidth + k)); }));
          }
    }
}

TEST_CASE("texture lookup: the uv transform applies to values and slopes") {
  const TemporaryFolder folder;
  const TestImage image = make_image(folder, 12, 5, 3, 8, true);
  for (const Filter filter : {Filter::kBilinear, Filter::kNearest}) {
    TextureDescription texture = describe(image, filter, Wrap::kRepeat, Wrap::kMirror);
    texture.to_uv = {1.25f, -0.5f, 0.3f, 0.75f, 2, -0.6f};
    const TextureTables compiled = compile_textures({texture});
    const Errors errors = measure(texture, image, view_of(compiled), 2000);
    CHECK(errors.color < 1e-4);
    CHECK(errors.scalar < 1e-4);
    CHECK(errors.gradient < 3e-3);
  }
}

TEST_CASE("texture lookup: the origin is the lower left corner and texel centers are at halves") {
  const TemporaryFolder folder;
  write_pnm(folder / "a.pgm", 3, 2, 1, 255, {10, 20, 30, 40, 50, 60});
  TestImage image;
  image.file = folder / "a.pgm";
  image.raw = true;
  for (const Filter filter : {Filter::kBilinear, Filter::kNearest}) {
    const TextureTables compiled = compile_textures({describe(image, filter, Wrap::kRepeat, Wrap::kRepeat)});
    const auto byte = [&](float u, float v) {
      return 255 * lookup_scalar<Scalar>(view_of(compiled), 0, query_at(u, v));
    };
    CHECK(byte(0.5f / 3, 0.25f) == near(40));
    CHECK(byte(2.5f / 3, 0.25f) == near(60));
    CHECK(byte(0.5f / 3, 0.75f) == near(10));
    CHECK(byte(2.5f / 3, -0.25f) == near(30));
    CHECK(byte(1.0f / 3 - 1e-4f, 0.25f) == near(filter == Filter::kNearest ? 40 : 45, 1e-3));
    CHECK(byte(1.0f / 3 + 1e-4f, 0.25f) == near(filter == Filter::kNearest ? 50 : 45, 1e-3));
  }
}

TEST_CASE("texture lookup: any coordinates are valid") {
  const TemporaryFolder folder;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kStrange[] = {kNan,   kInfinity,   -kInfinity, 1e30f,       -1e30f,        3.4e38f,       -3.4e38f,
                                1e-45f, -1e-45f,     -1e-9f,     -0.0f,       0.0f,          1.0f,          -1.0f,
                                2.0f,   0.99999994f, 1.9999999f, 16777215.0f, 2147483648.0f, -4294967296.0f};
  for (const int bits : {8, 32})
    for (const int channels : {1, 3}) {
      const TestImage image = make_image(folder, 7, 9, channels, bits, true);
      const auto [low, high] = std::minmax_element(image.linear.begin(), image.linear.end());
      for (const Wrap wrap : kWraps)
        for (const Filter filter : {Filter::kBilinear, Filter::kNearest})
          for (const bool rotated : {false, true}) {
            TextureDescription texture = describe(image, filter, wrap, wrap);
            if (rotated) texture.to_uv = {0, -3e38f, 1, 3e38f, 0, 0};
            const TextureTables compiled = compile_textures({texture});
            const TextureView view = view_of(compiled);
            for (const float u : kStrange)
              for (const float v : kStrange) {
                const Spectrum4 c = lookup_texture<Scalar>(view, 0, query_at(u, v));
                const bool inside =
                    c.c0 >= *low - 1e-6 && c.c0 <= *high + 1e-6 && c.c2 >= *low - 1e-6 && c.c2 <= *high + 1e-6;
                CHECK(inside);
                const Vec2f g = lookup_scalar_gradient<Scalar>(view, 0, query_at(u, v));
                CHECK((rotated || (is_finite(g.x) && is_finite(g.y))));
              }
            for (const float u : kStrange)
              for (std::size_t first = 0; first < std::size(kStrange); first += kWidth) {
                const LaneDifference d = compare_lanes(view, 0, [&](int k) {
                  return query_at(u, kStrange[(first + static_cast<std::size_t>(k)) % std::size(kStrange)]);
                });
                CHECK(d.value < 1e-6);
                CHECK((rotated || d.slope < 2e-5));
              }
          }
    }
}

TEST_CASE("texture lookup: checkerboards alternate between children with individual transforms") {
  const TemporaryFolder folder;
  const TestImage image = make_image(folder, 16, 8, 3, 8, false);
  TextureDescription outer, inner;
  outer.model = CheckerboardDescription{TextureId{1}, TextureId{2}};
  outer.to_uv = {0.5f, 0, 0, 0, 0.5f, 0.25f};
  inner.model = CheckerboardDescription{SpectrumDescription::rgb(0.25f, 0.5f, 0.75f), SpectrumDescription::constant(2)};
  const TextureDescription bitmap = describe(image, Filter::kBilinear, Wrap::kRepeat, Wrap::kRepeat);
  const TextureTables compiled = compile_textures({outer, inner, bitmap});
  const TextureView view = view_of(compiled);
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const TextureQuery<Scalar> q = random_query(i);
    const auto even = [](double u, double v) { return std::fmod(std::floor(2 * u) + std::floor(2 * v), 2.0) == 0.0; };
    const bool first = even(0.5 * q.uv.x, 0.5 * q.uv.y + 0.25), inner_first = even(q.uv.x, q.uv.y);
    const std::uint32_t expected = first ? (inner_first ? 3 : 4) : 2;
    CHECK(same(lookup_texture<Scalar>(view, 0, q).c1, lookup_texture<Scalar>(view, expected, q).c1));
    CHECK(same(lookup_scalar<Scalar>(view, 0, q), lookup_scalar<Scalar>(view, expected, q)));
  }
  CHECK(lookup_texture<Scalar>(view, 3, query_at(0, 0)).c2 == 0.75f);
  CHECK(lookup_texture<Scalar>(view, 3, query_at(0, 0)).c3 == 0.0f);
  CHECK(lookup_scalar<Scalar>(view, 3, query_at(0, 0)) == near(luminance({0.25f, 0.5f, 0.75f})));
  CHECK(lookup_scalar<Scalar>(view, 4, query_at(0, 0)) == 2.0f);
  for (std::uint32_t i = 0; i < 200; ++i)
    CHECK(lanes_agree(view, 0, [&](int k) { return random_query(i + 7 * static_cast<std::uint32_t>(k)); }));
  CHECK(lookup_scalar_gradient<Scalar>(view, 0, query_at(0.3f, 0.3f)).x == 0.0f);
  const float strange =
      lookup_texture<Scalar>(view, 1, query_at(std::numeric_limits<float>::quiet_NaN(), kInfinity)).c0;
  CHECK((strange == 0.25f || strange == 2.0f));
}

}  // namespace sheaf::test_bitmap_lookup
