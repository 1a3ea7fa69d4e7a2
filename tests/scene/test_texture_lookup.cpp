// Texture lookups against a reference in double precision: formats, wrap modes, filters, gradients, checkerboards,
// attributes.
#include "scene/textures/texture_lookup.h"

#include "core/color.h"
#include "core/exr.h"
#include "core/rng.h"
#include "scene/compile/compile.h"
#include "scene/compile/compile_textures.h"
#include "scene/formats/mesh.h"
#include "scene/textures/lookups/bitmap.h"
#include "tests/support/capture.h"
#include "tests/support/lanes_testing.h"
#include "tests/support/media_testing.h"
#include "tests/support/picture_files.h"
#include "tests/support/records_testing.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace sheaf::test_texture_lookup {

namespace {

using Wrap = TextureWrap;
using Filter = TextureFilter;
constexpr Wrap kWraps[] = {Wrap::kRepeat, Wrap::kMirror, Wrap::kClamp};

float uniform(std::uint32_t i, std::uint32_t stream) { return random4<Scalar>(stream, i, 0, 0).x; }

/// An image as a file stores it, with its linear values.
struct TestPicture {
  std::filesystem::path file;
  int width = 0, height = 0, channels = 0;
  bool raw = false;
  std::vector<double> linear;  ///< from the lower left

  double at(int x, int y, int c) const { return linear[static_cast<std::size_t>((y * width + x) * channels + c)]; }
};

/// Writes an image of random values: 8 or 16 bits, or floats in [-1, 2] for `bits` 32.
TestPicture make_picture(const TemporaryFolder& folder, int width, int height, int channels, int bits, bool raw) {
  TestPicture p{folder / (bits == 32 ? "a.exr" : bits == 16 ? "a.tif" : "a.ppm"), width, height, channels, raw, {}};
  const int max_value = bits == 16 ? 65535 : 255;
  std::vector<int> values;
  Image image(width, height, channels == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"});
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    const float r = uniform(static_cast<std::uint32_t>(i), 1);
    image.data[i] = 3 * r - 1;
    values.push_back(static_cast<int>(r * static_cast<float>(max_value + 1)));
  }
  if (bits == 32) write_exr(p.file, image);
  if (bits == 16) write_tiff(p.file, width, height, channels, 16, values);
  if (bits == 8) write_pnm(p.file, width, height, channels, 255, values);
  for (int y = 0; y < height; ++y)
    for (int i = 0; i < width * channels; ++i) {
      const auto source = static_cast<std::size_t>((height - 1 - y) * width * channels + i);
      const double v = static_cast<double>(values[source]) / max_value;
      const double decoded = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
      p.linear.push_back(bits == 32 ? static_cast<double>(image.data[source]) : raw ? v : decoded);
    }
  return p;
}

int wrap_index(Wrap wrap, long long i, int n) {
  if (wrap == Wrap::kClamp) return static_cast<int>(std::clamp(i, 0LL, n - 1LL));
  const long long period = wrap == Wrap::kMirror ? 2 * n : n;
  const auto folded = static_cast<int>((i % period + period) % period);
  return folded < n ? folded : 2 * n - 1 - folded;
}

struct Place {
  double x, y;
};  ///< in texels: (0, 0) is the lower left corner of the image

Place place_of(const TextureDescription& texture, const TestPicture& p, double u, double v) {
  const auto& m = texture.to_uv;
  return {(m[0] * u + m[1] * v + m[2]) * p.width, (m[3] * u + m[4] * v + m[5]) * p.height};
}

double reference(const TextureDescription& texture, const TestPicture& p, double u, double v, int c) {
  const auto& model = std::get<BitmapDescription>(texture.model);
  const Place at = place_of(texture, p, u, v);
  const auto texel = [&](double x, double y) {
    return p.at(wrap_index(model.wrap_u, static_cast<long long>(x), p.width),
                wrap_index(model.wrap_v, static_cast<long long>(y), p.height), c);
  };
  if (model.filter == Filter::kNearest) return texel(std::floor(at.x), std::floor(at.y));
  const double x = std::floor(at.x - 0.5), y = std::floor(at.y - 0.5), s = at.x - 0.5 - x, t = at.y - 0.5 - y;
  return (1 - t) * ((1 - s) * texel(x, y) + s * texel(x + 1, y)) +
         t * ((1 - s) * texel(x, y + 1) + s * texel(x + 1, y + 1));
}

double luminance_of(const TextureDescription& texture, const TestPicture& p, double u, double v) {
  if (p.channels == 1) return reference(texture, p, u, v, 0);
  return 0.2126390 * reference(texture, p, u, v, 0) + 0.7151687 * reference(texture, p, u, v, 1) +
         0.0721923 * reference(texture, p, u, v, 2);
}

/// Distance in texels from the nearest line where the value (nearest) or its slope (bilinear) is discontinuous.
double distance_from_jump(const TextureDescription& texture, Place at) {
  const double shift = std::get<BitmapDescription>(texture.model).filter == Filter::kNearest ? 0 : 0.5;
  return std::min(std::fabs(at.x - shift - std::round(at.x - shift)),
                  std::fabs(at.y - shift - std::round(at.y - shift)));
}

TextureDescription describe(const TestPicture& p, Filter filter, Wrap wrap_u, Wrap wrap_v) {
  BitmapDescription model;
  model.file = p.file;
  model.filter = filter;
  model.wrap_u = wrap_u;
  model.wrap_v = wrap_v;
  model.raw = p.raw;
  TextureDescription texture;
  texture.model = model;
  return texture;
}

TextureView view_of(const TextureTables& textures) {
  TextureView view;
  view.rows = textures.rows.data();
  view.tiles = textures.tiles.get();
  view.grids = textures.grid_rows.data();
  return view;
}

TextureQuery<Scalar> query_at(float u, float v) { return {{u, v}, 0, 0, 0, 0}; }

/// Random positions in [-2, 3]^2.
TextureQuery<Scalar> random_query(std::uint32_t i) { return query_at(5 * uniform(i, 2) - 2, 5 * uniform(i, 3) - 2); }

TextureQuery<Wide> wide_query(const std::function<TextureQuery<Scalar>(int)>& lane_query) {
  return {
      {wide_floats([&](int k) { return lane_query(k).uv.x; }), wide_floats([&](int k) { return lane_query(k).uv.y; })},
      wide_uints([&](int k) { return lane_query(k).shape; }),
      wide_uints([&](int k) { return lane_query(k).primitive; }),
      wide_floats([&](int k) { return lane_query(k).b1; }),
      wide_floats([&](int k) { return lane_query(k).b2; }),
      wide_record<Vec3>([&](int k) { return lane_query(k).p; })};
}

/// Largest difference between SIMD and scalar lookups of a texture. They are equal except where the compiler fuses a
/// product and a sum, which slopes amplify by the size of the image.
struct LaneDifference {
  double value = 0, slope = 0;
};

LaneDifference compare_lanes(const TextureView& view, std::uint32_t texture,
                             const std::function<TextureQuery<Scalar>(int)>& lane_query) {
  const TextureQuery<Wide> query = wide_query(lane_query);
  const Spectrum<Wide> color = lookup_texture<Wide>(view, texture, query);
  const WideFloat scalar = lookup_scalar<Wide>(view, texture, query);
  const Vec2<Wide> gradient = lookup_scalar_gradient<Wide>(view, texture, query);
  LaneDifference d;
  for (int k = 0; k < kWidth; ++k) {
    const TextureQuery<Scalar> q = lane_query(k);
    const Spectrum4 c = lookup_texture<Scalar>(view, texture, q);
    const Vec2f g = lookup_scalar_gradient<Scalar>(view, texture, q);
    d.value =
        std::max({d.value, difference(color.c0[k], c.c0), difference(color.c1[k], c.c1), difference(color.c2[k], c.c2),
                  difference(color.c3[k], c.c3), difference(scalar[k], lookup_scalar<Scalar>(view, texture, q))});
    d.slope = std::max({d.slope, difference(gradient.x[k], g.x), difference(gradient.y[k], g.y)});
  }
  return d;
}

bool lanes_agree(const TextureView& view, std::uint32_t texture,
                 const std::function<TextureQuery<Scalar>(int)>& lane_query) {
  const LaneDifference d = compare_lanes(view, texture, lane_query);
  return d.value < 1e-6 && d.slope < 2e-5;
}

/// Largest errors of the lookups of one texture at random positions.
struct Errors {
  double color = 0, scalar = 0, gradient = 0;
};

Errors measure(const TextureDescription& texture, const TestPicture& p, const TextureView& view,
               std::uint32_t queries) {
  constexpr double kMargin = 1e-3, kStep = 1e-5;
  Errors errors;
  for (std::uint32_t i = 0; i < queries; ++i) {
    const TextureQuery<Scalar> q = random_query(i);
    const double u = q.uv.x, v = q.uv.y;
    if (distance_from_jump(texture, place_of(texture, p, u, v)) < kMargin) continue;
    const Spectrum4 color = lookup_texture<Scalar>(view, 0, q);
    const float channels[] = {color.c0, color.c1, color.c2};
    for (int c = 0; c < 3; ++c) {
      const double expected = reference(texture, p, u, v, p.channels == 1 ? 0 : c);
      errors.color = std::max(errors.color, std::fabs(static_cast<double>(channels[c]) - expected));
    }
    errors.color = std::max(errors.color, std::fabs(static_cast<double>(color.c3)));
    errors.scalar = std::max(errors.scalar, std::fabs(static_cast<double>(lookup_scalar<Scalar>(view, 0, q)) -
                                                      luminance_of(texture, p, u, v)));
    const Vec2f gradient = lookup_scalar_gradient<Scalar>(view, 0, q);
    const auto slope = [&](double du, double dv) {
      return (luminance_of(texture, p, u + du, v + dv) - luminance_of(texture, p, u - du, v - dv)) / (2 * kStep);
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
      const TestPicture p = make_picture(folder, width, height, channels, bits, raw);
      for (const Filter filter : {Filter::kBilinear, Filter::kNearest})
        for (const Wrap wrap_u : kWraps)
          for (const Wrap wrap_v : kWraps) {
            const TextureDescription texture = describe(p, filter, wrap_u, wrap_v);
            const TextureTables compiled = compile_textures({texture});
            const TextureView view = view_of(compiled);
            const Errors errors = measure(texture, p, view, 60);
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
  const TestPicture p = make_picture(folder, 12, 5, 3, 8, true);
  for (const Filter filter : {Filter::kBilinear, Filter::kNearest}) {
    TextureDescription texture = describe(p, filter, Wrap::kRepeat, Wrap::kMirror);
    texture.to_uv = {1.25f, -0.5f, 0.3f, 0.75f, 2, -0.6f};
    const TextureTables compiled = compile_textures({texture});
    const Errors errors = measure(texture, p, view_of(compiled), 2000);
    CHECK(errors.color < 1e-4);
    CHECK(errors.scalar < 1e-4);
    CHECK(errors.gradient < 3e-3);
  }
}

TEST_CASE("texture lookup: the origin is the lower left corner and texel centres are at halves") {
  const TemporaryFolder folder;
  write_pnm(folder / "a.pgm", 3, 2, 1, 255, {10, 20, 30, 40, 50, 60});
  TestPicture p;
  p.file = folder / "a.pgm";
  p.raw = true;
  for (const Filter filter : {Filter::kBilinear, Filter::kNearest}) {
    const TextureTables compiled = compile_textures({describe(p, filter, Wrap::kRepeat, Wrap::kRepeat)});
    const auto byte = [&](float u, float v) {
      return 255 * lookup_scalar<Scalar>(view_of(compiled), 0, query_at(u, v));
    };
    CHECK(byte(0.5f / 3, 0.25f) == doctest::Approx(40));
    CHECK(byte(2.5f / 3, 0.25f) == doctest::Approx(60));
    CHECK(byte(0.5f / 3, 0.75f) == doctest::Approx(10));
    CHECK(byte(2.5f / 3, -0.25f) == doctest::Approx(30));
    CHECK(byte(1.0f / 3 - 1e-4f, 0.25f) == doctest::Approx(filter == Filter::kNearest ? 40 : 45).epsilon(1e-3));
    CHECK(byte(1.0f / 3 + 1e-4f, 0.25f) == doctest::Approx(filter == Filter::kNearest ? 50 : 45).epsilon(1e-3));
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
      const TestPicture p = make_picture(folder, 7, 9, channels, bits, true);
      const auto [low, high] = std::minmax_element(p.linear.begin(), p.linear.end());
      for (const Wrap wrap : kWraps)
        for (const Filter filter : {Filter::kBilinear, Filter::kNearest})
          for (const bool turned : {false, true}) {
            TextureDescription texture = describe(p, filter, wrap, wrap);
            if (turned) texture.to_uv = {0, -3e38f, 1, 3e38f, 0, 0};
            const TextureTables compiled = compile_textures({texture});
            const TextureView view = view_of(compiled);
            for (const float u : kStrange)
              for (const float v : kStrange) {
                const Spectrum4 c = lookup_texture<Scalar>(view, 0, query_at(u, v));
                const bool inside =
                    c.c0 >= *low - 1e-6 && c.c0 <= *high + 1e-6 && c.c2 >= *low - 1e-6 && c.c2 <= *high + 1e-6;
                CHECK(inside);
                const Vec2f g = lookup_scalar_gradient<Scalar>(view, 0, query_at(u, v));
                CHECK((turned || (is_finite(g.x) && is_finite(g.y))));
              }
            for (const float u : kStrange)
              for (std::size_t first = 0; first < std::size(kStrange); first += kWidth) {
                const LaneDifference d = compare_lanes(view, 0, [&](int k) {
                  return query_at(u, kStrange[(first + static_cast<std::size_t>(k)) % std::size(kStrange)]);
                });
                CHECK(d.value < 1e-6);
                CHECK((turned || d.slope < 2e-5));
              }
          }
    }
}

TEST_CASE("texture lookup: grid lines are at integral u and v") {
  TextureDescription grid;
  grid.model = GridTextureDescription{SpectrumDescription::constant(0.25f), SpectrumDescription::rgb(1, 2, 3), 0.1f};
  grid.to_uv = {2, 0, 0, 0, 1, 0.5f};
  const TextureTables compiled = compile_textures({grid});
  const TextureView view = view_of(compiled);
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const TextureQuery<Scalar> q = random_query(i);
    const double u = 2.0 * q.uv.x, v = q.uv.y + 0.5;
    const double from_line = std::min(std::abs(u - std::round(u)), std::abs(v - std::round(v)));
    if (std::abs(from_line - 0.1) < 1e-5) continue;
    CHECK(lookup_texture<Scalar>(view, 0, q).c1 == (from_line < 0.1 ? 2.0f : 0.25f));
    CHECK(lanes_agree(view, 0, [&](int k) { return random_query(i + 7 * static_cast<std::uint32_t>(k)); }));
  }
  grid.model = GridTextureDescription{SpectrumDescription::constant(0), SpectrumDescription::constant(1), -0.1f};
  CHECK_THROWS_AS(compile_textures({grid}), SceneError);
}

TEST_CASE("texture lookup: checkerboards alternate between children with individual transforms") {
  const TemporaryFolder folder;
  const TestPicture p = make_picture(folder, 16, 8, 3, 8, false);
  TextureDescription outer, inner;
  outer.model = CheckerboardDescription{TextureId{1}, TextureId{2}};
  outer.to_uv = {0.5f, 0, 0, 0, 0.5f, 0.25f};
  inner.model = CheckerboardDescription{SpectrumDescription::rgb(0.25f, 0.5f, 0.75f), SpectrumDescription::constant(2)};
  const TextureDescription picture = describe(p, Filter::kBilinear, Wrap::kRepeat, Wrap::kRepeat);
  const TextureTables compiled = compile_textures({outer, inner, picture});
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
  CHECK(lookup_scalar<Scalar>(view, 3, query_at(0, 0)) == doctest::Approx(luminance({0.25f, 0.5f, 0.75f})));
  CHECK(lookup_scalar<Scalar>(view, 4, query_at(0, 0)) == 2.0f);
  for (std::uint32_t i = 0; i < 200; ++i)
    CHECK(lanes_agree(view, 0, [&](int k) { return random_query(i + 7 * static_cast<std::uint32_t>(k)); }));
  CHECK(lookup_scalar_gradient<Scalar>(view, 0, query_at(0.3f, 0.3f)).x == 0.0f);
  const float strange =
      lookup_texture<Scalar>(view, 1, query_at(std::numeric_limits<float>::quiet_NaN(), kInfinity)).c0;
  CHECK((strange == 0.25f || strange == 2.0f));
}

TEST_CASE("texture lookup: mesh attributes of vertices and faces are interpolated") {
  TextureDescription descriptions[4];
  const char* names[] = {"vertex_color", "vertex_weight", "face_color", "face_missing"};
  for (int i = 0; i < 4; ++i) descriptions[i].model = MeshAttributeDescription{names[i], i == 0 ? 2.0f : 1.0f};
  TextureTables textures = compile_textures({std::begin(descriptions), std::end(descriptions)});
  // Shape 1 has triangles 2 and 3 of the scene, with the vertices (0, 1, 2) and (2, 1, 3) of the shape.
  const std::uint32_t triangles[] = {9, 9, 9, 9, 9, 9, 0, 1, 2, 2, 1, 3, 0, 0, 0};
  AttributeTable table(textures.attribute_names);
  table.add(1, 2, 2, 4, {"vertex_color", 3, {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0.5f}}, {});
  table.add(1, 2, 2, 4, {"vertex_weight", 1, {1, 2, 4, 8}}, {});
  table.add(1, 2, 2, 4, {"face_color", 3, {1, 2, 3, 4, 5, 6}}, {});
  table.finish(3);
  TextureView view = view_of(textures);
  view.attributes = table.entries().data();
  view.attribute_values = table.values().data();
  view.triangles = triangles;
  view.shape_count = 3;

  const TextureQuery<Scalar> second{{0, 0}, 1, 1, 0.25f, 0.5f};
  const Spectrum4 color = lookup_texture<Scalar>(view, 0, second);
  CHECK(color.c0 == doctest::Approx(2 * (0.25 * 0 + 0.25 * 0 + 0.5 * 1)));
  CHECK(color.c1 == doctest::Approx(2 * (0.25 * 0 + 0.25 * 1 + 0.5 * 1)));
  CHECK(color.c2 == doctest::Approx(2 * (0.25 * 1 + 0.25 * 0 + 0.5 * 0.5)));
  CHECK(lookup_scalar<Scalar>(view, 0, second) == doctest::Approx(luminance({color.c0, color.c1, color.c2})));
  const TextureQuery<Scalar> first{{0, 0}, 1, 0, 0.25f, 0.5f};
  CHECK(lookup_scalar<Scalar>(view, 1, first) == doctest::Approx(0.25 * 1 + 0.25 * 2 + 0.5 * 4));
  CHECK(lookup_texture<Scalar>(view, 1, first).c2 == lookup_scalar<Scalar>(view, 1, first));
  CHECK(lookup_texture<Scalar>(view, 2, first).c1 == 2.0f);
  CHECK(lookup_texture<Scalar>(view, 2, second).c2 == 6.0f);
  CHECK(max_component(lookup_texture<Scalar>(view, 3, second)) == 0.0f);
  for (const std::uint32_t other : {0u, 2u})
    for (std::uint32_t texture = 0; texture < 4; ++texture)
      CHECK(max_component(lookup_texture<Scalar>(view, texture, {{0, 0}, other, 0, 0.3f, 0.3f})) == 0.0f);

  for (std::uint32_t texture = 0; texture < 4; ++texture)
    for (std::uint32_t i = 0; i < 20; ++i)
      CHECK(lanes_agree(view, texture, [&](int k) {
        const auto r = i * 8 + static_cast<std::uint32_t>(k);
        return TextureQuery<Scalar>{{0, 0},
                                    r % 5 < 3 ? r % 3 : 0xffffffffu,
                                    r % 7 < 5 ? r % 2 : 0xfffffff0u,
                                    0.5f * uniform(r, 5),
                                    0.5f * uniform(r, 6)};
      }));
}

TEST_CASE("texture lookup: volumes are evaluated at the position in world space") {
  const TemporaryFolder folder;
  const auto colors = write_vol(folder / "rgb.vol", 8, 3, [](Vec3f p, int c) {
    return c == 0 ? p.x : c == 1 ? p.y : p.z;
  });
  const auto numbers = write_vol(folder / "grey.vol", 8, 1, [](Vec3f p, int) { return p.x * p.z; });
  TextureDescription rgb, grey, nearest;
  // The cube [1, 3] x [0, 2] x [0, 2].
  const Transform place = Transform::translate({1, 0, 0}) * Transform::scale({2, 2, 2});
  rgb.model = VolumeTextureDescription{vol(colors, place), 0.5f};
  grey.model = VolumeTextureDescription{vol(numbers, place), 1};
  VolumeTextureDescription blocks{vol(colors, place), 1};
  blocks.grid.filter = GridFilter::kNearest;
  blocks.grid.wrap = GridVolumeDescription::Wrap::kRepeat;
  nearest.model = blocks;
  const TextureTables compiled = compile_textures({rgb, grey, nearest});
  const TextureView view = view_of(compiled);
  const auto at = [](Vec3f p) { return TextureQuery<Scalar>{{0.9f, 0.1f}, 0, 0, 0, 0, p}; };
  const Spectrum4 color = lookup_texture<Scalar>(view, 0, at({2.2f, 1.5f, 0.3f}));
  CHECK(record_difference<Spectrum>(color, {0.5f * 0.6f, 0.5f * 0.75f, 0.5f * 0.15f, 0}) < 1e-5);
  CHECK(lookup_scalar<Scalar>(view, 0, at({2.2f, 1.5f, 0.3f})) == doctest::Approx(luminance({0.3f, 0.375f, 0.075f})));
  CHECK(lookup_texture<Scalar>(view, 0, at({9, 1, 1})).c0 == doctest::Approx(0.5 * 15 / 16));
  // At voxel centres products are exact.
  CHECK(lookup_scalar<Scalar>(view, 1, at({1 + 2 * 5.5f / 8, 1, 2 * 2.5f / 8})) == doctest::Approx(5.5 / 8 * 2.5 / 8));
  CHECK(lookup_texture<Scalar>(view, 1, at({1 + 2 * 5.5f / 8, 1, 2 * 2.5f / 8})).c2 == doctest::Approx(5.5 * 2.5 / 64));
  CHECK(lookup_texture<Scalar>(view, 2, at({1.1f + 2, 0.9f, 0.1f})).c0 == doctest::Approx(0.5 / 8));
  CHECK(lookup_texture<Scalar>(view, 2, at({1.1f, 0.9f, 0.1f})).c1 == doctest::Approx(3.5 / 8));
  for (std::uint32_t texture = 0; texture < 3; ++texture)
    CHECK(lanes_agree(view, texture, [&](int k) {
      const auto r = static_cast<std::uint32_t>(k);
      return at({4 * uniform(r, 5), 4 * uniform(r, 6) - 1, 4 * uniform(r, 7) - 1});
    }));
}

TEST_CASE("texture lookup: volumes as light or bump textures are rejected") {
  const TemporaryFolder folder;
  const auto numbers = write_vol(folder / "grey.vol", 2, 1, [](Vec3f, int) { return 0.5f; });
  Description d = empty_scene(1, 1);
  TextureDescription texture;
  texture.model = VolumeTextureDescription{vol(numbers), 1};
  d.textures.push_back(texture);
  const MaterialId grey = add_diffuse(d, 0.5f);
  add_sphere(d, {0, 0, 0}, 1, grey).radiance = TextureId{0};
  CHECK_THROWS_WITH_AS(compile_scene(d), doctest::Contains("a grid in the world, expected one that follows"),
                       SceneError);
  TextureDescription board;
  board.model = CheckerboardDescription{SpectrumDescription::constant(1), TextureId{0}};
  d.textures.push_back(board);
  d.shapes[0].radiance = TextureId{1};
  CHECK_THROWS_AS(compile_scene(d), SceneError);
  d.textures[1].model = MixTextureDescription{SpectrumDescription::constant(1), TextureId{0}, 0.5f};
  CHECK_THROWS_AS(compile_scene(d), SceneError);
  d.shapes[0].radiance.reset();
  CHECK_NOTHROW(compile_scene(d));
  d.shapes[0].material = add_material(d, BumpMapDescription{TextureId{0}, 1, grey});
  CHECK_THROWS_WITH_AS(compile_scene(d), doctest::Contains("expected a texture over uv"), SceneError);
}

TEST_CASE("texture lookup: wireframes follow the edges of triangles") {
  TextureDescription fixed, relative;
  fixed.model =
      WireframeDescription{SpectrumDescription::rgb(1, 0.5f, 0), SpectrumDescription::constant(0), 0.4f, 0.5f};
  relative.model = WireframeDescription{SpectrumDescription::constant(1), SpectrumDescription::constant(0), 0, 0};
  TextureTables textures = compile_textures({fixed, relative});
  // A right triangle with legs 3 and 4, and one twice as large.
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {3, 0, 0}, {0, 4, 0}, {0, 0, 1}, {6, 0, 1}, {0, 8, 1}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  const std::uint32_t triangles[] = {0, 1, 2, 3, 4, 5, 0, 0, 0};
  AttributeTable table(textures.attribute_names);
  table.add(0, 0, 2, 6, {kEdgeDistances, 3, edge_distances(mesh, false)}, {});
  table.add(0, 0, 2, 6, {kRelativeEdgeDistances, 3, edge_distances(mesh, true)}, {});
  table.finish(2);
  TextureView view = view_of(textures);
  view.attributes = table.entries().data();
  view.attribute_values = table.values().data();
  view.triangles = triangles;
  view.shape_count = 2;

  const auto at = [&](std::uint32_t texture, std::uint32_t triangle, float x, float y) {
    const float scale = triangle == 0 ? 1.0f : 2.0f;
    return lookup_texture<Scalar>(view, texture, {{0, 0}, 0, triangle, x / (3 * scale), y / (4 * scale)});
  };
  // In the middle of the smooth step: 3/4 of the line width.
  for (const std::uint32_t triangle : {0u, 1u}) {
    CHECK(at(0, triangle, 1, 0.3f).c0 == doctest::Approx(0.5));
    CHECK(at(0, triangle, 0.3f, 1).c1 == doctest::Approx(0.25));
    CHECK(at(0, triangle, 1, 0.19f).c0 == 0.0f);
    CHECK(at(0, triangle, 1, 0.41f).c0 == doctest::Approx(1));
    CHECK(at(0, triangle, 1, 0.41f).c2 == 0.0f);
  }
  // 0.3 from the hypotenuse, whose unit normal is (0.8, 0.6).
  CHECK(at(0, 0, 1.5f - 0.3f * 0.8f, 2 - 0.3f * 0.6f).c0 == doctest::Approx(0.5).epsilon(1e-3));
  // The mean edge length is 6: lines of width 0.6 without a smooth step.
  CHECK(at(1, 1, 1, 0.59f).c0 == 0.0f);
  CHECK(at(1, 1, 1, 0.61f).c0 == 1.0f);
  CHECK(lookup_scalar<Scalar>(view, 0, {{0, 0}, 0, 0, 1.0f / 3, 0.1f}) == doctest::Approx(luminance({1, 0.5f, 0})));
  CHECK(lookup_texture<Scalar>(view, 0, {{0, 0}, 1, 0, 0, 0}).c0 == 1.0f);  // a shape without triangles
  for (std::uint32_t i = 0; i < 50; ++i)
    CHECK(lanes_agree(view, 0, [&](int k) {
      const auto r = i * 8 + static_cast<std::uint32_t>(k);
      return TextureQuery<Scalar>{{0, 0}, r % 5 == 0 ? 1u : 0u, r % 2, 0.5f * uniform(r, 5), 0.5f * uniform(r, 6)};
    }));
}

TEST_CASE("texture lookup: bindings give numbers or reflectances or unbounded colours") {
  TextureDescription board;
  board.model = CheckerboardDescription{SpectrumDescription::rgb(3, 0.5f, -1), SpectrumDescription::rgb(3, 0.5f, -1)};
  const TextureTables compiled = compile_textures({board});
  const TextureView view = view_of(compiled);
  const auto bound = [&](std::uint32_t words, TextureRole role) {
    return lookup_binding<Scalar>(view, {0, 0, words, role}, query_at(0, 0));
  };
  const float red = lookup_texture<Scalar>(view, 0, query_at(0, 0)).c0,
              blue = lookup_texture<Scalar>(view, 0, query_at(0, 0)).c2;
  CHECK(red == 3.0f);
  CHECK(bound(1, TextureRole::kScalar).c0 == doctest::Approx(luminance({red, 0.5f, blue})));
  CHECK(bound(4, TextureRole::kReflectance).c0 == 1.0f);
  CHECK(bound(4, TextureRole::kReflectance).c1 == 0.5f);
  CHECK(bound(4, TextureRole::kReflectance).c2 == 0.0f);
  CHECK(bound(4, TextureRole::kReflectance).c3 == 0.0f);
  CHECK(bound(4, TextureRole::kUnbounded).c0 == 3.0f);
}

}  // namespace sheaf::test_texture_lookup
