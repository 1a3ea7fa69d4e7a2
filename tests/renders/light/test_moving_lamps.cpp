// Lamps that move: in instances, far from where they were at first, in large and tiny scenes, and under a shutter that
// opens and closes slowly. Estimators agree with each other and with the mean of still frames.
#include "tests/support/instancing_testing.h"
#include "tests/support/light_tracing_testing.h"
#include "tests/support/motion_testing.h"
#include "tests/support/near.h"
#include "tests/support/render_testing.h"

namespace sheaf::test_moving_lamps {

namespace {

Transform shift(float x, float y = 0, float z = 0) { return Transform::translate({x, y, z}); }
Transform scaled(float by) { return Transform::scale({by, by, by}); }

/// A corner of two walls seen from the front.
Description corner_scene(int samples) {
  Description d = empty_scene(16, 16);
  d.sampler.kind = SamplerKind::kIndependent;
  d.sampler.sample_count = static_cast<std::uint32_t>(samples);
  look_at(d, {0, -6, 4}, {0, 0, 1}, {0, 0, 1}, 45);
  d.integrator.max_depth = 3;
  add_rectangle(d, scaled(4), add_diffuse(d, 0.6f));
  add_rectangle(d, shift(0, 3) * Transform::rotate({1, 0, 0}, 90) * scaled(4), add_diffuse(d, 0.4f));
  return d;
}

/// A lamp on an arc above the floor, half way with the error of interpolation along its normal.
MotionKeys orbit(float unit) {
  const auto at = [unit](double angle) {
    return shift(0, 0, 2) * Transform::rotate({0, 1, 0}, angle) * scaled(0.5f * unit);
  };
  return {{0, at(0)}, {1, at(60)}};
}

/// The mean of the image by one integrator, over several seeds.
MeanVariance image_means(Description d, IntegratorKind kind, LightStrategy strategy = LightStrategy::kMis) {
  d.integrator.kind = kind;
  d.integrator.strategy = strategy;
  MeanVariance out;
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    d.sampler.seed = seed + 20 * static_cast<std::uint32_t>(strategy) + (kind == IntegratorKind::kPath ? 0 : 100);
    const Image image = render(*compile_scene(d), {}).to_image();
    double sum = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) sum += double(image.at(x, y, 1));
    out.add(sum / (image.width * image.height));
  }
  return out;
}

/// Checks that path tracing with and without light sampling and light tracing have the same mean.
void check_estimators(const Description& d, double level) {
  const MeanVariance by_bsdf = image_means(d, IntegratorKind::kPath, LightStrategy::kBsdfOnly);
  check_same_mean(image_means(d, IntegratorKind::kPath), by_bsdf, level, 8);
  check_same_mean(image_means(d, IntegratorKind::kPath, LightStrategy::kLightOnly), by_bsdf, level, 8);
  check_same_mean(image_means(d, IntegratorKind::kLightTracer), by_bsdf, level, 8);
}

/// The scene at one time.
Description still(Description d, double time) {
  expose(d, time, time);
  return d;
}

/// The mean of an image over all pixels.
double mean_of(const Image& image) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) sum += double(image.at(x, y, 1));
  return sum / (image.width * image.height);
}

/// The difference of an image from the mean of still images at the middles of `parts` parts of the shutter, relative.
double difference_from_stills(const Description& d, int parts) {
  const Image image = render(*compile_scene(d), {}).to_image();
  std::vector<double> stills(static_cast<std::size_t>(image.width * image.height), 0.0);
  for (int i = 0; i < parts; ++i) {
    Description at = still(d, (i + 0.5) / parts);
    at.sampler.seed = static_cast<std::uint32_t>(50 + i);
    const Image frame = render(*compile_scene(at), {}).to_image();
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        stills[static_cast<std::size_t>(y * image.width + x)] += double(frame.at(x, y, 1)) / parts;
  }
  double difference = 0, sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const double expected = stills[static_cast<std::size_t>(y * image.width + x)];
      difference += std::fabs(double(image.at(x, y, 1)) - expected);
      sum += expected;
    }
  return difference / sum;
}

ShapeDescription lamp_of(const decltype(ShapeDescription::geometry)& geometry, float unit) {
  ShapeDescription lamp;
  lamp.geometry = geometry;
  lamp.to_world = shift(0, 0, 1 / unit) * Transform::rotate({0, 1, 0}, 180) * scaled(0.3f / unit);
  emit(lamp, 12);
  return lamp;
}

}  // namespace

TEST_CASE("moving lamps: lamps in instances on an arc light as much as they show") {
  const struct {
    const char* name;
    decltype(ShapeDescription::geometry) geometry;
  } kLamps[] = {{"rectangle", RectangleShape{}},
                {"disk", DiskShape{}},
                {"sphere", SphereShape{}},
                {"mesh", smooth_mesh()},
                {"cylinder", CylinderShape{}}};
  const double level = significance_of_each(3 * std::size(kLamps));
  for (const auto& lamp : kLamps) {
    CAPTURE(lamp.name);
    Description d = corner_scene(64);
    // In millimeters, below a placement that scales them
    constexpr float kUnit = 1e-3f;
    d.groups.push_back({{lamp_of(lamp.geometry, kUnit)}, {}, {}});
    InstanceDescription instance;
    instance.motion = add_motion(d, orbit(kUnit));
    d.instances.push_back(instance);
    expose(d, 0, 1);
    check_estimators(d, level);
  }
}

TEST_CASE("moving lamps: deforming lamps in moving instances light as much as they show") {
  Description d = corner_scene(64);
  Mesh flat{{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {}, {}, {{0, 1, 2}, {0, 2, 3}}}, bent = flat;
  bent.positions[2].z = bent.positions[3].z = 0.8f;
  d.groups.push_back({{lamp_of(DeformingMesh{{{0, flat}, {1, bent}}}, 1)}, {}, {}});
  InstanceDescription instance;
  instance.motion = add_motion(d, orbit(1));
  d.instances.push_back(instance);
  expose(d, 0, 1);
  check_estimators(d, significance_of_each(3));
}

TEST_CASE("moving lamps: lamps far from their first place light as much as they show") {
  const double level = significance_of_each(6);
  for (const bool sphere : {false, true}) {
    CAPTURE(sphere);
    // The lamp passes the scene at 3/4 of its way
    Description d = corner_scene(256);
    for (ShapeDescription& shape : d.shapes) shape.to_world = shift(1500) * shape.to_world;
    d.camera.to_world = shift(1500) * d.camera.to_world;
    ShapeDescription& lamp =
        sphere ? add_sphere(d, {0, 0, 2}, 0.5f) : add_rectangle(d, shift(0, 0, 2) * Transform::rotate({0, 1, 0}, 180));
    emit(lamp, 12);
    const Transform at = lamp.to_world;
    move(d, lamp, {{0, at}, {0.1, shift(1498) * at}, {0.9, shift(1502) * at}, {1, shift(2000) * at}});
    expose(d, 0, 1);
    check_estimators(d, level);
  }
}

TEST_CASE("moving lamps: a lamp at a point moves alike in scenes of all sizes") {
  for (const float floor : {4.0f, 5e3f, 5e5f}) {
    CAPTURE(floor);
    Description d = empty_scene(8, 8);
    d.sampler.sample_count = 512;
    look_at(d, {0, 0, 8}, {0, 0, 0}, {0, 1, 0}, 30);
    d.integrator.max_depth = 2;
    add_rectangle(d, scaled(floor), add_diffuse(d, 0.5f));
    add_point_light(d, {-1, 0, 1}, 5);
    d.lights.back().motion = add_motion(d, {{0, {}}, {0.5, shift(2)}, {1, {}}});
    expose(d, 0, 1);
    CHECK(difference_from_stills(d, 32) < 0.02);
  }
}

TEST_CASE("moving lamps: moving cameras blur alike in scenes of all sizes") {
  for (const float size : {1e-5f, 1.0f, 1e5f}) {
    CAPTURE(size);
    Description d = empty_scene(8, 8);
    d.sampler.sample_count = 512;
    look_at(d, {0, 0, 8 * size}, {0, 0, 0}, {0, 1, 0}, 30);
    d.camera.near_clip = 1e-3f * size;
    d.integrator.max_depth = 1;
    emit(add_rectangle(d, scaled(size)), 1);
    const Transform at = d.camera.to_world;
    d.camera.motion = add_motion(d, {{0, shift(-size) * at}, {0.5, shift(size) * at}, {1, shift(-size) * at}});
    d.camera.to_world = d.motions.back().reference();
    expose(d, 0, 1);
    CHECK(difference_from_stills(d, 64) < 0.03);
  }
}

TEST_CASE("moving lamps: photons and camera paths have times in proportion to the open area of the shutter") {
  // A lamp that is near the floor half way, with the shutter half closed before and after
  const auto scene = [](float ramp) {
    Description d = empty_scene(8, 8);
    d.sampler.kind = SamplerKind::kIndependent;
    d.sampler.sample_count = 256;
    look_at(d, {0, 0, 8}, {0, 0, 0}, {0, 1, 0}, 20);
    d.integrator.max_depth = 2;
    add_rectangle(d, scaled(50), add_diffuse(d, 0.5f));
    add_point_light(d, {0, 0, 6}, 1);
    d.lights.back().motion = add_motion(d, {{0, {}}, {0.5, shift(0, 0, -5)}, {1, {}}});
    expose(d, 0, 1, ramp);
    return d;
  };
  // The mean of still images, weighted by the open area
  const auto expected = [&](double ramp) {
    constexpr int kParts = 64;
    double sum = 0, weights = 0;
    for (int i = 0; i < kParts; ++i) {
      const double time = (i + 0.5) / kParts, edge = std::min(time, 1 - time);
      const double weight = edge < ramp ? edge / ramp : 1;
      Description at = still(scene(0), time);
      at.sampler.sample_count = 16;
      sum += weight * mean_of(render(*compile_scene(at), {}).to_image());
      weights += weight;
    }
    return sum / weights;
  };
  const double flat = expected(0);
  const double level = significance_of_each(6);
  for (const float ramp : {0.25f, 0.5f}) {
    CAPTURE(ramp);
    const double mean = expected(double(ramp));
    CHECK(mean > 1.2 * flat);
    for (const IntegratorKind kind :
         {IntegratorKind::kPath, IntegratorKind::kLightTracer, IntegratorKind::kPhotonMapper}) {
      CAPTURE(static_cast<int>(kind));
      Description d = scene(ramp);
      const bool gathers = kind == IntegratorKind::kPhotonMapper;
      if (gathers) {
        d.sampler.sample_count = 16;
        d.integrator.photons.global = {50'000, 0.2f, 0};
      }
      // Photon maps blur over their radius
      check_mean(image_means(d, kind), mean, level, (gathers ? 0.03 : 2e-3) * mean);
    }
  }
}

}  // namespace sheaf::test_moving_lamps
