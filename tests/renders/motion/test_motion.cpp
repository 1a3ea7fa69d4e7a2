// Motion blur: closed forms of moving edges, lights and cameras, and agreement of estimators on moving scenes.
#include "kernels/wave/wave_needs.h"
#include "tests/support/envmap_testing.h"
#include "tests/support/light_tracing_testing.h"
#include "tests/support/media_testing.h"
#include "tests/support/motion_testing.h"
#include "tests/support/near.h"
#include "tests/support/render_testing.h"
#include "tests/support/same_bits.h"
#include "tests/support/temporary_folder.h"

namespace sheaf::test_motion {

namespace {

constexpr double kAllowed = 2e-4;  ///< of the tabulated transforms

Transform shift(float x, float y = 0, float z = 0) { return Transform::translate({x, y, z}); }

/// A camera above the origin that sees the point (x, y, 0).
Description view_of(float x, float y, int samples) {
  Description d = one_point_scene(samples);
  look_at_point(d, {x, y, 5}, {x, y, 0}, {0, 1, 0});
  d.integrator.max_depth = 1;
  return d;
}

/// Mean of the green channel.
MeanVariance green(const Description& d) { return pixel_means(d)[1]; }

/// A plane at z = 0 seen from the side, lit by nothing yet.
Description floor_scene(int samples) {
  Description d = one_point_scene(samples);
  look_at_point(d, {0, -4, 4}, {0, 0, 0});
  d.integrator.max_depth = 2;
  add_rectangle(d, Transform::scale({50, 50, 1}), add_diffuse(d, 0.5f));
  return d;
}

/// A wide view of some moving things.
Description busy_scene(int samples) {
  Description d = empty_scene(24, 24);
  d.sampler.sample_count = static_cast<std::uint32_t>(samples);
  look_at(d, {0, -6, 3}, {0, 0, 0.5f}, {0, 0, 1}, 50);
  d.integrator.max_depth = 4;
  add_rectangle(d, Transform::scale({6, 6, 1}), add_diffuse(d, 0.6f));
  move(d, add_sphere(d, {0, 0, 0}, 0.6f, add_diffuse(d, 0.8f)), {{0, shift(-1, 0, 0.6f)}, {1, shift(0, 0.5f, 1)}});
  move(d, add_shape(d, CubeShape{}, {}, add_diffuse(d, 0.4f)),
       {{0, shift(1.2f, 0, 0.7f) * Transform::scale({0.4f, 0.4f, 0.4f})},
        {1, shift(1.2f, 0.3f, 0.9f) * Transform::rotate({0, 0, 1}, 90) * Transform::scale({0.4f, 0.4f, 0.4f})}});
  move(d, emit(add_rectangle(d, {}, {}), 8),
       {{0, shift(-1, 0, 3) * Transform::rotate({1, 0, 0}, 180) * Transform::scale({0.5f, 0.5f, 1})},
        {1, shift(1, 0, 3) * Transform::rotate({1, 0, 0}, 160) * Transform::scale({0.5f, 0.5f, 1})}});
  expose(d, 0, 1);
  return d;
}

}  // namespace

TEST_CASE("motion: an edge that moves leaves a ramp") {
  const double level = significance_of_each(4);
  for (const float x : {-0.6f, -0.2f, 0.3f, 0.7f}) {
    CAPTURE(x);
    Description d = view_of(x, 0, 64);
    // The right edge moves from -1 to 1
    move(d, emit(add_rectangle(d, {}, {}), 1), {{0, shift(-2)}, {1, shift(0)}});
    expose(d, 0, 1);
    check_mean(green(d), 0.5 * (1 - x), level, kAllowed);
  }
}

TEST_CASE("motion: the shutter's ramps weight times by a trapezoid") {
  const double level = significance_of_each(6);
  for (const float ramp : {0.1f, 0.3f, 0.5f})
    for (const double covered : {0.08, 0.6}) {
      CAPTURE(ramp);
      CAPTURE(covered);
      Description d = view_of(0, 0, 64);
      // Covers the origin from 1 - `covered` on
      const auto from = static_cast<float>(2 * covered - 3);
      move(d, emit(add_rectangle(d, {}, {}), 1), {{0, shift(from)}, {1, shift(from + 2)}});
      expose(d, 0, 1, ramp);
      // Area of the trapezoid up to t, by symmetry of the end
      const auto area = [&](double t) {
        return (t < ramp ? t * t / (2 * double(ramp)) : t - 0.5 * double(ramp)) / (1 - double(ramp));
      };
      const double expected = covered > 0.5 ? 1 - area(1 - covered) : area(covered);
      check_mean(green(d), expected, level, kAllowed);
    }
}

TEST_CASE("motion: an edge that turns has constant angular speed") {
  const double level = significance_of_each(3);
  for (const double degrees : {15.0, 30.0, 70.0}) {
    CAPTURE(degrees);
    const double angle = degrees * double(kPi) / 180;
    Description d = view_of(static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 64);
    // A half-plane above the x axis turns by a quarter, so that the point is uncovered in proportion to its angle
    const Transform half = shift(0, 50) * Transform::scale({50, 50, 1});
    ShapeDescription& shape = emit(add_rectangle(d, half), 1);
    shape.motion = add_motion(d, {{0, {}}, {1, Transform::rotate({0, 0, 1}, 90)}});
    d.motions.back() = d.motions.back() * AnimatedTransform(half);
    expose(d, 0, 1);
    check_mean(green(d), degrees / 90, level, kAllowed);
  }
}

TEST_CASE("motion: several keys give several speeds") {
  Description d = view_of(0, 0, 64);
  // The right edge passes the origin at 0.25, stands at 1, and passes it again at 0.875
  move(d, emit(add_rectangle(d, {}, {}), 1), {{0, shift(-2)}, {0.5, shift(0)}, {0.75, shift(0)}, {1, shift(-2)}});
  expose(d, 0, 1);
  check_mean(green(d), 0.625, kSignificance, kAllowed);
}

TEST_CASE("motion: objects and shutter scale together, and part of the keys is exposed") {
  const auto at = [](double scale, double open, double close) {
    Description d = view_of(0.2f, 0, 16);
    move(d, emit(add_rectangle(d, {}, {}), 1), {{0, shift(-2)}, {scale, shift(0)}});
    expose(d, open, close);
    return d;
  };
  CHECK(render(*compile_scene(at(1, 0, 1)), {}).to_image().data ==
        render(*compile_scene(at(16, 0, 16)), {}).to_image().data);
  // Between 0.5 and 0.75 the edge moves from 0 to 0.5
  check_mean(green(at(1, 0.5, 0.75)), 0.6, kSignificance, kAllowed);
}

TEST_CASE("motion: with a closed shutter everything is where it is at that time") {
  for (const double time : {0.0, 0.55, 2.0}) {
    CAPTURE(time);
    Description d = busy_scene(4);
    const Transform rotation = Transform::rotate({0, 0, 1}, 20);
    d.camera.motion = add_motion(d, {{0, d.camera.to_world}, {1, rotation * d.camera.to_world}});
    expose(d, time, time);
    Description still = d;
    for (ShapeDescription& shape : still.shapes)
      if (shape.motion) {
        shape.to_world = d.motions[static_cast<std::size_t>(*shape.motion)].at(time);
        shape.motion.reset();
      }
    still.camera.to_world = d.motions.back().at(time);
    still.camera.motion.reset();
    const Image a = render(*compile_scene(d), {}).to_image(), b = render(*compile_scene(still), {}).to_image();
    double difference = 0, sum = 0;
    for (int y = 0; y < a.height; ++y)
      for (int x = 0; x < a.width; ++x) {
        difference += std::fabs(double(a.at(x, y, 1)) - b.at(x, y, 1));
        sum += b.at(x, y, 1);
      }
    CHECK(difference < 2e-3 * sum);
  }
}

TEST_CASE("motion: a camera that moves sees what an object that moves the other way shows") {
  const auto image = [](bool camera_moves) {
    Description d = empty_scene(32, 32);
    d.sampler.sample_count = 16;
    look_at(d, {0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 40);
    d.integrator.max_depth = 1;
    const Transform there = shift(1, 0.5f) * Transform::rotate({0, 0, 1}, 40);
    ShapeDescription& shape = emit(add_rectangle(d, {}, {}), 1);
    if (camera_moves)
      d.camera.motion = add_motion(d, {{0, d.camera.to_world}, {1, there.inverse() * d.camera.to_world}});
    else
      move(d, shape, {{0, {}}, {1, there}});
    expose(d, 0, 1);
    return render(*compile_scene(d), {}).to_image();
  };
  const Image a = image(true), b = image(false);
  double difference = 0, sum = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      difference += std::fabs(double(a.at(x, y, 1)) - b.at(x, y, 1));
      sum += b.at(x, y, 1);
    }
  // The inverse of the interpolated transform is not the interpolated inverse, but here both turn about the same axis
  CHECK(sum > 50);
  CHECK(difference < 0.15 * sum);
}

TEST_CASE("motion: a point light on a line gives the integral of its irradiance") {
  Description d = floor_scene(64);
  add_point_light(d, {0, 0, 0}, 1);
  // From (-1, 0, 2) to (3, 0, 2)
  LightDescription& light = d.lights.back();
  light.motion = add_motion(d, {{0, {}}, {1, shift(4)}});
  std::get<PointLightDescription>(light.model).position = {-1, 0, 2};
  expose(d, 0, 1);
  const auto antiderivative = [](double x) { return x / std::sqrt(4 + x * x) / 2; };
  const double irradiance = (antiderivative(3) - antiderivative(-1)) / 4;
  check_mean(green(d), 0.5 / double(kPi) * irradiance, kSignificance, 1e-5);
}

TEST_CASE("motion: the intensity of a point light does not depend on the scale of its motion") {
  Description d = floor_scene(64);
  add_point_light(d, {0, 0, 2}, 1);
  // The light stays in place while its space shrinks around it
  LightDescription& light = d.lights.back();
  const auto around = [](float scale) {
    return shift(0, 0, 2) * Transform::scale({scale, scale, scale}) * shift(0, 0, -2);
  };
  light.motion = add_motion(d, {{0, {}}, {1, around(0.25f)}});
  expose(d, 0, 1);
  check_mean(green(d), 0.5 / double(kPi) / 4, kSignificance, 1e-5);
}

TEST_CASE("motion: a surface that turns over shows its other side") {
  Description d = view_of(0, 0, 64);
  d.integrator.max_depth = 2;
  TwoSidedDescription sides;
  sides.front = add_diffuse(d, 0.8f);
  sides.back = add_diffuse(d, 0.2f);
  const auto rotated = [](double angle) { return Transform::rotate({1, 0, 0}, angle); };
  move(d, add_rectangle(d, {}, add_material(d, sides)), {{0, {}}, {0.5, rotated(90)}, {1, rotated(180)}});
  add_constant_light(d, 1);
  expose(d, 0, 1);
  check_mean(green(d), 0.5, kSignificance, 2e-3);
}

TEST_CASE("motion: a sphere that emits on a line gives the integral of its irradiance, however it is sampled") {
  const double level = significance_of_each(3);
  for (const NamedStrategy& strategy : kLightStrategies) {
    CAPTURE(strategy.name);
    Description d = floor_scene(256);
    d.integrator.strategy = strategy.strategy;
    move(d, emit(add_sphere(d, {0, 0, 0}, 0.5f), 4), {{0, shift(-1, 0, 2)}, {1, shift(3, 0, 2)}});
    expose(d, 0, 1);
    // Irradiance of a sphere of radius r above the horizon: pi L r^2 cos / d^2
    const auto antiderivative = [](double x) { return x / std::sqrt(4 + x * x) / 2; };
    const double irradiance = double(kPi) * 4 * 0.25 * (antiderivative(3) - antiderivative(-1)) / 4;
    check_mean(green(d), 0.5 / double(kPi) * irradiance, level, 2e-5);
  }
}

TEST_CASE("motion: a surface that approaches a light is lit where it is") {
  Description d = view_of(0.2f, 0, 64);
  d.integrator.max_depth = 2;
  move(d, add_rectangle(d, {}, add_diffuse(d, 0.5f)), {{0, {}}, {1, shift(0, 0, 1)}});
  add_point_light(d, {0.2f, 0, 2}, 1);
  expose(d, 0, 1);
  // The mean of 1 / (2 - z)^2 for z in [0, 1] is 1 / 2
  check_mean(green(d), 0.5 / double(kPi) * 0.5, kSignificance, 1e-3);
}

TEST_CASE("motion: a blocker casts its shadow for part of the time") {
  Description d = floor_scene(64);
  add_point_light(d, {0, 0, 4}, 1);
  // Half way to the light: its edge passes the axis at 0.3
  move(d, add_rectangle(d, {}, {}), {{0, shift(-1.6f, 0, 2)}, {1, shift(0.4f, 0, 2)}});
  expose(d, 0, 1);
  check_mean(green(d), 0.3 * 0.5 / double(kPi) / 16, kSignificance, 1e-5);
}

TEST_CASE("motion: a directional light that turns gives the mean of its cosine") {
  Description d = floor_scene(64);
  d.lights.push_back({DirectionalLightDescription{{0, 0, -1}}, {}});
  d.lights.back().motion = add_motion(d, {{0, {}}, {1, Transform::rotate({1, 0, 0}, 60)}});
  expose(d, 0, 1);
  const double mean_cosine = std::sin(double(kPi) / 3) / (double(kPi) / 3);
  check_mean(green(d), 0.5 / double(kPi) * mean_cosine, kSignificance, 2e-5);
}

TEST_CASE("motion: a spot light that turns lights a point for part of the time") {
  Description d = floor_scene(64);
  SpotLightDescription spot;
  // From horizontal at rest to straight down
  spot.to_world = shift(0, 0, 2) * Transform::rotate({1, 0, 0}, 270);
  spot.cutoff_angle = spot.beam_width = 30;
  d.lights.push_back({spot, {}});
  const MotionId id = add_motion(d, {{0, Transform::rotate({1, 0, 0}, 90)}, {1, {}}});
  d.lights.back().motion = id;
  d.motions.back() =
      AnimatedTransform(shift(0, 0, 2)) * d.motions.back() * AnimatedTransform(Transform::rotate({1, 0, 0}, 180));
  // A second light, so that the choice depends on the bounds over time
  add_point_light(d, {0, 0, 2}, 1);
  expose(d, 0, 1);
  check_mean(green(d), (1 + 1.0 / 3) * 0.5 / double(kPi) / 4, kSignificance, 2e-5);
}

TEST_CASE("motion: an environment map that turns is sampled where it is") {
  const TemporaryFolder folder;
  test::write_map(folder / "map.exr", test::uneven_image());
  Description d = floor_scene(256);
  const Transform up = Transform::rotate({1, 0, 0}, 90);
  d.lights.push_back({EnvmapDescription{folder / "map.exr", 1, up}, {}});
  d.lights.back().motion = add_motion(d, {{0, up}, {1, Transform::rotate({0, 1, 1}, 100) * up}});
  expose(d, 0, 1);
  check_strategies_agree(d, significance_of_each(9));
}

TEST_CASE("motion: an environment map that turns about the vertical gives the mean over its turns") {
  const TemporaryFolder folder;
  test::write_map(folder / "map.exr", test::uneven_image());
  const auto image = [&](bool moves, double degrees) {
    Description d = floor_scene(512);
    const Transform up = Transform::rotate({1, 0, 0}, 90);
    const auto rotated = [&](double angle) { return Transform::rotate({0, 1, 0}, angle) * up; };
    d.lights.push_back({EnvmapDescription{folder / "map.exr", 1, rotated(degrees)}, {}});
    if (moves) {
      d.lights.back().motion = add_motion(d, {{0, up}, {0.5, rotated(60)}, {1, rotated(120)}});
      std::get<EnvmapDescription>(d.lights.back().model).to_world = up;
      expose(d, 0, 1);
    }
    return green(d);
  };
  // Means over the angle by Gauss's rule with three points
  const MeanVariance first = image(false, 60 * (1 - std::sqrt(0.6))), middle = image(false, 60),
                     last = image(false, 60 * (1 + std::sqrt(0.6)));
  const double expected = (5 * first.mean() + 8 * middle.mean() + 5 * last.mean()) / 18;
  CHECK(std::fabs(first.mean() - last.mean()) > 0.1 * expected);
  CHECK(image(true, 0).mean() == near(expected, 0.05));
}

TEST_CASE("motion: shadows reach blockers that leave the bounds of the first moment") {
  Description d = one_point_scene(64);
  look_at_point(d, {0, -0.4f, 0.4f}, {0, 0, 0});
  d.integrator.max_depth = 2;
  add_rectangle(d, Transform::scale({0.5f, 0.5f, 1}), add_diffuse(d, 0.5f));
  d.lights.push_back({DirectionalLightDescription{{0, 0, -1}}, {}});
  // Blocks the light for the last 0.4 of the time, from high above
  move(d, add_rectangle(d, {}), {{0, shift(-1.6f, 0, 1)}, {0.6, shift(-1, 0, 40)}, {1, shift(-0.6f, 0, 40)}});
  expose(d, 0, 1);
  check_mean(green(d), 0.6 * 0.5 / double(kPi), kSignificance, 1e-4);
}

TEST_CASE("motion: light and BSDF sampling agree on lights that move, turn and stretch") {
  struct Case {
    const char* name;
    decltype(ShapeDescription::geometry) geometry;
  };
  const Case cases[] = {{"rectangle", RectangleShape{}},
                        {"sphere", SphereShape{{0, 0, 0}, 0.8f}},
                        {"disk", DiskShape{}},
                        {"cylinder", CylinderShape{{0, 0, -0.5f}, {0, 0, 0.5f}, 0.4f}},
                        {"cube", CubeShape{}}};
  const double level = significance_of_each(5 * 9);
  for (const Case& c : cases) {
    CAPTURE(c.name);
    Description d = floor_scene(128);
    move(d, emit(add_shape(d, c.geometry, {}), 3),
         {{0, shift(-1, 0.5f, 2) * Transform::rotate({1, 0, 0}, 180) * Transform::scale({1, 0.5f, 0.7f})},
          {1, shift(1, 0, 2.5f) * Transform::rotate({0, 1, 0}, 60) * Transform::rotate({1, 0, 0}, 180) *
                  Transform::scale({0.5f, 1, 1.2f})}});
    add_area_light_rectangle(d, shift(0, 3, 3) * Transform::rotate({1, 0, 0}, 140), 1);
    expose(d, 0, 1);
    check_strategies_agree(d, level);
  }
}

TEST_CASE("motion: lights on moving instances are sampled where they are") {
  Description d = floor_scene(128);
  d.groups.emplace_back();
  ShapeDescription part;
  part.geometry = RectangleShape{};
  part.to_world = Transform::rotate({1, 0, 0}, 180);
  emit(part, 3);
  d.groups.back().shapes.push_back(part);
  for (const float side : {-1.5f, 1.5f}) {
    InstanceDescription instance;
    instance.motion = add_motion(
        d, {{0, shift(side, 0, 2) * Transform::scale({0.5f, 0.5f, 0.5f})},
            {1, shift(side, 2, 2) * Transform::rotate({0, 1, 0}, 10 * side) * Transform::scale({0.8f, 0.5f, 0.5f})}});
    d.instances.push_back(instance);
  }
  InstanceDescription still;
  still.to_world = {1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1, 3};
  d.instances.push_back(still);
  expose(d, 0, 1);
  check_strategies_agree(d, significance_of_each(9));
}

TEST_CASE("motion: light tracing and path tracing agree on a moving scene") {
  Description d = busy_scene(512);
  d.camera.motion =
      add_motion(d, {{0, d.camera.to_world}, {1, shift(1) * Transform::rotate({0, 0, 1}, 20) * d.camera.to_world}});
  // A light that grows
  move(d, emit(add_rectangle(d, {}, {}), 4),
       {{0, shift(0, 2, 2) * Transform::rotate({1, 0, 0}, 150) * Transform::scale({0.3f, 0.3f, 1})},
        {1, shift(0, 2, 2) * Transform::rotate({1, 0, 0}, 150) * Transform::scale({1, 0.5f, 1})}});
  d.integrator.hide_emitters = false;
  check_light_tracing_agrees(d);
}

TEST_CASE("motion: a slab of an absorbing medium that passes attenuates for part of the time") {
  Description d = view_of(0, 0, 256);
  d.integrator.kind = IntegratorKind::kPath;
  d.integrator.max_depth = -1;
  emit(add_rectangle(d, shift(0, 0, -3)), 1);
  ShapeDescription& slab = add_shape(d, CubeShape{}, {});
  slab.material = add_material(d, NullDescription{});
  slab.interior = add_medium(d, fog(0.5f, 0));
  // Covers the axis for 0.7 of the time
  move(d, slab, {{0, shift(-1.6f)}, {1, shift(0.4f)}});
  expose(d, 0, 1);
  check_mean(green(d), 0.3 + 0.7 * std::exp(-1.0), kSignificance, kAllowed);
}

TEST_CASE("motion: the bits do not depend on threads or wave size or crop") {
  Description d = busy_scene(8);
  d.camera.motion = add_motion(d, {{0, d.camera.to_world}, {1, shift(0.5f) * d.camera.to_world}});
  // A tent that sags
  Mesh tent{{{-2, 1, 0.1f}, {0, 1, 1.2f}, {0, 2, 1.2f}}, {}, {}, {{0, 1, 2}}}, sagging = tent;
  sagging.positions[1].z = 0.6f;
  add_shape(d, DeformingMesh{{{0, tent}, {1, sagging}}}, {}, add_diffuse(d, 0.5f));
  RenderOptions options;
  options.aovs = {aov_named("motion"), aov_named("normal")};
  check_same_bits(*compile_scene(d), {64, 256, 1000}, options);
}

TEST_CASE("motion: static scenes have no times and no tables of motion") {
  Description d = busy_scene(4);
  for (ShapeDescription& shape : d.shapes) shape.motion.reset();
  const auto scene = compile_scene(d);
  CHECK_FALSE(scene->view().motion.any());
  CHECK_FALSE(WaveNeeds::of(StageContext(*scene)).times);
  CHECK(compile_scene(busy_scene(4))->view().motion.any());
}

TEST_CASE("motion: the layer of motion holds displacements on the film, to the right and upwards") {
  // One unit at distance 4 covers 1 / 8 of the image
  const auto layer = [](const Description& d) {
    RenderOptions options;
    options.aovs = {aov_named("motion")};
    const Image image = render(*compile_scene(d), options).to_image();
    const int u = image.find_channel("forward.u"), v = image.find_channel("forward.v");
    REQUIRE(u >= 0);
    REQUIRE(v >= 0);
    return Vec3f{image.at(8, 8, u), image.at(8, 8, v), image.at(0, 0, u)};
  };
  const auto scene = [] {
    Description d = empty_scene(16, 16);
    d.sampler.sample_count = 4;
    look_at(d, {0, 0, 4}, {0, 0, 0});
    expose(d, 0, 2);
    return d;
  };
  const auto check = [](Vec3f found, float right, float up) {
    CHECK(found.x == near(right, 1e-3));
    CHECK(found.y == near(up, 1e-3));
  };
  // A wall that moves
  const Transform wall = Transform::scale({20, 20, 1});
  Description d = scene();
  move(d, add_rectangle(d, wall, add_diffuse(d, 0.5f)), {{0, wall}, {2, shift(0.5f, 0.25f) * wall}});
  check(layer(d), 1, 0.5f);
  // Half of the motion lies in the exposure
  expose(d, 1, 2);
  check(layer(d), 0.5f, 0.25f);
  // A camera that moves, and one that looks at a wall that moves along
  d = scene();
  add_rectangle(d, wall, add_diffuse(d, 0.5f));
  d.camera.motion = add_motion(d, {{0, d.camera.to_world}, {2, shift(0.5f, 0.25f) * d.camera.to_world}});
  check(layer(d), -1, -0.5f);
  move(d, d.shapes[0], {{0, wall}, {2, shift(0.5f, 0.25f) * wall}});
  check(layer(d), 0, 0);
  // A sphere in a moving instance, with a background that has no motion
  d = scene();
  d.groups.emplace_back();
  d.groups.back().shapes.push_back({});
  d.groups.back().shapes.back().geometry = SphereShape{{0, 0, 0}, 1};
  InstanceDescription instance;
  instance.motion = add_motion(d, {{0, shift(-0.1f)}, {2, shift(0.1f)}});
  d.instances.push_back(instance);
  const Vec3f sphere = layer(d);
  CHECK(sphere.x == near(0.2 * 8 / 3, 0.03));
  CHECK(sphere.z == 0);
  // A wall that stretches to twice its height above the point (0, -20, 0)
  d = scene();
  Mesh low{{{-20, -20, 0}, {20, -20, 0}, {20, 20, 0}, {-20, 20, 0}}, {}, {}, {{0, 1, 2}, {0, 2, 3}}}, high = low;
  high.positions[2].y = high.positions[3].y = 20.8f;
  add_shape(d, DeformingMesh{{{0, low}, {2, high}}}, {}, add_diffuse(d, 0.5f));
  const Vec3f stretched = layer(d);
  CHECK(stretched.x == within(0, 1e-4));
  CHECK(stretched.y == near(0.8, 0.03));
  // Nothing moves
  d = scene();
  add_rectangle(d, wall, add_diffuse(d, 0.5f));
  check(layer(d), 0, 0);
}

}  // namespace sheaf::test_motion
