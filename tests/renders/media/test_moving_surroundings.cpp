// Media around cameras and around other media that change while the shutter is open: closed forms, agreement of path
// tracing and light tracing, and the tables of the compiler.
#include "scene/formats/mesh.h"
#include "tests/support/instancing_testing.h"
#include "tests/support/light_tracing_testing.h"
#include "tests/support/media_testing.h"
#include "tests/support/motion_testing.h"
#include "tests/support/near.h"
#include "tests/support/render_testing.h"

namespace sheaf::test_moving_surroundings {

namespace {

constexpr double kAllowed = 2e-4;  ///< of the tabulated transforms

Transform shift(float x, float y = 0, float z = 0) { return Transform::translate({x, y, z}); }
Transform scaled(float by) { return Transform::scale({by, by, by}); }

/// A camera at the origin that looks along +z to a wall of radiance 1.
Description wall_ahead() {
  Description d = one_point_scene(64);
  look_at_point(d, {0, 0, 0}, {0, 0, 1}, {0, 1, 0});
  d.camera.near_clip = 1e-5f;
  d.integrator.max_depth = -1;
  emit(add_rectangle(d, shift(0, 0, 9) * Transform::rotate({0, 1, 0}, 180) * scaled(9)), 1);
  return d;
}

/// A cube of an absorbing medium with half the side `half`.
ShapeDescription& absorbing_cube(Description& d, float half, float sigma) {
  ShapeDescription& cube = add_shape(d, CubeShape{}, scaled(half));
  return fill(d, cube, add_medium(d, fog(sigma, 0)));
}

MeanVariance green(const Description& d) { return pixel_means(d)[1]; }

/// Camera 0's media over the shutter.
std::vector<CameraMediumRow> camera_media(const Description& d) {
  const auto scene = compile_scene(d);
  const MediumView& media = scene->view().media;
  return {media.camera_media, media.camera_media + media.camera_medium_count};
}

}  // namespace

TEST_CASE("moving surroundings: a medium that passes over the camera attenuates while the camera is inside") {
  const double level = significance_of_each(4);
  const double inside = std::exp(-0.5);
  const struct {
    const char* name;
    MotionKeys keys;  ///< of a cube with sides of 2
    double fraction;  ///< of the time that the camera is inside
  } kMotions[] = {{"from outside to inside", {{0, shift(-1.6f)}, {1, shift(0.4f)}}, 0.7},
                  {"from inside to outside", {{0, shift(0.4f)}, {1, shift(2.4f)}}, 0.3},
                  {"past", {{0, shift(-2.5f)}, {1, shift(2.5f)}}, 0.4},
                  {"there and back", {{0, {}}, {0.5, shift(4)}, {1, {}}}, 0.25}};
  for (const auto& motion : kMotions) {
    CAPTURE(motion.name);
    Description d = wall_ahead();
    move(d, absorbing_cube(d, 1, 0.5f), motion.keys);
    expose(d, 0, 1);
    check_mean(green(d), motion.fraction * inside + 1 - motion.fraction, level, kAllowed);
  }
}

TEST_CASE("moving surroundings: a camera that moves is in the medium that is there") {
  Description d = wall_ahead();
  absorbing_cube(d, 1, 0.5f);
  const Transform at = d.camera.to_world;
  d.camera.motion = add_motion(d, {{0, shift(-2.6f) * at}, {1, shift(1.4f) * at}});
  d.camera.to_world = d.motions.back().reference();
  expose(d, 0, 1);
  // Inside from 0.4 to 0.9
  check_mean(green(d), 0.5 * std::exp(-0.5) + 0.5, kSignificance, kAllowed);
  const std::vector<CameraMediumRow> media = camera_media(d);
  REQUIRE(media.size() == 3);
  CHECK(double(media[1].time) == near(0.4, 1e-4));
  CHECK(double(media[2].time) == near(0.9, 1e-4));
  CHECK(media[0].medium == 0);
  CHECK(media[1].medium == 1);
  CHECK(media[2].medium == 0);
}

TEST_CASE("moving surroundings: a medium in a mesh that deforms reaches the camera") {
  Description d = wall_ahead();
  Mesh small = cube_mesh(), large = small;
  for (Vec3f& p : small.positions) p = p * 0.5f + Vec3f{0, 0, 1};
  for (Vec3f& p : large.positions) p = p * 1.5f + Vec3f{0, 0, 1};
  constexpr double kSigma = 0.7;
  fill(d, add_shape(d, DeformingMesh{{{0, small}, {1, large}}}, {}), add_medium(d, fog(static_cast<float>(kSigma), 0)));
  expose(d, 0, 1);
  // The cube is in front of the camera until half its side is 1
  const auto integral = [&](double rate, double from, double to) {
    return (std::exp(-rate * from) - std::exp(-rate * to)) / rate;
  };
  const double expected = integral(2 * kSigma, 0.5, 1) + std::exp(-kSigma) * integral(kSigma, 1, 1.5);
  check_mean(green(d), expected, kSignificance, kAllowed);
}

TEST_CASE("moving surroundings: cameras and media that stand still have one medium") {
  Description d = wall_ahead();
  absorbing_cube(d, 1, 0.5f);
  // Something else moves
  move(d, add_rectangle(d, shift(0, 5)), {{0, shift(0, 5)}, {1, shift(1, 5)}});
  expose(d, 0, 1);
  CHECK(camera_media(d).empty());
  CHECK(compile_scene(d)->view().media.camera_medium == 1);
  // A named medium stays
  move(d, d.shapes[1], {{0, scaled(1)}, {1, shift(5)}});
  CHECK(camera_media(d).size() == 2);
  d.camera.medium = MediumId{0};
  CHECK(camera_media(d).empty());
}

TEST_CASE("moving surroundings: each camera of a batch is in its own medium") {
  Description d = wall_ahead();
  absorbing_cube(d, 1, 0.5f);
  d.more_cameras.push_back(d.camera);
  d.more_cameras[0].to_world = shift(3) * d.camera.to_world;
  const Image image = render(*compile_scene(d), {}).to_image();
  MeanVariance left, right;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) (x < image.width / 2 ? left : right).add(image.at(x, y, 1));
  check_mean(left, std::exp(-0.5), kSignificance, kAllowed);
  check_mean(right, 1, kSignificance, kAllowed);
}

TEST_CASE("moving surroundings: light tracing and path tracing agree where a medium passes over the camera") {
  Description d = empty_scene(16, 16);
  d.sampler.sample_count = 256;
  look_at(d, {0, -6, 3}, {0, 0, 0.5f}, {0, 0, 1}, 45);
  d.integrator.max_depth = 4;
  add_rectangle(d, scaled(4), add_diffuse(d, 0.6f));
  emit(add_rectangle(d, shift(0.5f, 0, 3) * Transform::rotate({1, 0, 0}, 180)), 8);
  MediumDescription smoke = fog(0.6f, 0.7f);
  ShapeDescription& ball = fill(d, add_sphere(d, {0, 0, 0}, 1.5f), add_medium(d, smoke));
  move(d, ball, {{0, shift(-3, -6, 3)}, {1, shift(0.5f, -6, 3)}});
  expose(d, 0, 1);
  check_light_tracing_agrees(d);
}

TEST_CASE("moving surroundings: a medium that enters another one is left into it from then on") {
  // A plate across the view is in front of the outer cube, then inside of it
  Description d = wall_ahead();
  constexpr double kOuter = 0.8, kInner = 0.2;
  ShapeDescription& cube = absorbing_cube(d, 1, static_cast<float>(kOuter));
  cube.to_world = shift(0, 0, 5);
  ShapeDescription& plate = absorbing_cube(d, 1, static_cast<float>(kInner));
  plate.exterior_is_surrounding = true;
  const auto at = [](float z) { return shift(0, 0, z) * Transform::scale({0.9f, 0.9f, 0.25f}); };
  // The times of the keys are those of steps
  move(d, plate, {{0, at(2)}, {0.5, at(2)}, {0.5 + 1.0 / 128, at(5)}, {1, at(5)}});
  expose(d, 0, 1);
  const double before = std::exp(-2 * kOuter - 0.5 * kInner), after = std::exp(-1.5 * kOuter - 0.5 * kInner);
  check_mean(green(d), 0.5 * (before + after), kSignificance, (after - before) / 128);
}

TEST_CASE("moving surroundings: instances of one medium are in different media") {
  Description d = wall_ahead();
  constexpr double kOuter = 0.8, kInner = 0.2;
  absorbing_cube(d, 1, static_cast<float>(kOuter)).to_world = shift(0, 0, 5);
  ShapeDescription part;
  part.geometry = CubeShape{};
  part.to_world = Transform::scale({0.9f, 0.9f, 0.25f});
  fill(d, part, add_medium(d, fog(static_cast<float>(kInner), 0)));
  part.exterior_is_surrounding = true;
  d.groups.push_back({{part}, {}, {}});
  for (const float z : {2.0f, 5.0f}) add_instance(d, 0, shift(0, 0, z));
  check_mean(green(d), std::exp(-1.5 * kOuter - 2 * 0.5 * kInner), kSignificance, kAllowed);
}

TEST_CASE("moving surroundings: photons start in the medium around a shape at their time") {
  // A plate enters the medium around a lamp, below the lamp
  Description d = empty_scene(16, 16);
  d.sampler.sample_count = 64;
  look_at(d, {0, -5, 1}, {0, 0, 0}, {0, 0, 1}, 45);
  d.integrator.max_depth = 3;
  add_rectangle(d, scaled(4), add_diffuse(d, 0.6f));
  add_point_light(d, {0, 0, 2}, 9);
  absorbing_cube(d, 1.4f, 1).to_world = shift(0, 0, 2) * scaled(1.4f);
  ShapeDescription& plate = absorbing_cube(d, 1, 0.1f);
  plate.exterior_is_surrounding = true;
  const auto at = [](float x) { return shift(x, 0, 1.2f) * Transform::scale({1.2f, 1.2f, 0.3f}); };
  move(d, plate, {{0, at(20)}, {0.5, at(20)}, {0.5 + 1.0 / 128, at(0)}, {1, at(0)}});
  expose(d, 0, 1);
  check_light_tracing_agrees(d);
  // The mean of still images before and after
  const auto mean = [&](double open, double close) {
    Description e = d;
    expose(e, open, close);
    MeanVariance out;
    for (std::uint32_t seed = 0; seed < 8; ++seed) {
      e.sampler.seed = seed;
      const Image image = render(*compile_scene(e), {}).to_image();
      double sum = 0;
      for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) sum += double(image.at(x, y, 1));
      out.add(sum / (image.width * image.height));
    }
    return out.mean();
  };
  const double before = mean(0.2, 0.2), after = mean(0.8, 0.8);
  CHECK(after > 1.2 * before);
  CHECK(mean(0, 1) == near(0.5 * (before + after), 0.02));
}

}  // namespace sheaf::test_moving_surroundings
