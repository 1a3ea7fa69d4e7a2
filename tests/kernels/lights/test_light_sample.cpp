// Light sampling for every kind of light: directions against the pdf that MIS uses for BSDF sampling, target points,
// light selection, and SIMD lanes against scalar code.
#include "tests/support/light_testing.h"

#include "core/image/image.h"
#include "scene/compile/compile.h"
#include "tests/support/capture.h"
#include "tests/support/chi_square.h"
#include "tests/support/near.h"
#include "tests/support/records_testing.h"
#include "tests/support/statistics.h"
#include "tests/support/tiny_scenes.h"
#include "tests/support/trace_testing.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace sheaf::test_light_sample {

namespace {

constexpr int kTests = 18;  // chi-square tests of directions in this file

const Transform kTilt = Transform::translate({0.3f, -0.2f, 3}) * Transform::rotate({1, 2, 0.5f}, 155);

/// Triangles of very different areas in different planes.
Mesh uneven_mesh() {
  Mesh mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0.2f}, {-1, 1, 0.1f}, {1.5f, 1.2f, -0.6f}, {1.6f, 1.0f, -0.6f}};
  mesh.triangles = {{0, 1, 2}, {2, 1, 3}, {3, 1, 4}};
  return mesh;
}

/// A single light of radiance 1.
template <class Geometry>
std::unique_ptr<Scene> lone_light(Geometry geometry, const Transform& to_world, bool flip = false) {
  Description d = empty_scene(4, 4);
  ShapeDescription& shape = emit(add_shape(d, std::move(geometry), to_world), 1);
  shape.flip_normals = flip;
  return compile_scene(d);
}

/// The first emissive surface on a ray beyond `t_near`.
struct Meeting {
  bool found = false;
  float t = 0, pdf = 0;  ///< pdf is 0 on the side that does not emit
};
Meeting meet(const SceneView& scene, Vec3f from, Vec3f direction, float t_near) {
  const auto hit = trace_ray(scene, from, direction, t_near);
  if (!hit) return {};
  const auto shape = gather_rows<Scalar>(scene.geometry.shapes, hit->shape);
  const auto y = surface_at(scene, from, direction, *hit);
  const bool lit = dot(direction, y.ng) < 0;
  const auto light = load_lights<Scalar>(scene, shape.light);
  const float choice = choice_probability<Scalar>(scene, {from, {}}, shape.light);
  return {true, hit->t,
          lit ? choice * light_pdf_solid_angle<Scalar>(scene, shape.light, light, true, {from, direction, hit->t, y.ng},
                                                       0.0f)
              : 0};
}

/// Pdf of sample_light() in a direction: the sum over all emissive surfaces along it.
double pdf_along(const SceneView& scene, Vec3f from, Vec3f direction) {
  double sum = 0;
  float t = 0;
  for (int i = 0; i < 16; ++i) {
    const Meeting m = meet(scene, from, direction, t);
    if (!m.found) break;
    sum += m.pdf;
    t = m.t * 1.0001f;
  }
  return sum;
}

std::optional<Vec3f> sampled_direction(const SceneView& scene, Vec3f from, const Random4<Scalar>& u) {
  const auto s = sample_any_light<Scalar>(scene, from, u);
  return s.valid ? std::optional<Vec3f>(s.direction) : std::nullopt;
}

/// A parametrization of directions: a plane window around an axis, or azimuth by z.
struct Chart {
  CellGrid grid;
  std::function<Vec3f(double, double)> direction;
  std::function<std::array<double, 2>(Vec3f)> position;
  std::function<double(double, double)> solid_angle;  ///< per unit area of the chart
};

/// `half`: tangent of the window's half angle. The window is rotated relative to the edges of the lights.
Chart window(Vec3f axis, double half) {
  Frame<Scalar> frame = Frame<Scalar>::from_normal(normalize(axis));
  const Vec3f s = frame.s * std::cos(0.4f) + frame.t * std::sin(0.4f);
  frame = {s, cross(frame.n, s), frame.n};
  return {{-half, half, -half, half, 16, 16},
          [frame](double x, double y) {
            return frame.to_world(normalize(Vec3f{static_cast<float>(x), static_cast<float>(y), 1}));
          },
          [frame](Vec3f w) {
            const Vec3f local = frame.to_local(w);
            return std::array<double, 2>{double(local.x) / local.z, double(local.y) / local.z};
          },
          [](double x, double y) { return std::pow(1 + x * x + y * y, -1.5); }};
}

Chart whole_sphere() {
  constexpr double kAzimuth = 6.283185307179586476925;
  return {{0, kAzimuth, -1, 1, 24, 16},
          [](double azimuth, double z) {
            const double r = std::sqrt(std::max(0.0, 1 - z * z));
            return Vec3f{static_cast<float>(r * std::cos(azimuth)), static_cast<float>(r * std::sin(azimuth)),
                         static_cast<float>(z)};
          },
          [](Vec3f w) {
            const double azimuth = std::atan2(double(w.y), double(w.x));
            return std::array<double, 2>{azimuth < 0 ? azimuth + kAzimuth : azimuth, double(w.z)};
          },
          [](double, double) { return 1.0; }};
}

/// Ten times the median pdf. Larger values occur at the silhouettes of curved lights, where the pdf is unbounded.
double density_limit(const SceneView& scene, Vec3f from) {
  std::vector<double> densities;
  for (std::uint32_t i = 0; i < 1001; ++i) {
    const auto direction = sampled_direction(scene, from, lane_random(43, i, 0));
    if (direction) densities.push_back(pdf_along(scene, from, *direction));
  }
  std::sort(densities.begin(), densities.end());
  return 10 * densities[densities.size() / 2];
}

/// Whether every sample of a light is valid, or only a part of them.
enum class Use { kWhole, kPart };

/// Chi-square test of sampled directions against pdf_along(). The pdf is discontinuous, so the cells of a chart are
/// integrated with stratified points. Samples that are invalid, outside of the chart or beyond density_limit() share
/// one extra cell.
void check_directions(const SceneView& scene, Vec3f from, const Chart& chart, Use use) {
  constexpr int kDraws = 50000, kStrata = 32;
  const CellGrid& grid = chart.grid;
  const double limit = density_limit(scene, from);
  const auto cells = static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows);
  std::vector<double> observed(cells + 1), expected(cells + 1);
  for (std::uint32_t i = 0; i < kDraws; ++i) {
    const auto direction = sampled_direction(scene, from, lane_random(40, i, 0));
    std::size_t cell = cells;
    if (direction && pdf_along(scene, from, *direction) <= limit) {
      const auto [x, y] = chart.position(*direction);
      const double column = std::floor((x - grid.x_min) / grid.cell_width()),
                   row = std::floor((y - grid.y_min) / grid.cell_height());
      if (column >= 0 && column < grid.columns && row >= 0 && row < grid.rows)
        cell = static_cast<std::size_t>(row * grid.columns + column);
    }
    observed[cell] += 1;
  }
  double integral = 0;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const auto columns = static_cast<std::size_t>(grid.columns);
    const std::size_t column = cell % columns, row = cell / columns;
    const double x0 = grid.x_min + static_cast<double>(column) * grid.cell_width();
    const double y0 = grid.y_min + static_cast<double>(row) * grid.cell_height();
    for (std::uint32_t i = 0; i < kStrata * kStrata; ++i) {
      const auto u = random4<Scalar>(39, static_cast<std::uint32_t>(cell), i, 0);
      const std::uint32_t right = i % kStrata, up = i / kStrata;
      const double x = x0 + (right + u.x) / kStrata * grid.cell_width(),
                   y = y0 + (up + u.y) / kStrata * grid.cell_height();
      const double pdf = pdf_along(scene, from, chart.direction(x, y));
      if (pdf <= limit)
        expected[cell] += pdf * chart.solid_angle(x, y) * grid.cell_width() * grid.cell_height() / (kStrata * kStrata);
    }
    integral += expected[cell];
    // A lower bound for expected counts, because strata may miss the tip of a light.
    expected[cell] = std::max(expected[cell] * kDraws, 1e-3);
  }
  expected[cells] = use == Use::kPart ? (1 - integral) * kDraws : 1e-3;
  CHECK(chi_square(observed, expected).p_value > significance_of_each(kTests));
  if (use == Use::kWhole) CHECK(integral == near(1, 2e-3));
  if (use == Use::kPart) CHECK(integral < 0.999);
}

/// Checks that every sample's pdf is that of the surface along its direction, that its target is just off that surface,
/// and that a convex light does not block its own samples.
void check_samples(const SceneView& scene, Vec3f from) {
  constexpr float kShadowEnd = 1 - 4 * 5.9604645e-8f;
  const double limit = density_limit(scene, from);
  double worst_pdf = 0;
  int valid = 0, blocked = 0, far = 0;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const auto s = sample_any_light<Scalar>(scene, from, lane_random(42, i, 0));
    if (!s.valid) continue;
    ++valid;
    blocked += trace_ray(scene, from, s.target - from, 0, kShadowEnd).has_value();
    const auto hit = trace_ray(scene, from, s.direction);
    if (s.pdf_solid_angle > limit || !hit) continue;
    const Vec3f ng = surface_at(scene, from, s.direction, *hit).ng;
    if (dot(ng, s.direction) > -0.05f) continue;  // silhouettes of spheres
    worst_pdf = std::max(worst_pdf, std::fabs(meet(scene, from, s.direction, 0).pdf / double(s.pdf_solid_angle) - 1));
    const auto below = trace_ray(scene, s.target, -ng);
    far += !below || below->t > 1e-5f * (1 + max_component(abs(s.target)));
  }
  CHECK(valid > 500);
  CHECK(blocked == 0);
  CHECK(far <= valid / 500);  // rims
  CHECK(worst_pdf < 5e-3);
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("light sampling: samples of rectangles follow their pdf") {
  const auto scene = lone_light(RectangleShape{}, kTilt * Transform::scale({1, 0.5f, 1}));
  check_directions(scene->view(), {0, 0, 0}, window({0.1f, 0, 1}, 0.6), Use::kWhole);
  check_samples(scene->view(), {0, 0, 0});
}

TEST_CASE("light sampling: samples of meshes with unequal triangles follow their pdf") {
  const auto scene = lone_light(uneven_mesh(), Transform::translate({0, 0, 3}) * Transform::rotate({0, 1, 0}, 160));
  check_directions(scene->view(), {0.2f, -0.1f, 0}, window({0, 0, 1}, 0.8), Use::kWhole);
  check_samples(scene->view(), {0.2f, -0.1f, 0});
}

TEST_CASE("light sampling: a cube is sampled on its visible faces") {
  const auto scene = lone_light(CubeShape{}, Transform::translate({0, 0, 4}) * Transform::rotate({1, 1, 0}, 35));
  check_directions(scene->view(), {0, 0, 0}, window({0, 0, 1}, 0.75), Use::kPart);
  check_samples(scene->view(), {0, 0, 0});
}

TEST_CASE("light sampling: a goniometric light follows its image with the first row towards -y") {
  Description d = empty_scene(4, 4);
  auto image = std::make_shared<Image>(8, 8, std::vector<std::string>{"Y"});
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x) image->at(x, y, 0) = (y < 4 ? 1.0f : 3.0f) * (x < 4 ? 1.0f : 5.0f);
  TextureDescription texture;
  BitmapDescription bitmap;
  bitmap.made = image;
  texture.model = bitmap;
  d.textures.push_back(texture);
  d.lights.push_back({GoniometricLightDescription{}, {}});
  const auto scene = compile_scene(d);
  for (const auto& [x, y] :
       {std::pair{-1.0f, -1.0f}, std::pair{1.0f, -1.0f}, std::pair{-1.0f, 1.0f}, std::pair{1.0f, 1.0f}}) {
    CAPTURE_BINDING(x);
    CAPTURE_BINDING(y);
    const LightSample<Scalar> s = sample_any_light<Scalar>(scene->view(), {x, y, 0.2f}, {0.5f, 0.5f, 0.5f, 0.5f});
    const double expected = (y < 0 ? 1 : 3) * (x < 0 ? 1 : 5) / 2.04;
    CHECK(double{s.radiance.c0} == near(expected, 1e-4));
  }
}

TEST_CASE("light sampling: samples of circular and elliptic disks follow their pdf") {
  for (const Vec3f scale : {Vec3f{1, 1, 1}, Vec3f{1, 0.4f, 1}}) {
    const auto scene = lone_light(DiskShape{}, kTilt * Transform::scale(scale));
    check_directions(scene->view(), {0, 0, 0}, window({0.1f, 0, 1}, 0.5), Use::kWhole);
    check_samples(scene->view(), {0, 0, 0});
  }
}

TEST_CASE("light sampling: samples of cylinders seen from outside follow their pdf") {
  for (const Vec3f scale : {Vec3f{1, 1, 1}, Vec3f{1, 0.4f, 1}}) {
    const auto scene =
        lone_light(CylinderShape{{0, -0.5f, 0}, {0, 0.7f, 0}, 0.5f},
                   Transform::translate({0, 0, 3}) * Transform::rotate({0, 0, 1}, 20) * Transform::scale(scale));
    check_directions(scene->view(), {0, 0.5f, 0}, window({0, 0, 1}, 0.6), Use::kPart);
    check_samples(scene->view(), {0, 0.5f, 0});
  }
}

TEST_CASE("light sampling: samples of a flipped cylinder seen from inside follow their pdf") {
  const auto scene = lone_light(CylinderShape{{0, 0, -1}, {0, 0, 1.5f}, 1}, Transform::rotate({1, 0, 0}, 30), true);
  check_directions(scene->view(), {0.3f, 0.1f, 0.2f}, whole_sphere(), Use::kWhole);
  check_samples(scene->view(), {0.3f, 0.1f, 0.2f});
}

TEST_CASE("light sampling: samples of spheres at all distances follow their pdf") {
  const auto scene = lone_light(SphereShape{{0, 0, 3}, 1}, Transform());
  CHECK(scene->view().lights.rows[0].is(kLightKind<SphereLightKind>));
  check_directions(scene->view(), {0, 0, -1e3f}, window({0, 0, 1}, 1.2e-3), Use::kWhole);
  check_directions(scene->view(), {0, 0, 0}, window({0, 0.05f, 1}, 0.5), Use::kWhole);
  check_directions(scene->view(), {0.1f, 0, 1.99f}, whole_sphere(), Use::kWhole);
  for (const Vec3f from : {Vec3f{0, 0, -1e3f}, Vec3f{0, 0, 0}, Vec3f{0.1f, 0, 1.99f}, Vec3f{0, 0, 1.999f}})
    check_samples(scene->view(), from);
}

TEST_CASE("light sampling: a sphere that emits outwards sends nothing to its inside") {
  const auto scene = lone_light(SphereShape{{0, 0, 3}, 1}, Transform());
  for (std::uint32_t i = 0; i < 100; ++i)
    CHECK_FALSE(sample_any_light<Scalar>(scene->view(), {0.1f, 0, 3}, lane_random(44, i, 0)).valid);
}

TEST_CASE("light sampling: samples of a flipped sphere seen from its center and near its surface follow their pdf") {
  const auto scene = lone_light(SphereShape{{1, 0, 0}, 2}, Transform(), true);
  for (const Vec3f from : {Vec3f{1, 0, 0}, Vec3f{-0.6f, 0.4f, 0.1f}}) {
    check_directions(scene->view(), from, whole_sphere(), Use::kWhole);
    check_samples(scene->view(), from);
  }
  // Seen from outside, only its far wall emits towards the viewer, through the near wall.
  check_directions(scene->view(), {1, 0, -5}, window({0, 0, 1}, 0.5), Use::kPart);
}

TEST_CASE("light sampling: samples of ellipsoids follow their pdf") {
  const auto scene = lone_light(SphereShape{}, Transform::translate({0, 0, 4}) * Transform::rotate({1, 1, 1}, 50) *
                                                   Transform::scale({0.4f, 1, 1.6f}));
  CHECK(scene->view().lights.rows[0].is(kLightKind<QuadricLightKind>));
  check_directions(scene->view(), {0, 0, 0}, window({0, 0, 1}, 0.6), Use::kPart);
  check_samples(scene->view(), {0, 0, 0});
}

TEST_CASE("light sampling: samples of a constant environment are uniform") {
  Description d = empty_scene(4, 4);
  add_sphere(d, {1, 2, 3}, 2);
  add_constant_light(d, 3);
  const auto scene = compile_scene(d);
  const SceneView view = scene->view();
  const auto sample = [&](Random4<Scalar> u) { return sampled_direction(view, {1, 0, 0}, u); };
  const ChiSquare result = chi_square_sphere(sample, [](Vec3f) { return 0.25 * kInvPi; });
  CHECK(result.p_value > significance_of_each(kTests));
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const auto s = sample_any_light<Scalar>(view, {1, 0, 0}, lane_random(45, i, 0));
    CHECK(s.pdf_solid_angle == near(0.25 * kInvPi));
    CHECK_FALSE(s.delta);
    CHECK(length(s.target - view.center) > view.radius);
  }
}

TEST_CASE("light sampling: samples of a sun of any size are uniform over its disk") {
  for (const float radius : {0.2679f, 30.0f}) {
    Description d = empty_scene(4, 4);
    add_sphere(d, {1, 2, 3}, 2);
    SunDescription sun;
    sun.up = sun.direction = {0, 0, 1};
    sun.radius = radius;
    d.lights.push_back({sun, {}});
    const auto scene = compile_scene(d);
    const SceneView view = scene->view();
    const double rim = std::cos(double(radius) * 3.14159265358979 / 180), pdf = 0.5 * kInvPi / (1 - rim);
    const auto sample = [&](Random4<Scalar> u) { return sampled_direction(view, {1, 0, 0}, u); };
    const auto density = [&](Vec3f) { return pdf; };
    // For small radii, rounding of the cosines is too coarse for cells.
    if (radius > 1) CHECK(chi_square_sphere(sample, density, rim).p_value > significance_of_each(kTests));
    MeanVariance spread;
    for (std::uint32_t i = 0; i < 5000; ++i)
      spread.add(0.5 * double(length_squared(*sample(lane_random(48, i, 0)) - sun.direction)) / (1 - rim));
    CHECK(spread.p_value(0.5) > significance_of_each(kTests));
    const auto seen = [&](double fraction) {
      const auto angle = static_cast<float>(fraction * double(radius) * 3.14159265358979 / 180);
      return environment_value<Scalar, ColorMode::kRgb>(view, 0, {std::sin(angle), 0, std::cos(angle)}, 0.0f, {});
    };
    for (std::uint32_t i = 0; i < 1000; ++i) {
      const auto s = sample_any_light<Scalar>(view, {1, 0, 0}, lane_random(47, i, 0));
      CHECK(s.pdf_solid_angle == near(pdf, 1e-4));
      CHECK_FALSE(s.delta);
      CHECK(s.radiance.c1 == seen(0.5).radiance.c1);
    }
    CHECK(seen(0.99).pdf_solid_angle == near(pdf, 1e-4));
    CHECK(seen(0.99).radiance.c1 > 0);
    CHECK(seen(1.01).pdf_solid_angle == 0);
    CHECK(seen(1.01).radiance.c1 == 0);
  }
}

TEST_CASE("light sampling: a point light has intensity over squared distance") {
  Description d = empty_scene(4, 4);
  add_point_light(d, {1, 2, 3}, 8);
  const auto scene = compile_scene(d);
  const auto s = sample_any_light<Scalar>(scene->view(), {1, 2, 5}, lane_random(46, 0, 0));
  CHECK(s.valid);
  CHECK(s.delta);
  CHECK(s.pdf_solid_angle == 1.0f);
  CHECK(s.radiance.c0 == near(2));
  CHECK(record_difference<Vec3>(s.direction, {0, 0, -1}) < 1e-6);
  CHECK(s.target == Vec3f{1, 2, 3});
  CHECK_FALSE(sample_any_light<Scalar>(scene->view(), {1, 2, 3}, lane_random(46, 0, 0)).valid);
}

TEST_CASE("light sampling: one-sided lights emit nothing backwards") {
  const auto scene = lone_light(RectangleShape{}, Transform::translate({0, 0, 3}));
  for (std::uint32_t i = 0; i < 100; ++i) {
    CHECK_FALSE(sample_any_light<Scalar>(scene->view(), {0, 0, 0}, lane_random(47, i, 0)).valid);
    CHECK(sample_any_light<Scalar>(scene->view(), {0, 0, 5}, lane_random(47, i, 0)).valid);
    CHECK_FALSE(sample_any_light<Scalar>(scene->view(), {5, 0, 3}, lane_random(47, i, 0)).valid);  // edge on
  }
}

namespace {

/// One light of every kind, each with its own radiance.
Description many_lights() {
  Description d = empty_scene(4, 4);
  emit(add_rectangle(d, kTilt), 1);
  emit(add_sphere(d, {3, 0, 0}, 0.5f), 2);
  emit(add_shape(d, DiskShape{}, Transform::translate({0, -4, 0}) * Transform::rotate({1, 0, 0}, -90)), 3);
  emit(add_shape(d, CylinderShape{}, Transform::translate({-4, 0, 0}) * Transform::scale({1, 0.5f, 1})), 4);
  emit(add_shape(d, SphereShape{}, Transform::translate({0, 4, 0}) * Transform::scale({1, 0.5f, 1})), 5);
  emit(add_shape(d, uneven_mesh(), Transform::translate({0, 0, -4})), 6);
  add_point_light(d, {1, 1, 1}, 7);
  add_constant_light(d, 8);
  return d;
}

}  // namespace

TEST_CASE("light sampling: lights are selected in proportion to their power") {
  Description d = many_lights();
  d.integrator.light_selector = LightSelector::kPower;
  const auto scene = compile_scene(d);
  const SceneView view = scene->view();
  REQUIRE(view.lights.count == 8);
  double sum = 0;
  for (std::uint32_t i = 0; i < view.lights.count; ++i) sum += view.lights.alias[i].pdf;
  CHECK(sum == near(1, 1e-6));
  const auto pdf = [&](std::size_t i) { return double(view.lights.alias[i].pdf); };
  const double pi = kPi, rectangle = pi * 4 * 1;
  CHECK(pdf(1) / pdf(0) == near(pi * (4 * pi * 0.25) * 2 / rectangle, 1e-5));
  CHECK(pdf(2) / pdf(0) == near(pi * pi * 3 / rectangle, 1e-5));
  CHECK(pdf(6) / pdf(0) == near(4 * pi * 7 / rectangle, 1e-5));
  CHECK(pdf(7) / pdf(0) == near(pi * pi * double(view.radius) * view.radius * 8 / rectangle, 1e-5));

  constexpr int kDraws = 200000;
  std::vector<double> observed(8), expected(8);
  for (std::size_t i = 0; i < 8; ++i) expected[i] = kDraws * pdf(i);
  for (std::uint32_t i = 0; i < kDraws; ++i) {
    const auto s = sample_any_light<Scalar>(view, {0, 0, 0}, lane_random(48, i, 0));
    // The point light's radiance is its intensity over a squared distance of 3.
    const float value = s.delta ? s.radiance.c0 * 3 : s.radiance.c0;
    observed[static_cast<std::size_t>(std::lround(value)) - 1] += 1;
  }
  CHECK(chi_square(observed, expected).p_value > kSignificance);
}

TEST_CASE("light sampling: SIMD samples of mixed lights equal scalar ones") {
  const auto scene = compile_scene(many_lights());
  const SceneView view = scene->view();
  double worst = 0;
  int delta = 0, valid = 0;
  for (std::uint32_t i = 0; i < 20000; i += kWidth) {
    const auto from =
        wide_record<Vec3>([&](int lane) { return random_direction(49, i + static_cast<std::uint32_t>(lane)); });
    const auto wide = sample_any_light<Wide>(view, from, wide_random(50, i));
    for (int lane = 0; lane < kWidth; ++lane) {
      const auto one = sample_any_light<Scalar>(view, lane_record(from, lane), lane_random(50, i, lane));
      CHECK(lane_of(wide.delta, lane) == one.delta);
      // Surfaces seen edge-on may count as hit or missed.
      if (one.pdf_solid_angle > 1e3f) continue;
      CHECK(lane_of(wide.valid, lane) == one.valid);
      delta += one.delta;
      valid += one.valid;
      worst = std::max({worst, record_difference<Vec3>(lane_record(wide.direction, lane), one.direction),
                        record_difference<Vec3>(lane_record(wide.target, lane), one.target),
                        record_difference<Spectrum>(lane_record(wide.radiance, lane), one.radiance)});
      if (one.valid)
        worst =
            std::max(worst, difference(wide.pdf_solid_angle[lane], one.pdf_solid_angle) / (1 + one.pdf_solid_angle));
    }
  }
  CHECK(delta > 100);
  CHECK(valid > 10000);
  CHECK(worst < 2e-5);
}

TEST_CASE("light sampling: SIMD pdfs of mixed lights equal scalar ones") {
  const auto scene = compile_scene(many_lights());
  const SceneView view = scene->view();
  const auto light_of = [&](std::uint32_t i, int lane) { return (i / kWidth + static_cast<std::uint32_t>(lane)) % 6; };
  double worst = 0;
  for (std::uint32_t i = 0; i < 20000; i += kWidth) {
    const auto at = [i](int lane) { return i + static_cast<std::uint32_t>(lane); };
    const auto from = wide_record<Vec3>([&](int lane) { return random_direction(51, at(lane)); });
    const auto direction = wide_record<Vec3>([&](int lane) { return random_direction(52, at(lane)); });
    const auto normal = wide_record<Vec3>([&](int lane) { return random_direction(53, at(lane)); });
    const WideFloat t = wide_random(54, i).x * WideFloat(5.0f);
    const auto lights = load_lights<Wide>(view, wide_uints([&](int lane) { return light_of(i, lane); }));
    const auto wide = light_pdf_solid_angle<Wide>(view, WideUint(0u), lights, WideMask(true),
                                                  {from, direction, t, normal}, WideFloat(0.0f));
    for (int lane = 0; lane < kWidth; ++lane) {
      const auto light = load_lights<Scalar>(view, light_of(i, lane));
      const float one = light_pdf_solid_angle<Scalar>(
          view, 0u, light, true,
          {lane_record(from, lane), lane_record(direction, lane), t[lane], lane_record(normal, lane)}, 0.0f);
      if (one < 100) worst = std::max(worst, difference(wide[lane], one));
    }
  }
  CHECK(worst < 1e-4);
}

TEST_SUITE_END();

}  // namespace sheaf::test_light_sample
