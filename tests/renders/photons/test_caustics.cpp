// Manifold next-event estimation: the mean of BSDF sampling, closed forms for lights that BSDF sampling cannot find,
// less noise, and bits that do not depend on threads or waves.
#include "core/io/error.h"
#include "kernels/bsdf/fresnel.h"
#include "scene/dialects/common/integrators.h"
#include "tests/support/capture.h"
#include "tests/support/caustic_testing.h"
#include "tests/support/media_testing.h"
#include "tests/support/motion_testing.h"
#include "tests/support/near.h"

#include <cmath>

namespace sheaf::test_caustics {

namespace {

/// All comparisons of means of this file together fail with probability kSignificance if the estimator is unbiased.
const double kLevel = significance_of_each(40);

Rendered check_agreement(const Description& d, double max_variance, ColorMode color = ColorMode::kRgb,
                         GuidingMode guiding = GuidingMode::kOff) {
  return check_caustics_agree(d, max_variance, kLevel, color, guiding);
}

}  // namespace

TEST_CASE("caustics: connections through a glass ball have the mean of BSDF sampling") {
  for (const int max_depth : {-1, 4}) {
    CAPTURE(max_depth);
    Description d = floor_scene(256);
    d.integrator.max_depth = max_depth;
    add_sphere(d, {0, 0, 1}, 0.6f, add_glass(d));
    add_lamp(d, {-0.4f, 0.1f, 4}, 0.4f, 10);
    check_agreement(d, 0.3);
  }
}

TEST_CASE("caustics: chains that are too long for the depth or for connections are not lost") {
  // Depth 3 ends before the light behind two refractions; two slabs have chains of 4 and, by reflection, more vertices.
  Description d = floor_scene(64);
  add_shape(d, CubeShape{}, Transform::translate({0, 0, 1}) * Transform::scale({3, 3, 0.2f}), add_glass(d, 2));
  add_lamp(d, {0.4f, 0.1f, 3}, 1, 10);
  d.integrator.max_depth = 3;
  CHECK(render_with(d, CausticMode::kManifold).pixels.mean() == 0);
  CHECK(render_with(d, CausticMode::kSampled).pixels.mean() == 0);
  d.integrator.max_depth = -1;
  check_agreement(d, 1.5);
  add_shape(d, CubeShape{}, Transform::translate({0, 0, 1.8f}) * Transform::scale({3, 3, 0.2f}), add_glass(d, 1.3f));
  check_agreement(d, 1.5);
}

TEST_CASE("caustics: connections by mirrors have the mean of BSDF sampling for all kinds of area lights") {
  for (const int light : {0, 1, 2}) {
    CAPTURE(light);
    Description d = floor_scene(256);
    d.integrator.max_depth = 5;
    const MaterialId metal = add_two_sided(d, add_mirror(d, 0.9f));
    add_sphere(d, {-0.8f, 0, 0.7f}, 0.5f, metal);
    add_shape(d, CylinderShape{{0, 1.2f, 0}, {0, 1.2f, 2}, 0.3f}, Transform(), metal);
    if (light == 0) add_area_light_sphere(d, {1.2f, 0.5f, 2}, 0.3f, 10);
    if (light == 1) add_lamp(d, {1.2f, 0.5f, 2}, 0.3f, 10);
    if (light == 2)
      emit(add_shape(d, DiskShape{},
                     Transform::translate({1.2f, 0.5f, 2}) * Transform::rotate({0, 1, 0}, 200) *
                         Transform::scale({0.3f, 0.4f, 1}),
                     add_diffuse(d, 0)),
           10);
    check_agreement(d, 0.5);
  }
}

TEST_CASE("caustics: spectral and dispersive glass and guided paths have the mean of BSDF sampling") {
  Description d = floor_scene(256);
  d.integrator.max_depth = 5;
  add_sphere(d, {0, 0, 1}, 0.6f, add_dispersive_glass(d));
  add_lamp(d, {-0.4f, 0.1f, 4}, 0.6f, 10);
  check_agreement(d, 2, ColorMode::kSpectral);
  check_agreement(d, 1.5, ColorMode::kRgb, GuidingMode::kOn);
}

TEST_CASE("caustics: vertices may be rough or blended or layered or follow another vertex") {
  using Maker = std::optional<MaterialId> (*)(Description&);
  const Maker rough = [](Description& d) -> std::optional<MaterialId> {
    ConductorDescription metal;
    metal.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.5f, 0.5f};
    return add_material(d, metal);
  };
  const Maker blend = [](Description& d) -> std::optional<MaterialId> {
    return add_material(d, BlendDescription{0.4f, {add_diffuse(d, 0.6f), add_mirror(d, 0.8f)}});
  };
  const Maker plastic = [](Description& d) -> std::optional<MaterialId> {
    return add_material(d, PlasticDescription{});
  };
  for (const Maker material : {rough, blend, plastic}) {
    Description d = floor_scene(256, material);
    d.integrator.max_depth = 6;
    add_sphere(d, {0, 0, 1}, 0.6f, add_glass(d));
    add_lamp(d, {-0.4f, 0.1f, 4}, 0.6f, 10);
    // A wall that receives and returns indirect light
    add_rectangle(d, Transform::translate({-1.5f, 0, 1}) * Transform::rotate({0, 1, 0}, 90), add_diffuse(d, 0.9f));
    check_agreement(d, 1);
  }
}

TEST_CASE("caustics: a mirror shows the image of a light at a point") {
  Description d = floor_scene(64);
  // A mirror in the plane x = -1, which faces +x
  add_rectangle(d, Transform::translate({-1, 0, 2}) * Transform::rotate({0, 1, 0}, 90) * Transform::scale({2, 3, 1}),
                add_mirror(d, 0.7f));
  add_point_light(d, {0.8f, 0.4f, 1.5f}, 3);
  d.integrator.max_depth = 3;
  const auto reflected = [](Vec3f light) {
    const Vec3f to = light - Vec3f{0.3f, 0, 0};
    const double squared = static_cast<double>(dot(to, to));
    return 0.8 / 3.14159265 * 3 * static_cast<double>(light.z) / (squared * std::sqrt(squared));
  };
  const double direct = reflected({0.8f, 0.4f, 1.5f}), image = 0.7 * reflected({-2.8f, 0.4f, 1.5f});
  const Rendered connected = render_with(d, CausticMode::kManifold);
  check_mean(connected.pixels, direct + image, kLevel, 1e-3 * direct);
  // BSDF sampling cannot find the light.
  CHECK(render_with(d, CausticMode::kSampled).pixels.mean() == near(direct, 2e-3));
}

TEST_CASE("caustics: lights at a point and in a direction shine through a slab of glass") {
  Description d = floor_scene(64);
  add_shape(d, CubeShape{}, Transform::translate({0, 0, 1}) * Transform::scale({5, 5, 0.25f}), add_glass(d, 1.6f));
  d.integrator.max_depth = 4;
  const auto transmittance = [](double cosine) {
    const double once = static_cast<double>(fresnel_dielectric<Scalar>(static_cast<float>(cosine), 1.6f).reflectance);
    return (1 - once) * (1 - once);
  };
  // A light straight above: the glass of thickness 0.5 brings it closer by 0.5 (1 - 1 / 1.6).
  add_point_light(d, {0.3f, 0, 3}, 5);
  const double distance = 2.5 + 0.5 / 1.6;
  check_mean(render_with(d, CausticMode::kManifold).pixels,
             0.8 / 3.14159265 * 5 * transmittance(1) / (distance * distance), kLevel, 1e-3);
  // A sun at 40 degrees: the slab does not change its direction.
  d.lights.clear();
  const double angle = 0.7;
  d.lights.push_back(
      {DirectionalLightDescription{{static_cast<float>(std::sin(angle)), 0, static_cast<float>(-std::cos(angle))},
                                   SpectrumDescription::constant(2)},
       {}});
  check_mean(render_with(d, CausticMode::kManifold).pixels,
             0.8 / 3.14159265 * 2 * std::cos(angle) * transmittance(std::cos(angle)), kLevel, 1e-3);
}

TEST_CASE("caustics: images do not depend on threads and waves, and without casters the option changes nothing") {
  Description d = floor_scene(8);
  add_lamp(d, {-0.4f, 0.1f, 4}, 0.6f, 10);
  const auto pixels = [&d](CausticMode mode, int threads, int wave_size) {
    RenderOptions options;
    options.caustics = mode;
    options.threads = threads;
    options.wave_size = wave_size;
    return render(*compile_scene(d, {}), options).film.to_image().data;
  };
  CHECK(pixels(CausticMode::kManifold, 1, 0) == pixels(CausticMode::kSampled, 1, 0));
  add_sphere(d, {0, 0, 1}, 0.6f, add_glass(d));
  const auto expected = pixels(CausticMode::kManifold, 1, 0);
  CHECK(expected != pixels(CausticMode::kSampled, 1, 0));
  CHECK(expected == pixels(CausticMode::kManifold, 3, 64));
}

TEST_CASE("caustics: connections in motion have the mean of BSDF sampling and of images at fixed times") {
  const auto scene = [](bool deforms) {
    Description d = floor_scene(128);
    d.integrator.max_depth = 4;
    expose(d, 0, 1);
    const auto shift = [](float x, float y, float z) { return Transform::translate({x, y, z}); };
    if (!deforms) {
      // The caster and the camera
      ShapeDescription& ball = add_sphere(d, {0, 0, 0}, 0.6f, add_glass(d));
      move(d, ball,
           {{0, shift(-0.5f, -0.3f, 0.8f) * Transform::scale({1, 1, 0.7f})},
            {1, shift(0.5f, 0.3f, 1.4f) * Transform::rotate({0, 1, 0}, 50)}});
      add_lamp(d, {-0.4f, 0.1f, 4}, 0.4f, 10);
      d.camera.motion = add_motion(d, {{0, d.camera.to_world}, {1, shift(0.4f, 0, 0) * d.camera.to_world}});
    } else {
      // A pane of glass that bends, a floor that rises, and the lamp
      const auto pane = [](float bend, float height) {
        const Vec3f a = normalize(Vec3f{-bend, 0, 1}), b = normalize(Vec3f{bend, 0, 1});
        return Mesh{{{-2, -2, height}, {2, -2, height}, {2, 2, height}, {-2, 2, height}},
                    {a, b, b, a},
                    {},
                    {{0, 1, 2}, {0, 2, 3}}};
      };
      add_shape(d, DeformingMesh{{{0, pane(0, 0.6f)}, {1, pane(0.3f, 1.4f)}}}, {}, add_glass(d));
      const Transform floor = d.shapes[0].to_world;
      move(d, d.shapes[0], {{0, floor}, {1, shift(0, 0, 0.2f) * floor}});
      add_lamp(d, {0, 0, 0}, 0.4f, 10);
      const Transform lamp = d.shapes.back().to_world;
      move(d, d.shapes.back(),
           {{0, shift(-1.2f, 0.1f, 3) * lamp},
            {1, shift(0.4f, 0, 4.5f) * Transform::rotate({1, 0, 0}, 40) * lamp * Transform::scale({0.3f, 1.5f, 1})}});
    }
    return d;
  };
  for (const bool deforms : {false, true}) {
    CAPTURE(deforms);
    Description d = scene(deforms);
    const Rendered moving = check_agreement(d, 1);
    // The mean over the times of the connected images
    constexpr int kTimes = 64;
    d.sampler.sample_count /= kTimes;
    MeanVariance still;
    double variance = 0;
    for (int i = 0; i < kTimes; ++i) {
      expose(d, (i + 0.5) / kTimes, (i + 0.5) / kTimes);
      const Rendered at_time = render_with(d, CausticMode::kManifold, ColorMode::kRgb, GuidingMode::kOff,
                                           100 + static_cast<std::uint32_t>(i));
      still.add(at_time.pixels.mean());
      variance += at_time.pixels.variance() / (kTimes * kTimes * 256);
    }
    const double error = std::sqrt(variance + moving.pixels.variance() / 256);
    INFO("means " << moving.pixels.mean() << " and " << still.mean() << ", standard error " << error);
    // The times are no random sample
    const double distance = std::fabs(moving.pixels.mean() - still.mean()) - 5e-3 * still.mean();
    CHECK(student_t_p_value(std::max(distance, 0.0) / error, 255) >= kLevel);
  }
}

TEST_CASE("caustics: a moving mirror shows the moving image of a light at a point") {
  Description d = floor_scene(64);
  d.integrator.max_depth = 3;
  // In the plane x = -1 at first and x = -2 in the end, as it faces +x; the light sinks
  const auto mirror = [](float x) {
    return Transform::translate({x, 0, 2}) * Transform::rotate({0, 1, 0}, 90) * Transform::scale({2, 3, 1});
  };
  move(d, add_rectangle(d, mirror(-1), add_mirror(d, 0.7f)), {{0, mirror(-1)}, {1, mirror(-2)}});
  add_point_light(d, {0.8f, 0.4f, 2}, 3);
  d.lights.back().motion = add_motion(d, {{0, Transform()}, {1, Transform::translate({0, 0, -1})}});
  expose(d, 0, 1);
  // The light leaves a black ball, and is seen only in the mirror
  const MaterialId black = add_diffuse(d, 0);
  add_sphere(d, {0.8f, 0.4f, 2}, 0.05f, black);
  add_rectangle(
      d, Transform::translate({0.5f, 0, 0.525f}) * Transform::rotate({0, 1, 0}, 90) * Transform::scale({0.325f, 1, 1}),
      black);
  const auto reflected = [](double x, double z) {
    const double squared = (x - 0.3) * (x - 0.3) + 0.4 * 0.4 + z * z;
    return 0.8 / 3.14159265 * 3 * z / (squared * std::sqrt(squared));
  };
  double expected = 0;
  constexpr int kSteps = 1000;
  for (int i = 0; i < kSteps; ++i) {
    const double t = (i + 0.5) / kSteps;
    if (t < 0.05) continue;
    expected += 0.7 * reflected(-2.8 - 2 * t, 2 - t) / kSteps;
  }
  check_mean(render_with(d, CausticMode::kManifold).pixels, expected, kLevel, 1e-4 * expected);
}

TEST_CASE("caustics: integrators and scenes without support are rejected") {
  Description d = floor_scene(1);
  const auto error = [&d] {
    RenderOptions options;
    options.caustics = CausticMode::kManifold;
    try {
      render(*compile_scene(d, {}), options);
    } catch (const Error& e) { return std::string(e.what()); }
    return std::string();
  };
  add_sphere(d, {0, 0, 1}, 0.6f, add_glass(d));
  CHECK(error().empty());
  apply_integrator_name("path_mats", false, d);
  CHECK(error().find("path_mats") != std::string::npos);
  apply_integrator_name("photonmapper", false, d);
  CHECK(error().find("photonmapper") != std::string::npos);
  apply_integrator_name("path", false, d);
  d.camera.medium = add_medium(d, fog(0.2f, 0.9f));
  CHECK(error().find("participating media") != std::string::npos);
}

}  // namespace sheaf::test_caustics
