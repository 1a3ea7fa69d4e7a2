// Renders of scenes whose radiance has a closed form. All pixels of an image have the same expectation, so that
// Student's t-test over the pixels judges the mean.
#include "kernels/passes/render.h"
#include "scene/compile/compile.h"
#include "tests/support/capture.h"
#include "tests/support/statistics.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <array>
#include <complex>
#include <functional>

namespace sheaf::test_estimators {

namespace {

constexpr double kPiD = 3.14159265358979323846;
/// All comparisons of this file together fail with probability kSignificance if every estimator is unbiased.
const double kLevel = significance_of_each(600);
/// Relative error of single precision, which no number of samples averages out.
constexpr double kRounding = 2e-5;

constexpr LightStrategy kStrategies[] = {LightStrategy::kMis, LightStrategy::kBsdfOnly, LightStrategy::kLightOnly};
constexpr const char* kStrategyNames[] = {"mis", "bsdf only", "light only"};

/// An empty scene with an image of 32 x 32 pixels and 128 samples each.
Description picture() {
  Description d = empty_scene(32, 32);
  d.sampler.sample_count = 128;
  d.sampler.seed = 7;
  return d;
}

/// The camera looks at one point: over the image the position changes by a ten-thousandth of the distance.
void aim(Description& d, Vec3f from, Vec3f at, Vec3f up = {0, 0, 1}) { look_at(d, from, at, up, 0.01f); }

Image render_image(const Description& d) { return render(*compile_scene(d), {}).film.to_image(); }

MeanVariance statistics_of(const Image& image, int channel) {
  MeanVariance statistics;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) statistics.add(image.at(x, y, channel));
  return statistics;
}

/// Tests the mean against `expected`, within rounding.
void check_mean(const MeanVariance& statistics, double expected) {
  const double allowed = kRounding * std::fabs(expected), distance = statistics.mean() - expected;
  INFO("mean " << statistics.mean() << ", expected " << expected << ", standard error "
               << std::sqrt(statistics.variance() / 1024));
  const double nearest =
      std::fabs(distance) <= allowed ? statistics.mean() : expected + std::copysign(allowed, distance);
  CHECK(statistics.p_value(nearest) >= kLevel);
}

void check_grey(const Description& d, double expected) {
  const Image image = render_image(d);
  check_mean(statistics_of(image, 0), expected);
  bool grey = true;
  for (std::size_t i = 0; i < image.data.size(); i += image.channels.size())
    grey = grey && image.data[i] == image.data[i + 1] && image.data[i] == image.data[i + 2];
  CHECK(grey);
}

/// Renders with each strategy; `sees_points` is false where BSDF sampling alone cannot find the light.
void check_strategies(Description d, double expected, bool sees_points = true) {
  for (int i = 0; i < 3; ++i) {
    d.integrator.strategy = kStrategies[i];
    CAPTURE(kStrategyNames[i]);
    check_grey(d, !sees_points && kStrategies[i] == LightStrategy::kBsdfOnly ? 0.0 : expected);
  }
}

constexpr float kAlbedo = 0.6f;

/// A diffuse floor at z = 0, which the camera sees at the origin from a low angle.
Description receiver() {
  Description d = picture();
  add_rectangle(d, Transform::scale({20, 20, 1}), add_diffuse(d, kAlbedo));
  d.integrator.max_depth = 2;
  aim(d, {8, 0, 2}, {0, 0, 0});
  return d;
}

double reflected(double irradiance) { return kAlbedo / kPiD * irradiance; }

Transform facing_down(Vec3f at) { return Transform::translate(at) * Transform::rotate({1, 0, 0}, 180); }

ShapeDescription& add_disk_light(Description& d, Vec3f at, float radius, float radiance) {
  const MaterialId black = add_diffuse(d, 0);
  return emit(add_shape(d, DiskShape{}, facing_down(at) * Transform::scale({radius, radius, 1}), black), radiance);
}

/// Irradiance of a polygon at the origin of a floor with normal +z (Lambert's formula). All corners are above the
/// floor.
double polygon_irradiance(const std::vector<std::array<double, 3>>& corners, double radiance) {
  double sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto &a = corners[i], &b = corners[(i + 1) % corners.size()];
    const double cross[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    const double length = std::hypot(cross[0], cross[1], cross[2]);
    sum += std::atan2(length, a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * cross[2] / length;
  }
  return radiance / 2 * std::fabs(sum);
}

double geometric_sum(double ratio, int terms) { return (1 - std::pow(ratio, terms)) / (1 - ratio); }

/// Reflectance of an interface; `eta` may be complex (far side over near side).
double fresnel(double cos_incident, std::complex<double> eta) {
  const std::complex<double> cos_far = std::sqrt(1.0 - (1 - cos_incident * cos_incident) / (eta * eta));
  const auto s = (cos_incident - eta * cos_far) / (cos_incident + eta * cos_far);
  const auto p = (eta * cos_incident - cos_far) / (eta * cos_incident + cos_far);
  return 0.5 * (std::norm(s) + std::norm(p));
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("a disk light above a parallel floor matches the closed form") {
  for (const auto& [radius, height] : {std::pair{1.0, 1.0}, {0.3, 2.0}, {4.0, 1.0}}) {
    CAPTURE_BINDING(radius);
    Description d = receiver();
    add_disk_light(d, {0, 0, static_cast<float>(height)}, static_cast<float>(radius), 3);
    if (radius > 2) aim(d, {8, 0, 0.5f}, {0, 0, 0});
    check_strategies(d, reflected(kPiD * 3 * radius * radius / (radius * radius + height * height)));
  }
}

TEST_CASE("an occluder removes its share of a disk light") {
  Description d = receiver();
  add_disk_light(d, {0, 0, 2}, 1.5f, 3);
  const MaterialId black = add_diffuse(d, 0);
  add_shape(d, DiskShape{}, facing_down({0, 0, 1}) * Transform::scale({0.5f, 0.5f, 1}), black);
  check_strategies(d, reflected(kPiD * 3 * (2.25 / 6.25 - 0.25 / 1.25)));
}

TEST_CASE("a sphere light matches the closed form") {
  Description d = receiver();
  SUBCASE("overhead") {
    add_area_light_sphere(d, {0, 0, 1}, 0.5f, 2);
    check_strategies(d, reflected(kPiD * 2 * 0.25));
  }
  SUBCASE("beside the point by a transform") {
    const MaterialId black = add_diffuse(d, 0);
    const Transform t =
        Transform::translate({-2, 1, 2}) * Transform::rotate({1, 2, 3}, 40) * Transform::scale({0.5f, 0.5f, 0.5f});
    emit(add_shape(d, SphereShape{}, t, black), 5);
    check_strategies(d, reflected(kPiD * 5 * (0.25 / 9) * (2.0 / 3)));
  }
  SUBCASE("an ellipsoid overhead") {
    const MaterialId black = add_diffuse(d, 0);
    emit(add_shape(d, SphereShape{}, Transform::translate({0, 0, 2}) * Transform::scale({1, 1, 0.5f}), black), 2);
    check_strategies(d, reflected(kPiD * 2 / (1 + 4 - 0.25)));
  }
}

TEST_CASE("a cylinder light matches quadrature over its surface") {
  constexpr double kRadius = 0.4, kHeight = 1.2, kHalfLength = 0.8;
  Description d = receiver();
  const MaterialId black = add_diffuse(d, 0);
  emit(add_shape(d, CylinderShape{{-0.8f, 0, 1.2f}, {0.8f, 0, 1.2f}, 0.4f}, Transform(), black), 2);
  double irradiance = 0;
  constexpr int kSteps = 1000;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const double phi = 2 * kPiD * (i + 0.5) / kSteps, x = kHalfLength * (2 * (j + 0.5) / kSteps - 1);
      const double y = kRadius * std::cos(phi), z = kHeight + kRadius * std::sin(phi);
      const double squared = x * x + y * y + z * z;
      const double facing = -(y * std::cos(phi) + z * std::sin(phi));
      if (facing > 0) irradiance += 2 * facing * z / (squared * squared);
    }
  irradiance *= 2 * kPiD * kRadius * 2 * kHalfLength / (double(kSteps) * kSteps);
  check_strategies(d, reflected(irradiance));
}

TEST_CASE("rectangle lights and mesh lights of unequal triangles match the closed form") {
  Description d = receiver();
  SUBCASE("rectangle") {
    add_area_light_rectangle(d, facing_down({0.5f, 0, 1}) * Transform::scale({1, 0.5f, 1}), 4);
    check_strategies(
        d, reflected(polygon_irradiance({{-0.5, -0.5, 1}, {1.5, -0.5, 1}, {1.5, 0.5, 1}, {-0.5, 0.5, 1}}, 4)));
  }
  SUBCASE("mesh") {
    Mesh mesh;
    mesh.positions = {{-1, -1, 1}, {-1, 1, 2}, {0.5f, 0.25f, 1}, {-1.5f, -1.5f, 0.5f}};
    mesh.triangles = {{{0, 1, 2}}, {{0, 3, 1}}};
    const MaterialId black = add_diffuse(d, 0);
    emit(add_shape(d, mesh, Transform(), black), 4);
    const double a = polygon_irradiance({{-1, -1, 1}, {-1, 1, 2}, {0.5, 0.25, 1}}, 4);
    const double b = polygon_irradiance({{-1, -1, 1}, {-1.5, -1.5, 0.5}, {-1, 1, 2}}, 4);
    check_strategies(d, reflected(a + b));
  }
}

TEST_CASE("a point light matches the closed form") {
  Description d = receiver();
  add_point_light(d, {-1, 2, 2}, 10);
  check_strategies(d, reflected(10 * (2.0 / 3) / 9), false);
}

TEST_CASE("lights of all kinds add up whatever their power") {
  Description d = receiver();
  add_area_light_sphere(d, {0, 0, 2}, 0.5f, 2);
  add_area_light_rectangle(d, facing_down({-4, 0, 2}) * Transform::scale({1, 1, 1}), 30);
  add_constant_light(d, 0.5f);
  const double sphere = 0.25 / 4;  // share of the cosine-weighted hemisphere of the floor
  const double rectangle = polygon_irradiance({{-5, -1, 2}, {-3, -1, 2}, {-3, 1, 2}, {-5, 1, 2}}, 1) / kPiD;
  const double area_lights = kPiD * (2 * sphere + 30 * rectangle + 0.5 * (1 - sphere - rectangle));
  SUBCASE("without a point light") { check_strategies(d, reflected(area_lights)); }
  SUBCASE("with a point light") {
    add_point_light(d, {0, -2, 2}, 0.3f);
    d.integrator.strategy = LightStrategy::kMis;
    check_grey(d, reflected(area_lights + 0.3 * std::sqrt(0.5) / 8));
  }
}

TEST_CASE("a convex object in a constant environment has the closed-form radiance") {
  Description d = picture();
  const MaterialId material = add_diffuse_rgb(d, 0.2f, 0.5f, 0.9f);
  d.lights.push_back({ConstantLightDescription{SpectrumDescription::rgb(3, 2, 1)}, {}});
  aim(d, {5, 4, 3}, {0.1f, 0.2f, 0.1f});
  const auto check_rgb = [&d] {
    for (int i = 0; i < 3; ++i) {
      d.integrator.strategy = kStrategies[i];
      CAPTURE(kStrategyNames[i]);
      const Image image = render_image(d);
      check_mean(statistics_of(image, 0), 0.2 * 3);
      check_mean(statistics_of(image, 1), 0.5 * 2);
      check_mean(statistics_of(image, 2), 0.9 * 1);
    }
  };
  SUBCASE("sphere") { add_sphere(d, {0, 0, 0}, 1, material); }
  SUBCASE("cube") { add_shape(d, CubeShape{}, Transform::rotate({1, 1, 0}, 30), material); }
  check_rgb();
}

TEST_CASE("lossless objects are invisible in a constant environment") {
  Description d = picture();
  look_at(d, {0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 45);
  add_constant_light(d, 2);
  SUBCASE("diffuse") { add_sphere(d, {0, 0, 0}, 1, add_diffuse(d, 1)); }
  SUBCASE("mirror") { add_sphere(d, {0, 0, 0}, 1, add_mirror(d)); }
  SUBCASE("glass") { add_sphere(d, {0, 0, 0}, 1, add_glass(d)); }
  SUBCASE("glass cube") { add_shape(d, CubeShape{}, Transform::rotate({1, 2, 3}, 30), add_glass(d, 1.3f)); }
  SUBCASE("a bubble in water") { add_sphere(d, {0, 0, 0}, 1, add_glass(d, 1, 1.33f)); }
  check_strategies(d, 2);
}

TEST_CASE("the radiance inside a closed emissive and reflective shape is a geometric series") {
  Description d = picture();
  look_at(d, {0.2f, -0.3f, 0.1f}, {1, 0.4f, 0.3f});
  const auto enclose = [&d](float albedo) {
    ShapeDescription& shape = d.shapes.back();
    shape.material = add_diffuse(d, albedo);
    shape.flip_normals = true;
    emit(shape, 1.5f);
  };
  SUBCASE("sphere with limited depth") {
    add_sphere(d, {0, 0, 0}, 1);
    enclose(0.7f);
    for (int depth : {1, 2, 3, 6}) {
      CAPTURE(depth);
      d.integrator.max_depth = depth;
      check_strategies(d, 1.5 * geometric_sum(0.7, depth));
    }
  }
  SUBCASE("sphere with different start of Russian roulette") {
    add_sphere(d, {0, 0, 0}, 1);
    enclose(0.7f);
    for (int depth : {1, 2, 5, 40}) {
      CAPTURE(depth);
      d.integrator.rr_depth = depth;
      check_strategies(d, 1.5 / 0.3);
    }
  }
  SUBCASE("ellipsoid") {
    add_shape(d, SphereShape{}, Transform::scale({1, 2, 3}));
    enclose(0.5f);
    check_strategies(d, 1.5 / 0.5);
  }
  SUBCASE("box") {
    add_shape(d, CubeShape{}, Transform::scale({1, 2, 1.5f}));
    enclose(0.6f);
    check_strategies(d, 1.5 / 0.4);
  }
}

TEST_CASE("a point light in an integrating sphere matches the closed form") {
  Description d = picture();
  look_at(d, {0.2f, -0.3f, 0.1f}, {1, 0.4f, 0.3f});
  add_sphere(d, {0, 0, 0}, 2, add_diffuse(d, 0.75f)).flip_normals = true;
  add_point_light(d, {0, 0, 0}, 8);
  const double first = 0.75 / kPiD * 8 / 4;
  for (int depth : {1, 2, 3, -1}) {
    CAPTURE(depth);
    d.integrator.max_depth = depth;
    check_strategies(d, depth < 0 ? first / 0.25 : first * geometric_sum(0.75, depth - 1), false);
  }
}

TEST_CASE("a glass slab in front of a light has the closed-form transmittance") {
  for (const double cosine : {1.0, 0.6}) {
    CAPTURE(cosine);
    Description d = picture();
    add_shape(d, CubeShape{}, Transform::scale({20, 20, 0.1f}), add_glass(d));
    add_area_light_rectangle(d, Transform::translate({0, 0, -3}) * Transform::scale({100, 100, 1}), 2);
    aim(d, {static_cast<float>(5 * std::sqrt(1 - cosine * cosine)), 0, static_cast<float>(5 * cosine)}, {0, 0, 0},
        {0, 1, 0});
    const double r = fresnel(cosine, 1.5), t = (1 - r) * (1 - r);
    for (const auto& [depth, expected] :
         {std::pair{2, 0.0}, {3, 2 * t}, {5, 2 * t * (1 + r * r)}, {-1, 2 * (1 - r) / (1 + r)}}) {
      CAPTURE_BINDING(depth);
      d.integrator.max_depth = depth;
      check_strategies(d, expected);
    }
  }
}

TEST_CASE("an interface scales radiance by the squared index and matched indices change nothing") {
  Description d = picture();
  add_area_light_rectangle(d, Transform::translate({0, 0, -3}) * Transform::scale({100, 100, 1}), 2);
  aim(d, {3, 0, 4}, {0, 0, 0}, {0, 1, 0});
  const Transform large = Transform::scale({50, 50, 1});
  SUBCASE("from air into glass") {
    add_rectangle(d, large, add_glass(d));
    check_strategies(d, 2 * (1 - fresnel(0.8, 1.5)) / (1.5 * 1.5));
  }
  SUBCASE("from glass into air") {
    add_rectangle(d, large, add_glass(d, 1, 1.2f));
    check_strategies(d, 2 * (1 - fresnel(0.8, 1 / 1.2)) * (1.2 * 1.2));
  }
  SUBCASE("matched") {
    add_sphere(d, {0, 0, 0}, 1, add_glass(d, 1.4f, 1.4f));
    check_strategies(d, 2);
  }
}

TEST_CASE("mirrors and metals reflect by their reflectance") {
  Description d = picture();
  add_area_light_rectangle(
      d, Transform::translate({-4, 0, 4}) * Transform::rotate({0, 1, 0}, 135) * Transform::scale({3, 3, 1}), 2);
  aim(d, {3, 0, 3}, {0, 0, 0});
  SUBCASE("mirror") {
    add_rectangle(d, Transform::scale({5, 5, 1}), add_mirror(d, 0.8f));
    check_strategies(d, 1.6);
  }
  SUBCASE("metal") {
    using S = SpectrumDescription;
    const ConductorDescription metal{ConductorDescription::Ior{S::constant(0.2f), S::constant(3.9f)}, S::constant(0.9f),
                                     std::nullopt};
    add_rectangle(d, Transform::scale({5, 5, 1}), add_material(d, metal));
    check_strategies(d, 2 * 0.9 * fresnel(std::sqrt(0.5), {0.2, 3.9}));
  }
  SUBCASE("mirror from behind") {
    add_rectangle(d, Transform::rotate({1, 0, 0}, 180) * Transform::scale({5, 5, 1}), add_mirror(d));
    check_strategies(d, 0);
  }
}

TEST_CASE("each side of a surface has its own material") {
  const auto check_sides = [](double front, double back, const std::function<void(Description&)>& add) {
    for (const float side : {1.0f, -1.0f}) {
      CAPTURE(side);
      Description d = picture();
      add_constant_light(d, 3);
      aim(d, {1, 0, 2 * side}, {0, 0, 0}, {0, 1, 0});
      add(d);
      check_strategies(d, side > 0 ? front : back);
    }
  };
  SUBCASE("one-sided") {
    check_sides(0.75, 0, [](Description& d) { add_rectangle(d, Transform(), add_diffuse(d, 0.25f)); });
  }
  SUBCASE("the same twice") {
    check_sides(0.75, 0.75,
                [](Description& d) { add_rectangle(d, Transform(), add_two_sided(d, add_diffuse(d, 0.25f))); });
  }
  SUBCASE("different ones") {
    check_sides(0.75, 2.25, [](Description& d) {
      const MaterialId a = add_diffuse(d, 0.25f), b = add_diffuse(d, 0.75f);
      add_rectangle(d, Transform(), add_material(d, TwoSidedDescription{a, b}));
    });
  }
  SUBCASE("one-sided emitter") {
    check_sides(5, 0, [](Description& d) { add_area_light_rectangle(d, Transform(), 5); });
  }
}

TEST_CASE("hidden lights are invisible to the camera but illuminate and are reflected") {
  Description d = picture();
  d.integrator.hide_emitters = true;
  d.integrator.max_depth = 2;
  double value = 0, alpha = 0;
  SUBCASE("an area light before a black background") {
    add_area_light_rectangle(d, facing_down({0, 0, 2}), 3);
    aim(d, {0, 0.1f, 0}, {0, 0, 2}, {0, 1, 0});
  }
  SUBCASE("an environment") { add_constant_light(d, 3); }
  SUBCASE("area lights before a lit wall") {
    add_area_light_rectangle(d, Transform::translate({0, 0, 1}), 3);
    add_area_light_rectangle(d, facing_down({0, 0, 1.5f}), 0.25f);
    add_rectangle(d, Transform::scale({20, 20, 1}), add_diffuse(d, kAlbedo));
    add_point_light(d, {5, 0, 0.5f}, 100);
    aim(d, {0, 0, 3}, {0, 0, 0}, {0, 1, 0});
    value = reflected(100 * 0.5 / std::pow(25.25, 1.5));
    alpha = 1;
    d.integrator.strategy = LightStrategy::kLightOnly;
  }
  SUBCASE("a hidden light still shows in a mirror") {
    add_rectangle(d, Transform::scale({5, 5, 1}), add_mirror(d, 0.5f));
    add_area_light_rectangle(d, facing_down({-2, 0, 2}), 3);
    aim(d, {2, 0, 2}, {0, 0, 0});
    value = 1.5;
    alpha = 1;
  }
  SUBCASE("a hidden light still lights") {
    add_rectangle(d, Transform::scale({5, 5, 1}), add_diffuse(d, kAlbedo));
    add_disk_light(d, {0, 0, 1}, 1, 3);
    aim(d, {0.1f, 0, 5}, {0, 0, 0});
    value = reflected(kPiD * 3 * 0.5);
    alpha = 1;
  }
  const Image image = render_image(d);
  check_mean(statistics_of(image, 0), value);
  check_mean(statistics_of(image, 3), alpha);
}

namespace {

using FilterKind = PixelFilter::Kind;

std::vector<PixelFilter> all_filters() {
  std::vector<PixelFilter> filters;
  for (FilterKind kind : {FilterKind::kBox, FilterKind::kTent, FilterKind::kGaussian, FilterKind::kMitchell,
                          FilterKind::kCatmullRom, FilterKind::kLanczos}) {
    PixelFilter filter;
    filter.kind = kind;
    if (kind == FilterKind::kTent) filter.radius = 1;
    filters.push_back(filter);
  }
  return filters;
}

/// Share of the integral of the filter to the left of `x`.
double filter_share(const PixelFilter& filter, double x) {
  const double radius = filter_radius(filter);
  constexpr int kSteps = 100000;
  double left = 0, all = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double at = radius * ((2 * i + 1.0) / kSteps - 1), f = evaluate_filter(filter, at);
    all += f;
    if (at < x) left += f;
  }
  return left / all;
}

}  // namespace

TEST_CASE("a constant image stays constant under every filter") {
  for (const PixelFilter& filter : all_filters()) {
    CAPTURE(static_cast<int>(filter.kind));
    Description d = picture();
    d.film.filter = filter;
    add_constant_light(d, 3);
    const Image image = render_image(d);
    check_mean(statistics_of(image, 0), 3);
    check_mean(statistics_of(image, 3), 1);
    if (filter.kind < FilterKind::kMitchell) CHECK(statistics_of(image, 0).variance() < 1e-12);
  }
}

TEST_CASE("a straight edge shows the integral of every filter") {
  constexpr double kEdge = 32.3;  // pixels from the left, beside a seam of tiles
  for (const PixelFilter& filter : all_filters()) {
    CAPTURE(static_cast<int>(filter.kind));
    Description d = empty_scene(64, 32);
    d.sampler.sample_count = 128;
    d.film.filter = filter;
    const auto edge = static_cast<float>(1 - kEdge / 32);
    add_area_light_rectangle(
        d, Transform::translate({edge + 50, 0, 1}) * Transform::rotate({0, 1, 0}, 180) * Transform::scale({50, 50, 1}),
        1);
    const Image image = render_image(d);
    for (int x = 0; x < image.width; ++x) {
      CAPTURE(x);
      MeanVariance column;
      for (int y = 0; y < image.height; ++y) column.add(image.at(x, y, 0));
      const double expected = filter_share(filter, kEdge - (x + 0.5));
      // The table of 2048 bins smooths the sign changes of filters with negative lobes.
      const double allowed = 2e-3, distance = column.mean() - expected;
      INFO("mean " << column.mean() << ", expected " << expected);
      if (std::fabs(distance) > allowed) CHECK(column.p_value(expected + std::copysign(allowed, distance)) >= kLevel);
    }
  }
}

TEST_SUITE_END();

}  // namespace sheaf::test_estimators
