// Meters and batches of cameras against closed forms, and lights that only photons can find.
#include "tests/support/near.h"
#include "tests/support/render_testing.h"

namespace sheaf::test_sensors {

namespace {

using Projection = CameraDescription::Projection;

constexpr double kPiD = 3.14159265358979;

Description meter(Projection projection, const Transform& to_world, int samples) {
  Description d = empty_scene(1, 1);
  d.camera.projection = projection;
  d.camera.to_world = to_world;
  d.sampler.sample_count = static_cast<std::uint32_t>(samples);
  d.integrator.max_depth = 2;
  return d;
}

double measured(const Description& d) { return double(render(*compile_scene(d), {}).film.to_image().at(0, 0, 0)); }

}  // namespace

TEST_CASE("sensors: irradiance meters match the closed form") {
  // Under a constant environment: pi times its radiance, or half of it where a wall covers half the hemisphere.
  Description d = meter(Projection::kIrradianceMeter, Transform::rotate({1, 2, 0}, 50), 4096);
  add_rectangle(d, d.camera.to_world, add_diffuse(d, 0));
  add_constant_light(d, 0.5f);
  CHECK(measured(d) == near(0.5 * kPiD, 1e-3));
  // Below a disk of radius r at height h on the axis: pi L r^2 / (r^2 + h^2) for a small meter.
  Description below = meter(Projection::kIrradianceMeter, Transform::scale({0.01f, 0.01f, 1}), 16384);
  add_rectangle(below, below.camera.to_world, add_diffuse(below, 0));
  const Transform position = Transform::translate({0, 0, 2}) * Transform::rotate({1, 0, 0}, 180);
  emit(add_shape(below, DiskShape{}, position, add_diffuse(below, 0)), 3);
  CHECK(measured(below) == near(3 * kPiD / 5, 0.01));
  // With several pixels, each measures its part of the surface. The left of two is shadowed by a wall.
  Description parts = meter(Projection::kIrradianceMeter, Transform(), 1024);
  parts.film.width = 2;
  add_rectangle(parts, Transform(), add_diffuse(parts, 0));
  add_rectangle(parts, Transform::translate({-0.6f, 0, 0.01f}) * Transform::scale({0.61f, 2, 1}),
                add_diffuse(parts, 0));
  add_constant_light(parts, 1);
  const Image image = render(*compile_scene(parts), {}).film.to_image();
  CHECK(image.at(0, 0, 0) < 0.1);
  CHECK(image.at(1, 0, 0) > 2.9);
}

TEST_CASE("sensors: radiance meters and distant sensors match the closed form") {
  const Transform down = Transform::translate({0.2f, 0.1f, 3}) * Transform::rotate({1, 0, 0}, 180);
  for (const Projection projection : {Projection::kRadianceMeter, Projection::kDistant}) {
    Description d = meter(projection, down, 4096);
    add_rectangle(d, Transform(), add_diffuse(d, 0.5f));
    add_point_light(d, {0.2f, 0.1f, 2}, 8);
    // The point below the light: I rho / (pi h^2).
    const double seen = 8 * 0.5 / kPiD / 4;
    d.camera.target = Vec3f{0.2f, 0.1f, 0};
    CHECK(measured(d) == near(seen, 1e-4));
  }
  // A square light fills 2 / pi of the disk around it. With a target area, it fills all or half.
  Description d = meter(Projection::kDistant, down, 16384);
  emit(add_rectangle(d, Transform(), add_diffuse(d, 0)), 5);
  CHECK(measured(d) == near(5 * 2 / kPiD, 0.01));
  d.camera.target = CameraDescription::TargetArea{Transform::scale({0.9f, 0.9f, 1}), true};
  CHECK(measured(d) == near(5, 1e-5));
  d.camera.target = CameraDescription::TargetArea{Transform::translate({1, 0, 0}), false};
  CHECK(measured(d) == near(2.5, 0.01));
}

TEST_CASE("sensors: a batch shows the image of each camera") {
  Description d = empty_scene(32, 16);
  d.sampler.sample_count = 64;
  d.integrator.max_depth = 2;
  add_rectangle(d, Transform::translate({0, 0, 3}) * Transform::rotate({0, 1, 0}, 180), add_diffuse(d, 0.5f));
  add_point_light(d, {0.4f, 0.5f, 1}, 8);
  CameraDescription second = d.camera;
  second.projection = Projection::kSpherical;
  Description batch = d;
  batch.more_cameras = {second};
  batch.camera.fov = 70;
  const Image both = render(*compile_scene(batch), {}).film.to_image();
  for (int i = 0; i < 2; ++i) {
    Description alone = d;
    alone.film.width = 16;
    alone.camera = i == 0 ? batch.camera : second;
    const Image one = render(*compile_scene(alone), {}).film.to_image();
    double difference = 0, sum = 0;
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x) {
        difference += std::fabs(double(both.at(16 * i + x, y, 0)) - double(one.at(x, y, 0)));
        sum += double(one.at(x, y, 0));
      }
    CHECK(sum > 1);
    CHECK(difference < 0.05 * sum);
  }
  batch.film.width = 33;
  CHECK_THROWS_AS(compile_scene(batch), SceneError);
  batch.film.width = 32;
  batch.integrator.kind = IntegratorKind::kLightTracer;
  CHECK_THROWS_AS(compile_scene(batch), SceneError);
}

TEST_CASE("sensors: light tracing shows collimated light and path tracing does not") {
  Description d = empty_scene(16, 16);
  d.camera.projection = Projection::kOrthographic;  // shows [-1, 1]^2 of a floor of albedo 0.5 from above
  look_at(d, {0, 0, 5}, {0, 0, 0}, {0, 1, 0});
  d.sampler.sample_count = 256;
  add_rectangle(d, Transform::scale({3, 3, 1}), add_diffuse(d, 0.5f));
  const auto mean = [](Description scene, IntegratorKind kind) {
    scene.integrator.kind = kind;
    scene.integrator.max_depth = 2;
    const Image image = render(*compile_scene(scene), {}).to_image();
    double sum = 0;
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x) sum += double(image.at(x, y, 0)) / 256;
    return sum;
  };
  // A beam of 3 W averages over the visible 4 m^2. A square of half the side emits 2 W/m^2 over a quarter of them.
  Description ray = d;
  ray.lights.push_back({BeamDescription{Transform::translate({0.3f, 0.2f, 2}) * Transform::rotate({1, 0, 0}, 180),
                                        SpectrumDescription::constant(3)},
                        {}});
  CHECK(mean(ray, IntegratorKind::kLightTracer) == near(3 * 0.5 / kPiD / 4, 1e-3));
  CHECK(mean(ray, IntegratorKind::kPath) == 0);
  Description square = d;
  look_at(square, {0, 0, 1}, {0, 0, 0}, {0, 1, 0});
  ShapeDescription& light = emit(add_rectangle(square,
                                               Transform::translate({0, 0, 2}) * Transform::rotate({1, 0, 0}, 180) *
                                                   Transform::scale({0.5f, 0.5f, 1}),
                                               add_diffuse(square, 0)),
                                 2);
  light.emits_along_normal = true;
  CHECK(mean(square, IntegratorKind::kLightTracer) == near(2 * 0.5 / kPiD / 4, 0.01));
  CHECK(mean(square, IntegratorKind::kPath) == 0);
}

}  // namespace sheaf::test_sensors
