// The pinhole camera: what fields of view mean, and where up and left are.
#include "scene/camera.h"

#include "tests/records_testing.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

namespace sheaf {

namespace {

using Axis = CameraDescription::FovAxis;

CameraDescription camera_with(float fov, Axis axis) {
  CameraDescription d;
  d.fov = fov;
  d.fov_axis = axis;
  return d;
}

double angle_between(Vec3f a, Vec3f b) {
  return std::atan2(double(length(cross(a, b))), double(dot(a, b))) * 180 / 3.14159265358979;
}

/// Angles in degrees across a frame through its centre.
struct Fields {
  double x, y, diagonal;
};
Fields fields_of_view(const CameraDescription& d, int width, int height) {
  const Camera camera = make_camera(d, width, height);
  const auto w = static_cast<float>(width), h = static_cast<float>(height);
  const auto at = [&](float x, float y) { return camera.direction<Scalar>(x, y); };
  return {angle_between(at(0, h / 2), at(w, h / 2)), angle_between(at(w / 2, 0), at(w / 2, h)),
          angle_between(at(0, 0), at(w, h))};
}

void check_vector(Vec3f found, Vec3f expected) {
  CAPTURE(found.x);
  CAPTURE(found.y);
  CAPTURE(found.z);
  CHECK(record_difference<Vec3>(found, expected) < 1e-6);
}

}  // namespace

TEST_CASE("camera: the field of view spans the axis it is given for") {
  for (const float fov : {20.0f, 60.0f, 120.0f}) {
    CHECK(fields_of_view(camera_with(fov, Axis::kX), 300, 200).x == doctest::Approx(fov).epsilon(1e-4));
    CHECK(fields_of_view(camera_with(fov, Axis::kY), 300, 200).y == doctest::Approx(fov).epsilon(1e-4));
    CHECK(fields_of_view(camera_with(fov, Axis::kDiagonal), 300, 200).diagonal == doctest::Approx(fov).epsilon(1e-4));
    CHECK(fields_of_view(camera_with(fov, Axis::kSmaller), 300, 200).y == doctest::Approx(fov).epsilon(1e-4));
    CHECK(fields_of_view(camera_with(fov, Axis::kSmaller), 200, 300).x == doctest::Approx(fov).epsilon(1e-4));
    CHECK(fields_of_view(camera_with(fov, Axis::kLarger), 300, 200).x == doctest::Approx(fov).epsilon(1e-4));
    CHECK(fields_of_view(camera_with(fov, Axis::kLarger), 200, 300).y == doctest::Approx(fov).epsilon(1e-4));
  }
}

TEST_CASE("camera: pixels are square whatever the axis") {
  for (const Axis axis : {Axis::kX, Axis::kY, Axis::kDiagonal, Axis::kSmaller, Axis::kLarger})
    for (const int height : {100, 200, 400}) {
      const Camera camera = make_camera(camera_with(50, axis), 200, height);
      CHECK(length(camera.dx) == doctest::Approx(length(camera.dy)).epsilon(1e-5));
      CHECK(std::fabs(dot(camera.dx, camera.dy)) < 1e-9f);
    }
}

TEST_CASE("camera: camera space looks along +z with +y up and +x to the left") {
  const Camera camera = make_camera(camera_with(90, Axis::kX), 200, 100);
  check_vector(camera.origin, {0, 0, 0});
  check_vector(camera.direction<Scalar>(100, 50), {0, 0, 1});
  const float r = std::sqrt(0.5f);
  check_vector(camera.direction<Scalar>(0, 50), {r, 0, r});
  check_vector(camera.direction<Scalar>(200, 50), {-r, 0, r});
  check_vector(camera.direction<Scalar>(100, 0), normalize(Vec3f{0, 0.5f, 1}));
  check_vector(camera.direction<Scalar>(100, 100), normalize(Vec3f{0, -0.5f, 1}));
}

TEST_CASE("camera: a moved camera looks at its target with its up direction up") {
  const Vec3f origin{1, 2, 3}, target{-2, 5, 4}, up{0, 0, 1};
  CameraDescription d = camera_with(40, Axis::kX);
  d.to_world = Transform::look_at(origin, target, up);
  const Camera camera = make_camera(d, 64, 64);
  check_vector(camera.origin, origin);
  const Vec3f forward = normalize(target - origin);
  check_vector(camera.direction<Scalar>(32, 32), forward);
  const Vec3f top = camera.direction<Scalar>(32, 0) - camera.direction<Scalar>(32, 64);
  CHECK(dot(top, up) > 0.0f);
  const Vec3f right = camera.direction<Scalar>(64, 32) - camera.direction<Scalar>(0, 32);
  CHECK(dot(right, normalize(cross(forward, up))) == doctest::Approx(length(right)).epsilon(1e-5));
}

TEST_CASE("camera: scaling a camera widens no picture and leaves directions of unit length") {
  CameraDescription d = camera_with(70, Axis::kX);
  d.to_world = Transform::translate({1, 0, 0}) * Transform::scale({5, 5, 5});
  const Camera scaled = make_camera(d, 32, 16), plain = make_camera(camera_with(70, Axis::kX), 32, 16);
  for (const float x : {0.0f, 7.5f, 32.0f}) {
    check_vector(scaled.direction<Scalar>(x, 3), plain.direction<Scalar>(x, 3));
    CHECK(length(scaled.direction<Scalar>(x, 3)) == doctest::Approx(1).epsilon(1e-6));
  }
  d.to_world = Transform::scale({-1, 1, 1});
  check_vector(make_camera(d, 32, 16).direction<Scalar>(3, 5), plain.direction<Scalar>(29, 5));
}

TEST_CASE("camera: fields of view outside of (0, 180) are refused") {
  for (const float fov : {0.0f, -10.0f, 180.0f, 400.0f, std::numeric_limits<float>::quiet_NaN(), kInfinity})
    CHECK_THROWS_AS(make_camera(camera_with(fov, Axis::kX), 10, 10), SceneError);
}

TEST_CASE("camera: registers equal single values") {
  CameraDescription d = camera_with(70, Axis::kDiagonal);
  d.to_world = Transform::look_at({3, -1, 2}, {0, 1, 0}, {0, 1, 0});
  const Camera camera = make_camera(d, 640, 480);
  double worst = 0;
  for (std::uint32_t i = 0; i < 1024; i += kWidth) {
    const auto u = wide_random(6, i);
    const auto wide = camera.direction<Wide>(u.x * WideFloat(640.0f), u.y * WideFloat(480.0f));
    for (int lane = 0; lane < kWidth; ++lane)
      worst = std::max(worst, record_difference<Vec3>(lane_record(wide, lane),
                                                      camera.direction<Scalar>(u.x[lane] * 640.0f, u.y[lane] * 480.0f)));
  }
  CHECK(worst < 1e-6);
}

}  // namespace sheaf
