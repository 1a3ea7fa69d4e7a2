// Tabulated motions: their accuracy at all scales of the scene, of the motion and of the camera, keys between steps,
// and the agreement of instances with their lights.
#include "scene/compile/compile.h"
#include "scene/compile/key_times.h"
#include "scene/lights/list.h"
#include "scene/tables/motion_sample.h"
#include "tests/support/instancing_testing.h"
#include "tests/support/media_testing.h"
#include "tests/support/motion_testing.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace sheaf::test_motion_steps {

namespace {

constexpr float kScales[] = {1e-5f, 1e-3f, 1, 1e3f, 1e6f};
constexpr int kTimes = 200;  ///< at which motions are compared

Transform shift(float x, float y = 0, float z = 0) { return Transform::translate({x, y, z}); }
Transform scaled(float by) { return Transform::scale({by, by, by}); }

using Point = std::array<double, 3>;

/// The image of a point, in double precision.
Point image_of(const Transform& transform, const Point& p) {
  const auto& m = transform.matrix().m;
  Point out;
  for (std::size_t i = 0; i < 3; ++i) out[i] = m[i][0] * p[0] + m[i][1] * p[1] + m[i][2] * p[2] + m[i][3];
  return out;
}
Point to_point(Vec3f p) { return {p.x, p.y, p.z}; }
double distance(const Point& a, const Point& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

/// Where a motion takes a point at a time in [0, 1]. Objects without steps stand still.
Vec3f moved(const Scene& scene, const MotionRow* rows, std::uint32_t index, Vec3f p, float time) {
  if (rows == nullptr || rows[index].segment_count == 0) return p;
  return sample_motion<Scalar>(scene.view().motion, rows[index], time).placed.point(p);
}

/// The largest error of a motion over the shutter, and the length of the motion.
struct Errors {
  double error = 0, length = 0;
};
template <class Found, class Exact> Errors compare(Found&& found, Exact&& exact) {
  Errors out;
  const Point first = exact(0.0);
  for (int i = 0; i <= kTimes; ++i) {
    const double time = double(i) / kTimes;
    const Point at = exact(time);
    out.error = std::max(out.error, distance(to_point(found(static_cast<float>(time))), at));
    out.length = std::max(out.length, distance(at, first));
  }
  return out;
}

/// There and back along an arc, with a key between most numbers of steps.
MotionKeys arc(float size) {
  const auto at = [size](double angle) {
    return shift(size) * Transform::rotate({0, 0, 1}, angle) * shift(-size, 0.3f * size);
  };
  return {{0, at(0)}, {0.4, at(70)}, {1, at(-15)}};
}

}  // namespace

TEST_CASE("motion steps: lights at a point follow motions of any length in scenes of any size") {
  for (const float scene_size : kScales)
    for (const float length : kScales) {
      CAPTURE(scene_size);
      CAPTURE(length);
      Description d = empty_scene(4, 4);
      add_rectangle(d, scaled(scene_size), add_diffuse(d, 0.5f));
      add_point_light(d, {0, 0.3f * length, 0}, 1);
      d.lights.back().motion = add_motion(d, arc(length));
      expose(d, 0, 1);
      const AnimatedTransform motion = d.motions.back();
      const auto scene = compile_scene(d);
      const Vec3f p{0, 0.3f * length, 0};
      const Transform from_rest = motion.reference().inverse();
      const Errors errors = compare([&](float t) { return moved(*scene, scene->view().motion.lights, 0, p, t); },
                                    [&](double t) { return image_of(motion.at(t) * from_rest, to_point(p)); });
      CHECK(errors.length > 0.5 * double(length));
      CHECK(errors.error < 2e-4 * errors.length);
    }
}

TEST_CASE("motion steps: directions of lights do not depend on the size of the scene") {
  for (const float scene_size : kScales) {
    CAPTURE(scene_size);
    Description d = empty_scene(4, 4);
    add_rectangle(d, scaled(scene_size), add_diffuse(d, 0.5f));
    d.lights.push_back({DirectionalLightDescription{{0, 0, -1}}, {}});
    d.lights.back().motion =
        add_motion(d, {{0, {}}, {0.3, Transform::rotate({1, 0, 0}, 40)}, {1, Transform::rotate({0, 1, 0}, 1)}});
    expose(d, 0, 1);
    const AnimatedTransform motion = d.motions.back();
    const auto scene = compile_scene(d);
    const MotionView view = scene->view().motion;
    REQUIRE(view.lights != nullptr);
    const Errors errors = compare(
        [&](float t) {
          return sample_motion<Scalar>(view, view.lights[0], t).placed.vector({0, 0, -1});
        },
        [&](double t) {
          return to_point(motion.at(t).vector({0, 0, -1}));
        });
    CHECK(errors.error < 2e-4);
  }
}

TEST_CASE("motion steps: cameras follow motions of any length in scenes of any size") {
  for (const float scene_size : kScales)
    for (const float length : kScales) {
      CAPTURE(scene_size);
      CAPTURE(length);
      Description d = empty_scene(4, 4);
      add_rectangle(d, scaled(scene_size), add_diffuse(d, 0.5f));
      d.camera.motion = add_motion(d, arc(length));
      d.camera.near_clip = 1e-3f * length;
      expose(d, 0, 1);
      const AnimatedTransform motion = d.motions.back();
      const auto scene = compile_scene(d);
      const Vec3f p = motion.at(0).point({0, 0, 0});
      const Transform from_rest = motion.at(0).inverse();
      const Errors errors = compare([&](float t) { return moved(*scene, scene->view().motion.cameras, 0, p, t); },
                                    [&](double t) { return image_of(motion.at(t) * from_rest, to_point(p)); });
      CHECK(errors.length > 0.5 * double(length));
      CHECK(errors.error < 2e-4 * errors.length);
    }
}

TEST_CASE("motion steps: objects of any size follow motions of any length, in groups of any unit") {
  for (const float object : kScales)
    for (const float length : kScales)
      for (const float unit : {1e-3f, 1.0f, 1e3f}) {
        if (object > 1e3f * length) continue;  // beyond single precision
        CAPTURE(object);
        CAPTURE(length);
        CAPTURE(unit);
        Description d = empty_scene(4, 4);
        ShapeDescription part;
        part.geometry = RectangleShape{};
        part.to_world = scaled(object / unit);
        d.groups.push_back({{part}, {}, {}});
        InstanceDescription instance;
        MotionKeys keys = arc(length);
        for (AnimatedTransform::Key& key : keys) key.value = key.value * scaled(unit);
        instance.motion = add_motion(d, keys);
        d.instances.push_back(instance);
        expose(d, 0, 1);
        const AnimatedTransform motion = d.motions.back();
        const auto scene = compile_scene(d);
        for (const Vec3f corner : {Vec3f{-1, -1, 0}, Vec3f{1, 1, 0}}) {
          const Vec3f p = corner * (object / unit);
          const Errors errors = compare([&](float t) { return moved(*scene, scene->view().motion.instances, 0, p, t); },
                                        [&](double t) { return image_of(motion.at(t), to_point(p)); });
          // Rounding in single precision
          const double rounding = 1e-6 * (double(object) + double(length));
          CHECK(errors.error < 2e-4 * errors.length + rounding);
          // Long motions may need more steps than there can be
          if (length <= object) CHECK(errors.error < 3e-4 * double(object) + rounding);
        }
      }
}

TEST_CASE("motion steps: small objects on long ways are accurate relative to their size in the world") {
  for (const float unit : {1e-3f, 1.0f, 1e3f}) {
    CAPTURE(unit);
    Description d = empty_scene(4, 4);
    ShapeDescription part;
    part.geometry = RectangleShape{};
    constexpr float kHalf = 0.005f;
    part.to_world = scaled(kHalf / unit);
    d.groups.push_back({{part}, {}, {}});
    InstanceDescription instance;
    const auto at = [unit](double angle) { return Transform::rotate({0, 0, 1}, angle) * shift(1) * scaled(unit); };
    instance.motion = add_motion(d, {{0, at(0)}, {1, at(20)}});
    d.instances.push_back(instance);
    expose(d, 0, 1);
    const AnimatedTransform motion = d.motions.back();
    const auto scene = compile_scene(d);
    const Vec3f p{kHalf / unit, kHalf / unit, 0};
    const Errors errors = compare([&](float t) { return moved(*scene, scene->view().motion.instances, 0, p, t); },
                                  [&](double t) { return image_of(motion.at(t), to_point(p)); });
    CHECK(errors.length > 0.3);
    CHECK(errors.error < 1.5e-4 * 2 * std::sqrt(2.0) * double(kHalf));
  }
}

TEST_CASE("motion steps: keys between steps are kept") {
  // Each motion has a short excursion around a time
  for (const double time : {0.5, 0.25 + 1.0 / 64, 0.3, 1.0 / 3, 0.77}) {
    CAPTURE(time);
    Description d = empty_scene(4, 4);
    add_rectangle(d, scaled(1000), add_diffuse(d, 0.5f));
    add_point_light(d, {0, 0, 0}, 1);
    d.lights.back().motion =
        add_motion(d, {{0, {}}, {time - 0.015625, {}}, {time, shift(1)}, {time + 0.015625, {}}, {1, {}}});
    expose(d, 0, 1);
    const auto scene = compile_scene(d);
    CHECK(double(moved(*scene, scene->view().motion.lights, 0, {0, 0, 0}, static_cast<float>(time)).x) == near(1, 0.1));
  }
  // Keys at multiples of a part of the interval are exact
  for (const int parts : {2, 3, 7, 50, 128}) {
    CAPTURE(parts);
    Description d = empty_scene(4, 4);
    add_rectangle(d, {}, add_diffuse(d, 0.5f));
    add_point_light(d, {0, 0, 0}, 1);
    MotionKeys keys;
    for (int i = 0; i <= parts; ++i) keys.push_back({double(i) / parts, shift(static_cast<float>(i * i % 5))});
    d.lights.back().motion = add_motion(d, keys);
    expose(d, 0, 1);
    const auto scene = compile_scene(d);
    for (int i = 0; i <= parts; ++i)
      CHECK(double(moved(*scene, scene->view().motion.lights, 0, {0, 0, 0},
                         static_cast<float>(i) / static_cast<float>(parts))
                       .x) == within(i * i % 5, 1e-4));
  }
}

TEST_CASE("motion steps: lights of moving instances are where the instances are") {
  // Tables of lights place each by the first key; both then follow their own steps
  for (const float unit : {1e-3f, 1.0f, 1e3f})
    for (const bool still_lamp : {true, false}) {
      CAPTURE(unit);
      CAPTURE(still_lamp);
      Description d = empty_scene(4, 4);
      ShapeDescription lamp;
      lamp.geometry = RectangleShape{};
      lamp.to_world = shift(0.2f, 0, 3) * scaled(0.5f);
      emit(lamp, 1);
      d.groups.push_back({{lamp}, {}, {}});
      InstanceDescription instance;
      MotionKeys keys = arc(1);
      for (AnimatedTransform::Key& key : keys)
        key.value = key.value * Transform::rotate({1, 2, 3}, 40 * key.time) * scaled(unit);
      if (still_lamp) keys.resize(2);
      instance.motion = add_motion(d, keys);
      d.instances.push_back(instance);
      expose(d, 0, 1);
      const Transform rest = d.motions.back().reference();
      const auto scene = compile_scene(d);
      const MotionView view = scene->view().motion;
      REQUIRE(view.instances != nullptr);
      REQUIRE(view.lights != nullptr);
      CHECK(view.instances[0].segment_count == view.lights[0].segment_count);
      for (int i = 0; i <= kTimes; ++i) {
        const float time = static_cast<float>(i) / kTimes;
        for (const Vec3f p : {Vec3f{-0.3f, -0.5f, 3}, Vec3f{0.7f, 0.5f, 3}}) {
          const Vec3f a = moved(*scene, view.instances, 0, p, time);
          const Vec3f b = moved(*scene, view.lights, 0, rest.point(p), time);
          // Rounding in single precision of positions up to 1 + 4 units
          CHECK(double(length(a - b)) < 1e-6 * (1 + 4 * double(unit)));
        }
      }
    }
}

TEST_CASE("motion steps: the parts of the shutter hit all keys, or come close to them") {
  const ShutterDescription shutter{2, 4, 0};
  CHECK(segments_of_keys({0, 9}, shutter) == 1);
  CHECK(segments_of_keys({2, 3, 4}, shutter) == 2);
  CHECK(segments_of_keys({1, 2 + 2.0 / 3, 3.5, 7}, shutter) == 12);
  CHECK(segments_of_keys({2 + 2.0 / 128, 3}, shutter) == 128);
  // No multiple of a part of at least 1/128
  const double key = 0.3 + 1e-4, other = 0.777;
  const int parts = segments_of_keys({2 + 2 * key, 2 + 2 * other}, shutter);
  for (const double at : {key * parts, other * parts}) CHECK(std::fabs(at - std::round(at)) / parts <= 1e-3);
}

TEST_CASE("motion steps: grids that move differently are found at all scales") {
  const TemporaryFolder folder;
  const auto file = write_vol(folder / "half.vol", 2, 1, [](Vec3f, int) { return 0.5f; });
  for (const float size : kScales)
    for (const bool alike : {true, false}) {
      CAPTURE(size);
      CAPTURE(alike);
      Description d = empty_scene(4, 4);
      const auto grid = [&](float direction) {
        GridVolumeDescription out = vol(file, shift(-0.5f * size, 0, 0) * scaled(size));
        out.motion = add_motion(d, {{0, out.to_world}, {1, shift(direction * size) * out.to_world}});
        return out;
      };
      MediumDescription m;
      m.coefficients = ExtinctionAlbedoDescription{grid(1), grid(alike ? 1 : 1.1f)};
      fill(d, add_sphere(d, {0, 0, 0}, size), add_medium(d, m));
      expose(d, 0, 1);
      if (alike)
        CHECK_NOTHROW(compile_scene(d));
      else
        CHECK_THROWS_AS(compile_scene(d), SceneError);
    }
}

}  // namespace sheaf::test_motion_steps
