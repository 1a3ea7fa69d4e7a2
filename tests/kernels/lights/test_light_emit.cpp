// Photon emission for every kind of light. The mean flux is the light's power; the irradiance of a disk matches light
// sampling; photons leave surfaces with a cosine distribution; and directions follow their pdf.
#include "kernels/lights/light_emit.h"

#include "scene/compile/compile.h"
#include "tests/kernels/lights/light_emit_cases.h"
#include "tests/support/chi_square.h"
#include "tests/support/light_testing.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_scenes.h"
#include "tests/support/trace_testing.h"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

namespace sheaf::test_light_emit {

namespace {

constexpr double kPiD = std::numbers::pi;

/// Wavelengths of all photons in spectral mode, nm.
const Spectrum4 kLambda{450, 520, 580, 640};

PhotonEmission<Scalar> photon(const SceneView& scene, std::uint32_t i) {
  const auto choice = choose_light_by_power<Scalar>(scene, random4<Scalar>(61, i, 0, 0).x);
  const auto a = random4<Scalar>(61, i, 0, 1), b = random4<Scalar>(61, i, 0, 2);
  return scene.color == ColorMode::kSpectral
             ? emit_photon<Scalar, ColorMode::kSpectral>(scene, choice, a, b, 0.0f, kLambda)
             : emit_photon<Scalar>(scene, choice, a, b, 0.0f);
}

LightSample<Scalar> any_sample(const SceneView& scene, Vec3f from, const Random4<Scalar>& u) {
  if (scene.color == ColorMode::kRgb) return sample_any_light<Scalar>(scene, from, u);
  const auto choice = choose_light<Scalar>(scene, {from, {}}, u.x);
  return sample_light<Scalar, ColorMode::kSpectral>(scene, {from, {}}, choice, u, 0.0f, kLambda);
}

double weighed(const Spectrum4& s) { return double(s.c0) + 2.0 * s.c1 + 3.0 * s.c2; }
double weighed(Vec3f v) { return double(v.x) + 2.0 * v.y + 3.0 * v.z; }

double power_of(const SceneView& scene) {
  double sum = 0;
  for (std::uint32_t i = 0; i < scene.lights.count; ++i) sum += weighed(scene.lights.powers[i]);
  return sum;
}

/// Student's t-test of the mean flux against the total power of all lights, which has the relative error `error`.
void check_power(const SceneView& scene, std::uint32_t photons, double error, double significance) {
  MeanVariance flux;
  for (std::uint32_t i = 0; i < photons; ++i) {
    const auto e = photon(scene, i);
    flux.add(e.valid ? weighed(e.flux) : 0.0);
  }
  const double power = power_of(scene);
  CAPTURE(flux.mean());
  CAPTURE(power);
  CHECK(flux.p_value(std::clamp(flux.mean(), power * (1 - error), power * (1 + error))) > significance);
  CHECK(flux.variance() < 100 * power * power);
}

/// Irradiance of a disk by one photon, W / m^2.
double deposit(const PhotonEmission<Scalar>& e, const Receiver& at) {
  const float cosine = -dot(e.direction, at.normal);
  if (!e.valid || !(cosine > 0.0f)) return 0;
  const float t = dot(e.origin - at.center, at.normal) / cosine;
  const bool hits = t > 0.0f && length_squared(e.origin + e.direction * t - at.center) < sqr(at.radius);
  return hits ? weighed(e.flux) / (kPiD * at.radius * at.radius) : 0;
}

/// Estimates the irradiance at a random point of a disk by light sampling.
double sampled_irradiance(const SceneView& scene, const Receiver& at, std::uint32_t i) {
  const auto v = random4<Scalar>(62, i, 0, 0);
  const Vec2f on_disk = square_to_disk<Scalar>(v.x, v.y);
  const Vec3f from = at.center + Frame<Scalar>::from_normal(at.normal).to_world({on_disk.x, on_disk.y, 0}) * at.radius;
  const auto s = any_sample(scene, from, random4<Scalar>(62, i, 0, 1));
  return s.valid ? weighed(s.radiance) * std::max(dot(s.direction, at.normal), 0.0f) / s.pdf_solid_angle : 0;
}

/// Student's t-test of the difference of the two estimates, in a scene without occlusion.
void check_irradiance(const SceneView& scene, const SceneView& reference, const Receiver& at, std::uint32_t photons,
                      double significance) {
  MeanVariance difference, sampled;
  for (std::uint32_t i = 0; i < photons; ++i) {
    const double expected = sampled_irradiance(reference, at, i);
    sampled.add(expected);
    difference.add(deposit(photon(scene, i), at) - expected);
  }
  CAPTURE(difference.mean());
  CAPTURE(sampled.mean());
  CHECK(difference.p_value(0) > significance);
  // The test detects an error of 8 %.
  CHECK(std::sqrt(difference.variance() / photons) < 0.08 / 4 * sampled.mean());
}

/// With MIS compensation, light sampling leaves part of an environment map to BSDF sampling. The reference disables it.
Description without_compensation(Description d) {
  for (LightDescription& light : d.lights)
    if (auto* map = std::get_if<EnvmapDescription>(&light.model)) map->mis_compensation = false;
  return d;
}

void check_cases(const std::vector<Case>& cases) {
  const double significance = significance_of_each(3 * static_cast<int>(cases.size()));
  for (const Case& c : cases) {
    CAPTURE(c.name);
    const auto scene = compile_scene(c.scene), reference = compile_scene(without_compensation(c.scene));
    check_power(scene->view(), c.photons, c.power_error, significance);
    for (const Receiver& at : c.receivers)
      check_irradiance(scene->view(), reference->view(), at, c.photons, significance);
  }
}

/// Checks that photons of an area light start just above the surface, on its emitting side, with a cosine distribution.
void check_surface(const Case& c, double significance) {
  const auto scene = compile_scene(c.scene);
  const SceneView view = scene->view();
  constexpr int kRings = 8, kSectors = 8, kDraws = 20000;
  std::vector<double> observed(kRings * kSectors), expected(kRings * kSectors);
  int valid = 0, lost = 0, blocked = 0, far = 0;
  double worst_cosine = 0;
  for (std::uint32_t i = 0; i < kDraws; ++i) {
    const auto e = photon(view, i);
    if (!e.valid) continue;
    ++valid;
    const double cosine = kPiD * double(e.pdf_direction);
    blocked += c.convex && trace_ray(view, e.origin, e.direction).has_value();
    const auto below = trace_ray(view, e.origin, -e.direction);
    if (!below) {
      ++lost;
      continue;
    }
    const Vec3f ng = surface_at(view, e.origin, -e.direction, *below).ng;
    if (cosine > 0.05) {
      far += double(below->t) * cosine > 1e-4;
      worst_cosine = std::max(worst_cosine, std::fabs(double(dot(ng, e.direction)) - cosine));
    }
    const Vec3f local = Frame<Scalar>::from_normal(ng).to_local(e.direction);
    const double azimuth = (std::atan2(double(local.y), double(local.x)) + kPiD) / (2 * kPiD);
    const int ring = std::min(static_cast<int>(cosine * cosine * kRings), kRings - 1);
    const int sector = std::min(static_cast<int>(azimuth * kSectors), kSectors - 1);
    observed[static_cast<std::size_t>(ring * kSectors + sector)] += 1;
  }
  for (double& e : expected) e = double(valid - lost) / (kRings * kSectors);
  CHECK(valid > 0.999 * kDraws);
  CHECK(lost < 0.003 * valid);  // past the rim
  CHECK(far < 0.003 * valid);
  CHECK(blocked == 0);
  CHECK(worst_cosine < 2e-3);
  CHECK(chi_square(observed, expected).p_value > significance);
}

/// Tests the directions of a single light against `pdf`, and the pdf that each photon returns.
void check_directions(const Description& d, const std::function<double(Vec3f)>& pdf, double z_min,
                      double significance) {
  const auto scene = compile_scene(d);
  const SceneView view = scene->view();
  double worst = 0;
  const auto sample = [&](Random4<Scalar> u) -> std::optional<Vec3f> {
    const auto e = emit_photon<Scalar>(view, {0, 1}, {0.5f, 0.3f, 0.7f, 0.5f}, u, 0.0f);
    if (!e.valid) return std::nullopt;
    const double expected = pdf(e.direction);
    worst = std::max(worst, std::fabs(double(e.pdf_direction) - expected) / expected);
    return e.direction;
  };
  CHECK(chi_square_sphere(sample, pdf, z_min).p_value > significance);
  CHECK(worst < 2e-3);
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("light emission: photons of area lights carry the power and agree with light sampling") {
  check_cases(area_cases());
}

TEST_CASE("light emission: photons of two-sided lights and of lights with given power carry the power") {
  check_cases(two_sided_cases());
  for (Case c : two_sided_cases()) {
    CAPTURE(c.name);
    const double before = power_of(compile_scene(c.scene)->view());
    c.scene.shapes[0].emits_on_both_sides = false;
    CHECK(power_of(compile_scene(c.scene)->view()) == near(before / 2));
  }
  for (Case c : area_cases()) {
    if (c.scene.shapes.empty()) continue;
    CAPTURE(c.name);
    ShapeDescription& shape = c.scene.shapes[0];
    shape.radiance = rgb({1, 2, 0.5f});
    for (const bool both : {false, true}) {
      shape.emits_on_both_sides = both;
      shape.power = 7.0f;
      CHECK(power_of(compile_scene(c.scene)->view()) == near(7 * (1 + 4 + 1.5), 1e-4));
    }
  }
}

TEST_CASE("light emission: photons of delta lights and environments and mixed lights agree with light sampling") {
  const TemporaryFolder folder;
  std::vector<Case> cases = placed_cases(folder);
  cases.push_back(mixed_case(folder));
  cases.back().power_error = 1;  // includes a stretched spot light
  check_cases(cases);
}

TEST_CASE("light emission: photons of emissive media carry 4 pi times the integrated emission") {
  const TemporaryFolder folder;
  std::vector<Case> cases = medium_cases(folder);
  cases.back().power_error = 5e-3;
  check_cases(cases);
  const Vec3f power = compile_scene(cases[0].scene)->view().lights.powers[0];
  const double expected = 4 * kPiD * 1.5 * (1.0 * 2.0 * 1.6);  // sigma_a 1.5, radiance 1
  CHECK(power.x == near(expected));
  CHECK(power.y == near(2 * expected));
  CHECK(power.z == near(expected / 2));
}

TEST_CASE("light emission: photons start in a medium with the pdf of light sampling") {
  const TemporaryFolder folder;
  const auto scene = compile_scene(medium_case("", uneven_fog(folder), {kBox}).scene);
  const SceneView view = scene->view();
  REQUIRE(view.lights.count == 1);
  const auto volume = view.lights.rows[0].data<VolumeLightData>();
  const Vec3f corner = volume.corner, size = volume.extent;
  constexpr int kSide = 4, kDraws = 50000, kFine = 32;
  std::vector<double> observed(kSide * kSide * kSide), expected(kSide * kSide * kSide);
  const auto block = [&](double x, double y, double z) {
    const auto along = [](double v) { return std::clamp(static_cast<int>(v * kSide), 0, kSide - 1); };
    return static_cast<std::size_t>((along(z) * kSide + along(y)) * kSide + along(x));
  };
  // Cells may overlap several blocks, so each cell is integrated with many points.
  const int n = kSide * kFine;
  for (int i = 0; i < n * n * n; ++i) {
    const int column = i % n, row = i / n % n, layer = i / n / n;
    const double x = (column + 0.5) / n, y = (row + 0.5) / n, z = (layer + 0.5) / n;
    const Vec3f p = corner + size * Vec3f{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
    expected[block(x, y, z)] += kDraws * double(volume_light_pdf(view, 0, p)) * size.x * size.y * size.z / (n * n * n);
  }
  double worst = 0;
  for (std::uint32_t i = 0; i < kDraws; ++i) {
    const auto e = photon(view, i);
    REQUIRE(e.valid);
    CHECK(e.medium == 1);
    const Vec3f at = e.origin - corner;
    observed[block(at.x / size.x, at.y / size.y, at.z / size.z)] += 1;
    // Points inside cells, not on their faces.
    const double pdf = volume_light_pdf(view, 0, e.origin);
    if (std::fabs(pdf / double(e.pdf_position) - 1) > 1e-5) worst += 1;
  }
  CHECK(chi_square(observed, expected).p_value > kSignificance);
  CHECK(worst < 1e-3 * kDraws);
}

TEST_CASE("light emission: photons in spectral mode agree with light sampling at their wavelengths") {
  const TemporaryFolder folder;
  std::vector<Case> cases = {textured(area_case("cube", CubeShape{}, kTilt)), mixed_case(folder)};
  for (Case& c : placed_cases(folder))
    if (c.name == "envmap" || c.name == "textured projector" || c.name == "textured spot" || c.name == "directional")
      cases.push_back(std::move(c));
  for (Case& c : medium_cases(folder)) cases.push_back(std::move(c));
  const double significance = significance_of_each(2 * static_cast<int>(cases.size()));
  for (const Case& c : cases) {
    CAPTURE(c.name);
    const auto scene = compile_scene(c.scene, {false, ColorMode::kSpectral});
    const auto reference = compile_scene(without_compensation(c.scene), {false, ColorMode::kSpectral});
    for (const Receiver& at : c.receivers)
      check_irradiance(scene->view(), reference->view(), at, c.photons, significance);
  }
}

TEST_CASE("light emission: photons start just off the surface and leave with a cosine distribution") {
  const auto cases = area_cases();
  for (const Case& c : cases) {
    CAPTURE(c.name);
    check_surface(c, significance_of_each(static_cast<int>(cases.size())));
  }
}

TEST_CASE("light emission: directions follow their pdf") {
  const TemporaryFolder folder;
  constexpr double kDegree = kPiD / 180;
  const double significance = significance_of_each(9);
  const auto uniform = [](Vec3f) { return 0.25 / kPiD; };
  check_directions(placed_case("", PointLightDescription{}).scene, uniform, -1, significance);
  check_directions(placed_case("", ConstantLightDescription{}).scene, uniform, -1, significance);
  check_directions(medium_case("", fog(2, 0.25f), {kBox}).scene, uniform, -1, significance);
  for (const auto falloff : {Falloff::kLinear, Falloff::kSmooth}) {
    const double z_min = std::cos(50 * kDegree);
    const auto cone = [&](Vec3f) { return 0.5 / kPiD / (1 - z_min); };
    check_directions(placed_case("", spot_of(falloff, Transform(), 50, 20)).scene, cone, z_min, significance);
  }
  SunDescription sun = sun_of(40);
  sun.direction = {0, 0, -1}, sun.up = {0, 0, -1};
  const double rim = std::cos(40 * kDegree);
  check_directions(
      placed_case("", sun).scene, [&](Vec3f) { return 0.5 / kPiD / (1 - rim); }, rim, significance);
  for (const bool compensated : {false, true}) {
    const Description d = placed_case("", envmap_of(folder, compensated)).scene;
    const auto scene = compile_scene(d);
    const auto mixed = [&](Vec3f w) {
      return 0.875 * double(lookup_envmap<Scalar>(scene->view().lights.envmap, -w).pdf_solid_angle) +
             0.125 * 0.25 / kPiD;
    };
    check_directions(d, mixed, -1, significance);
  }
  ProjectorDescription projector = projector_of();
  projector.to_world = Transform();
  const auto scene = compile_scene(placed_case("", projector).scene);
  const double half = std::tan(35 * kDegree);
  const auto on_plane = [&](Random4<Scalar> u) -> std::optional<std::array<double, 2>> {
    const auto e = emit_photon<Scalar>(scene->view(), {0, 1}, u, u, 0.0f);
    const double cosine = e.direction.z;
    CHECK(e.pdf_direction == near(1 / (4 * half * half * cosine * cosine * cosine), 1e-4));
    return std::array<double, 2>{e.direction.x / cosine, e.direction.y / cosine};
  };
  const auto density = [&](double, double) { return 0.25 / (half * half); };
  CHECK(chi_square_plane(on_plane, density, {-half, half, -half, half, 12, 12}, 20000).p_value > significance);
}

TEST_CASE("light emission: beams and surfaces with normal emission emit parallel photons") {
  const BeamDescription beam{kTilt * Transform::scale({1, 1, 2}), rgb({1, 2, 0.5f})};
  const auto ray = compile_scene(placed_case("", beam).scene);
  const auto e = photon(ray->view(), 7);
  CHECK(e.valid);
  CHECK(length(e.origin - Vec3f{0.3f, -0.2f, 3}) < 1e-6f);
  CHECK(length(e.direction - normalize(kTilt.vector({0, 0, 1}))) < 1e-6f);
  CHECK(weighed(e.flux) == near(1 + 4 + 1.5));
  CHECK(power_of(ray->view()) == near(1 + 4 + 1.5));
  CHECK_FALSE(sample_any_light<Scalar>(ray->view(), {0, 0, 0}, {0.5f, 0.5f, 0.5f, 0.5f}).valid);

  const auto cases = area_cases();
  for (Case c : cases) {
    CAPTURE(c.name);
    for (ShapeDescription& shape : c.scene.shapes) shape.emits_along_normal = true;
    for (ShapeGroup& group : c.scene.groups)
      for (ShapeDescription& shape : group.shapes) shape.emits_along_normal = true;
    const auto scene = compile_scene(c.scene);
    check_power(scene->view(), 20000, c.power_error, significance_of_each(static_cast<int>(cases.size())));
    double worst = 0;
    for (std::uint32_t i = 0; i < 500; ++i) {
      const auto p = photon(scene->view(), i);
      if (!p.valid) continue;
      const auto below = trace_ray(scene->view(), p.origin, -p.direction);
      if (!below) continue;
      const Vec3f ng = surface_at(scene->view(), p.origin, -p.direction, *below).ng;
      worst = std::max(worst, double(length(ng - p.direction)));
      CHECK_FALSE(sample_any_light<Scalar>(scene->view(), {0.1f, 0.2f, 0.3f}, random4<Scalar>(66, i, 0, 0)).valid);
    }
    CHECK(worst < 2e-3);
  }
}

TEST_CASE("light emission: two-sided surfaces with normal emission emit twice the power and half to each side") {
  for (Case c : area_cases()) {
    if (c.scene.shapes.empty()) continue;
    CAPTURE(c.name);
    ShapeDescription& shape = c.scene.shapes[0];
    shape.emits_along_normal = true;
    const double one_side = power_of(compile_scene(c.scene)->view());
    shape.emits_on_both_sides = true;
    const auto scene = compile_scene(c.scene);
    const SceneView view = scene->view();
    CHECK(power_of(view) == near(2 * one_side));
    constexpr std::uint32_t kPhotons = 2000;
    check_power(view, 20000, c.power_error, significance_of_each(20));
    double front = 0;
    for (std::uint32_t i = 0; i < kPhotons; ++i) {
      const auto p = photon(view, i);
      REQUIRE(p.valid);
      CHECK(double{p.pdf_direction} == 0.5);
      const auto below = trace_ray(view, p.origin, -p.direction);
      if (!below) continue;
      const float along = dot(surface_at(view, p.origin, -p.direction, *below).ng, p.direction);
      CHECK(std::fabs(along) == near(1, 2e-3));
      front += along > 0 ? 1 : 0;
    }
    // Binomial, within five standard deviations.
    CHECK(front / kPhotons == near(0.5, 2 * 5 * 0.5 / std::sqrt(kPhotons)));
    // As the surface of a lamp with a given power.
    shape.power = 7.0f;
    if (!std::holds_alternative<TextureId>(*shape.radiance))
      CHECK(power_of(compile_scene(c.scene)->view()) == near(7 * (1 + 4 + 1.5), 1e-4));
  }
}

TEST_CASE("light emission: lights are chosen by power for every light selector") {
  Description d = empty_scene(4, 4);
  d.integrator.light_selector = LightSelector::kUniform;
  for (int i = 1; i <= 4; ++i) add_point_light(d, {0, 0, static_cast<float>(i)}, static_cast<float>(i * i));
  const auto scene = compile_scene(d);
  constexpr int kDraws = 50000;
  std::vector<double> observed(4), expected(4);
  for (std::size_t i = 0; i < 4; ++i) expected[i] = kDraws * double((i + 1) * (i + 1)) / 30;
  for (std::uint32_t i = 0; i < kDraws; ++i) {
    const auto choice = choose_light_by_power<Scalar>(scene->view(), random4<Scalar>(63, i, 0, 0).x);
    observed[choice.light] += 1;
    CHECK(choice.probability == near(expected[choice.light] / kDraws));
  }
  CHECK(chi_square(observed, expected).p_value > kSignificance);
  // Photons of single point lights therefore all have the same flux.
  for (std::uint32_t i = 0; i < 100; ++i) CHECK(photon(scene->view(), i).flux.c0 == near(4 * kPiD * 30));
  CHECK_FALSE(emit_photon<Scalar>(scene->view(), {0, 0}, {}, {}, 0.0f).valid);
}

TEST_CASE("light emission: SIMD results of mixed lights equal scalar ones") {
  const TemporaryFolder folder;
  const auto scene = compile_scene(mixed_case(folder).scene);
  const SceneView view = scene->view();
  std::vector<int> seen(view.lights.count);
  double worst = 0;
  int other = 0, total = 0;
  for (std::uint32_t i = 0; i < 20000; i += kWidth) {
    const auto light_of = [&](int lane) {
      return (i / kWidth * 7 + static_cast<std::uint32_t>(lane)) % view.lights.count;
    };
    const auto wide = emit_photon<Wide>(view, {wide_uints([&](int lane) { return light_of(lane); }), WideFloat(0.25f)},
                                        wide_random(64, i), wide_random(65, i), WideFloat(0.0f));
    for (int lane = 0; lane < kWidth; ++lane) {
      const auto one =
          emit_photon<Scalar>(view, {light_of(lane), 0.25f}, lane_random(64, i, lane), lane_random(65, i, lane), 0.0f);
      CAPTURE(light_of(lane));
      ++total;
      const double flux = weighed(one.flux), change = std::fabs(weighed(lane_record(wide.flux, lane)) - flux);
      // On checkerboards and at edges of cones, rounding decides.
      if (lane_of(wide.valid, lane) != one.valid || change > 1e-3 * flux) {
        ++other;
        continue;
      }
      if (!one.valid) continue;
      ++seen[light_of(lane)];
      worst = std::max({worst, record_difference<Vec3>(lane_record(wide.origin, lane), one.origin),
                        record_difference<Vec3>(lane_record(wide.direction, lane), one.direction),
                        difference(wide.pdf_position[lane], one.pdf_position),
                        difference(wide.pdf_direction[lane], one.pdf_direction)});
      CHECK(wide.medium[lane] == one.medium);
      CHECK((one.medium == kNone) == !view.lights.rows[light_of(lane)].is(kLightKind<VolumeLightKind>));
    }
  }
  CHECK(worst < 2e-3);
  CHECK(other < 0.002 * total);
  for (const int count : seen) CHECK(count > 100);
}

TEST_SUITE_END();

}  // namespace sheaf::test_light_emit
