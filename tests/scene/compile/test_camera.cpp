// Cameras: fields of view, orientation, lenses, orthographic rays, clip planes, meters.
#include "scene/compile/compile_camera.h"

#include "tests/support/near.h"
#include "tests/support/records_testing.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

namespace sheaf::test_camera {

namespace {

using Axis = CameraDescription::FovAxis;

CameraDescription camera_with(float fov, Axis axis) {
  CameraDescription d;
  d.fov = fov;
  d.fov_axis = axis;
  return d;
}

Vec3f direction(const Camera& camera, float x, float y) { return camera.ray<Scalar>(x, y, 0, 0).direction; }

double angle_between(Vec3f a, Vec3f b) {
  return std::atan2(double(length(cross(a, b))), double(dot(a, b))) * 180 / 3.14159265358979;
}

/// Angles across the frame through its center, in degrees.
struct Fields {
  double x, y, diagonal;
};
Fields fields_of_view(const CameraDescription& d, int width, int height) {
  const Camera camera = make_camera(d, width, height);
  const auto w = static_cast<float>(width), h = static_cast<float>(height);
  const auto at = [&](float x, float y) { return direction(camera, x, y); };
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

TEST_CASE("camera: the field of view applies to the given axis") {
  for (const float fov : {20.0f, 60.0f, 120.0f}) {
    CHECK(fields_of_view(camera_with(fov, Axis::kX), 300, 200).x == near(fov, 1e-4));
    CHECK(fields_of_view(camera_with(fov, Axis::kY), 300, 200).y == near(fov, 1e-4));
    CHECK(fields_of_view(camera_with(fov, Axis::kDiagonal), 300, 200).diagonal == near(fov, 1e-4));
    CHECK(fields_of_view(camera_with(fov, Axis::kSmaller), 300, 200).y == near(fov, 1e-4));
    CHECK(fields_of_view(camera_with(fov, Axis::kSmaller), 200, 300).x == near(fov, 1e-4));
    CHECK(fields_of_view(camera_with(fov, Axis::kLarger), 300, 200).x == near(fov, 1e-4));
    CHECK(fields_of_view(camera_with(fov, Axis::kLarger), 200, 300).y == near(fov, 1e-4));
  }
}

TEST_CASE("camera: pixels are square for every axis of the field of view") {
  for (const Axis axis : {Axis::kX, Axis::kY, Axis::kDiagonal, Axis::kSmaller, Axis::kLarger})
    for (const int height : {100, 200, 400}) {
      const Camera camera = make_camera(camera_with(50, axis), 200, height);
      CHECK(length(camera.dx) == near(length(camera.dy), 1e-5));
      CHECK(std::fabs(dot(camera.dx, camera.dy)) < 1e-9f);
    }
}

TEST_CASE("camera: camera space looks along +z with +y up and +x to the left") {
  const Camera camera = make_camera(camera_with(90, Axis::kX), 200, 100);
  check_vector(camera.origin, {0, 0, 0});
  check_vector(direction(camera, 100, 50), {0, 0, 1});
  const float r = std::sqrt(0.5f);
  check_vector(direction(camera, 0, 50), {r, 0, r});
  check_vector(direction(camera, 200, 50), {-r, 0, r});
  check_vector(direction(camera, 100, 0), normalize(Vec3f{0, 0.5f, 1}));
  check_vector(direction(camera, 100, 100), normalize(Vec3f{0, -0.5f, 1}));
}

TEST_CASE("camera: a moved camera faces its target with the given up vector") {
  const Vec3f origin{1, 2, 3}, target{-2, 5, 4}, up{0, 0, 1};
  CameraDescription d = camera_with(40, Axis::kX);
  d.to_world = Transform::look_at(origin, target, up);
  const Camera camera = make_camera(d, 64, 64);
  check_vector(camera.origin, origin);
  const Vec3f forward = normalize(target - origin);
  check_vector(direction(camera, 32, 32), forward);
  const Vec3f top = direction(camera, 32, 0) - direction(camera, 32, 64);
  CHECK(dot(top, up) > 0.0f);
  const Vec3f right = direction(camera, 64, 32) - direction(camera, 0, 32);
  CHECK(dot(right, normalize(cross(forward, up))) == near(length(right), 1e-5));
}

TEST_CASE("camera: scaling a camera keeps its field of view and gives unit directions") {
  CameraDescription d = camera_with(70, Axis::kX);
  d.to_world = Transform::translate({1, 0, 0}) * Transform::scale({5, 5, 5});
  const Camera scaled = make_camera(d, 32, 16), plain = make_camera(camera_with(70, Axis::kX), 32, 16);
  for (const float x : {0.0f, 7.5f, 32.0f}) {
    check_vector(direction(scaled, x, 3), direction(plain, x, 3));
    CHECK(length(direction(scaled, x, 3)) == near(1, 1e-6));
  }
  d.to_world = Transform::scale({-1, 1, 1});
  check_vector(direction(make_camera(d, 32, 16), 3, 5), direction(plain, 29, 5));
}

TEST_CASE("camera: fields of view that are not between 0 and 180 degrees are rejected") {
  for (const float fov : {0.0f, -10.0f, 180.0f, 400.0f, std::numeric_limits<float>::quiet_NaN(), kInfinity})
    CHECK_THROWS_AS(make_camera(camera_with(fov, Axis::kX), 10, 10), SceneError);
}

TEST_CASE("camera: principal points shift the image by fractions of its size to the left and upwards") {
  CameraDescription d = camera_with(40, Axis::kX);
  d.principal_point_x = 0.1f;
  d.principal_point_y = -0.2f;
  const Camera shifted = make_camera(d, 200, 100), plain = make_camera(camera_with(40, Axis::kX), 200, 100);
  for (const float x : {0.0f, 80.0f, 200.0f}) check_vector(direction(shifted, x, 30), direction(plain, x + 20, 10));
  check_vector(direction(shifted, 80, 70), {0, 0, 1});
}

TEST_CASE("camera: rays start at the near plane and end at the far plane") {
  for (const bool orthographic : {false, true}) {
    CameraDescription d = camera_with(70, Axis::kX);
    if (orthographic) d.projection = CameraDescription::Projection::kOrthographic;
    d.near_clip = 0.5f;
    d.far_clip = 20;
    d.aperture_radius = orthographic ? 0.0f : 0.2f;
    d.focus_distance = 3;
    const Vec3f eye{1, 2, 3}, target{4, 0, -1};
    d.to_world = Transform::look_at(eye, target, {0, 1, 0});
    const Vec3f forward = normalize(target - eye);
    const Camera camera = make_camera(d, 64, 48);
    for (const float x : {0.0f, 20.0f, 64.0f}) {
      const auto ray = camera.ray<Scalar>(x, 2 * x / 3, 0.6f, -0.7f);
      CHECK(dot(ray.origin - eye, forward) == near(0.5, 1e-5));
      CHECK(dot(ray.origin + ray.direction * ray.t_max - eye, forward) == near(20, 1e-5));
      CHECK(length(ray.direction) == near(1, 1e-6));
    }
  }
}

TEST_CASE("camera: clip planes scale with the camera") {
  CameraDescription d = camera_with(70, Axis::kX);
  d.near_clip = 1;
  d.far_clip = 3;
  d.to_world = Transform::scale({2, 2, 2});
  const auto ray = make_camera(d, 10, 10).ray<Scalar>(5, 5, 0, 0);
  check_vector(ray.origin, {0, 0, 2});
  CHECK(ray.t_max == near(4));
}

TEST_CASE("camera: a lens is sharp in its focal plane and blurs by similar triangles elsewhere") {
  CameraDescription d = camera_with(50, Axis::kY);
  d.aperture_radius = 0.25f;
  d.focus_distance = 4;
  const Camera lens = make_camera(d, 90, 60);
  REQUIRE(lens.has_lens());
  d.aperture_radius = 0;
  const Camera pinhole = make_camera(d, 90, 60);
  REQUIRE(!pinhole.has_lens());
  for (const float x : {0.0f, 33.0f, 90.0f})
    for (const float u : {-1.0f, 0.0f, 0.7f}) {
      const float v = 0.7f - std::fabs(u);
      const auto at = [&](const Camera& camera, float z) {
        const auto ray = camera.ray<Scalar>(x, 41, u, v);
        return ray.origin + ray.direction * ((z - ray.origin.z) / ray.direction.z);
      };
      check_vector(at(lens, 4), at(pinhole, 4));
      check_vector(at(lens, 0), {0.25f * u, 0.25f * v, 0});
      check_vector(at(lens, 2) - at(pinhole, 2), {0.125f * u, 0.125f * v, 0});
      check_vector(at(lens, 8) - at(pinhole, 8), {-0.25f * u, -0.25f * v, 0});
    }
}

TEST_CASE("camera: orthographic rays are parallel and span -1 to 1 across the width") {
  CameraDescription d;
  d.projection = CameraDescription::Projection::kOrthographic;
  d.fov = 0;  // has no effect here
  const Camera camera = make_camera(d, 200, 100);
  const auto at = [&](float x, float y) { return camera.ray<Scalar>(x, y, 0.3f, 0.4f); };
  check_vector(at(0, 0).origin, {1, 0.5f, 0});
  check_vector(at(200, 100).origin, {-1, -0.5f, 0});
  check_vector(at(50, 80).origin, {0.5f, -0.3f, 0});
  check_vector(at(13, 77).direction, {0, 0, 1});
  d.to_world = Transform::translate({0, 0, 7}) * Transform::rotate({0, 1, 0}, 90) * Transform::scale({3, 3, 1});
  const auto moved = make_camera(d, 100, 200).ray<Scalar>(0, 0, 0, 0);
  check_vector(moved.origin, {0, 6, 4});
  check_vector(moved.direction, {1, 0, 0});
}

TEST_CASE("camera: rays match Mitsuba 3") {
  // Origin, direction and length as Mitsuba 3 gives them for films of 200 x 100 pixels at (25 %, 80 %).
  struct Case {
    CameraDescription camera;
    Vec3f origin, direction;
    float t_max;
  };
  CameraDescription plain = camera_with(40, Axis::kX), shifted = plain, lens = plain, parallel = plain;
  plain.near_clip = 0.01f;
  plain.far_clip = 10'000;
  for (CameraDescription* d : {&shifted, &lens, &parallel}) {
    d->near_clip = 1;
    d->far_clip = 10;
  }
  shifted.principal_point_x = 0.1f;
  shifted.principal_point_y = -0.2f;
  lens.aperture_radius = 0.5f;
  lens.focus_distance = 5;
  parallel.projection = CameraDescription::Projection::kOrthographic;
  parallel.to_world = Transform::look_at({1, 2, 3}, {0, 0, 0}, {0, 1, 0}) * Transform::scale({2, 2, 1});
  const Case cases[] = {
      {plain, {0.00181985f, -0.00109191f, 0.01f}, {0.17802016f, -0.10681207f, 0.9782127f}, 10222.716f},
      {shifted, {0.10919108f, -0.03639701f, 1}, {0.10847494f, -0.0361583f, 0.99344134f}, 9.0594177f},
      {lens, {0.06198511f, 0.09865505f, 1}, {0.20484687f, -0.15572602f, 0.9663266f}, 9.3136215f},
      {parallel, {-0.11452614f, 0.95838517f, 2.8186998f}, {-0.26726127f, -0.53452253f, -0.8017838f}, 9},
  };
  const float lens_u = -0.3f, lens_v = 0.5196152f;
  for (const Case& c : cases) {
    const auto ray = make_camera(c.camera, 200, 100).ray<Scalar>(50, 80, lens_u, lens_v);
    CHECK(record_difference<Vec3>(ray.origin, c.origin) < 2e-6);
    CHECK(record_difference<Vec3>(ray.direction, c.direction) < 2e-6);
    CHECK(ray.t_max == near(c.t_max, 1e-5));
  }
}

TEST_CASE("camera: invalid clip distances and apertures and focus distances are rejected") {
  const auto make = [](auto&& change) {
    CameraDescription d;
    change(d);
    make_camera(d, 10, 10);
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  CHECK_NOTHROW(make([](CameraDescription&) {}));
  CHECK_THROWS_AS(make([](CameraDescription& d) { d.near_clip = -1; }), SceneError);
  CHECK_THROWS_AS(make([](CameraDescription& d) { d.near_clip = d.far_clip = 2; }), SceneError);
  CHECK_THROWS_AS(make([](CameraDescription& d) { d.far_clip = kNan; }), SceneError);
  CHECK_THROWS_AS(make([](CameraDescription& d) { d.aperture_radius = -1; }), SceneError);
  CHECK_THROWS_AS(make([](CameraDescription& d) { d.aperture_radius = kInfinity; }), SceneError);
  CHECK_THROWS_AS(make([](CameraDescription& d) { d.focus_distance = 0; }), SceneError);
  CHECK_THROWS_AS(make([](CameraDescription& d) { d.focus_distance = kNan; }), SceneError);
}

TEST_CASE("camera: spherical cameras map longitude and latitude to pixels and points back") {
  CameraDescription d;
  d.projection = CameraDescription::Projection::kSpherical;
  d.to_world = Transform::translate({1, 2, 3}) * Transform::scale({2, 2, 2});
  const Camera camera = make_camera(d, 200, 100);
  const auto at = [&](float x, float y) { return camera.ray<Scalar>(x, y, 0, 0); };
  CHECK(at(7, 9).origin == Vec3f{1, 2, 3});
  check_vector(at(100, 50).direction, {0, 0, 1});
  check_vector(at(0, 50).direction, {0, 0, -1});
  check_vector(at(50, 50).direction, {1, 0, 0});
  check_vector(at(50, 25).direction, normalize(Vec3f{1, 1, 0}));
  check_vector(at(33, 0).direction, {0, 1, 0});
  check_vector(at(33, 100).direction, {0, -1, 0});
  CHECK_FALSE(camera.has_lens());
  const auto ray = at(123.4f, 31.2f);
  const auto view = camera.view<Scalar>(ray.origin + ray.direction * 5, 0, 0);
  CHECK(view.valid);
  CHECK(view.film_x == near(123.4));
  CHECK(view.film_y == near(31.2));
  // Pixels per solid angle over the squared distance: 200 x 100 over 2 pi times pi.
  constexpr double kPiD = 3.14159265358979;
  CHECK(view.importance == near(200 * 100 / (2 * kPiD * kPiD * std::sin(0.312 * kPiD)) / 25));
  d.to_world = Transform::rotate({0, 0, 1}, 30) * Transform::scale({1, 3, 1}) * Transform::rotate({0, 0, 1}, 30);
  CHECK_THROWS_AS(make_camera(d, 200, 100), SceneError);
}

TEST_CASE("camera: radial distortion moves image points and is inverted for points in the scene") {
  CameraDescription d = camera_with(80, Axis::kX);
  d.to_world = Transform::look_at({3, -1, 2}, {0, 1, 0}, {0, 1, 0}) * Transform::scale({2, 2, 2});
  d.principal_point_x = 0.1f;
  const Camera plain = make_camera(d, 200, 150);
  const Vec3f axis = d.to_world.vector({0, 0, 0.5f});
  const auto tangent = [&](Vec3f direction) {
    return std::tan(angle_between(direction, axis) * 3.14159265358979 / 180);
  };
  for (const std::array<float, 2> kc : {std::array{0.3f, 0.1f}, std::array{-0.15f, 0.02f}}) {
    d.distortion = kc;
    const Camera camera = make_camera(d, 200, 150);
    for (const Vec2f film : {Vec2f{3, 5}, Vec2f{80, 75}, Vec2f{150, 20}, Vec2f{199, 149}}) {
      const Vec3f seen = direction(camera, film.x, film.y), displayed = direction(plain, film.x, film.y);
      const double r = tangent(seen);
      CHECK(r * (1 + double(kc[0]) * r * r + double(kc[1]) * r * r * r * r) == near(tangent(displayed), 1e-4));
      // Both lie in one plane with the axis, on the same side of it.
      CHECK(std::fabs(dot(cross(seen, displayed), axis)) < 1e-4f);
      const auto ray = camera.ray<Scalar>(film.x, film.y, 0, 0);
      const auto view = camera.view<Scalar>(ray.origin + ray.direction * 3, 0, 0);
      CHECK(view.valid);
      CHECK(view.film_x == near(film.x, 1e-3));
      CHECK(view.film_y == near(film.y, 1e-3));
      // Film area per solid angle, by finite differences.
      constexpr float kStep = 0.5f;
      const Vec3f dx = direction(camera, film.x + kStep, film.y) - direction(camera, film.x - kStep, film.y);
      const Vec3f dy = direction(camera, film.x, film.y + kStep) - direction(camera, film.x, film.y - kStep);
      CHECK(double(view.importance) * 9 == near(1 / double(length(cross(dx, dy))), 2e-3));
    }
  }
  d.distortion = {-0.6f, 0};
  CHECK_THROWS_AS(make_camera(d, 200, 150), SceneError);
}

TEST_CASE("camera: radiance and distant and irradiance meters sample the expected rays") {
  using Projection = CameraDescription::Projection;
  CameraDescription d;
  d.to_world = Transform::look_at({1, 2, 3}, {1, 2, 7}, {0, 1, 0});
  d.projection = Projection::kRadianceMeter;
  const auto meter = make_camera(d, 1, 1).ray<Scalar>(0.9f, 0.1f, 0.5f, 0.5f);
  CHECK(meter.origin == Vec3f{1, 2, 3});
  check_vector(meter.direction, {0, 0, 1});
  CHECK(meter.t_max == kInfinity);

  d.projection = Projection::kDistant;
  const auto distant = [&](float x, float y, float u, float v) {
    Camera camera = make_camera(d, 1, 1);
    move_outside_scene(camera, d, {10, 20, 30}, 5);
    return camera.ray<Scalar>(x, y, u, v);
  };
  check_vector(distant(0.5f, 0.5f, 0, 0).origin, {10, 20, 25});
  CHECK(length(distant(0.5f, 0.5f, 0.6f, 0.8f).origin - Vec3f{10, 20, 25}) == near(5));
  check_vector(distant(0.5f, 0.5f, 0.6f, 0.8f).direction, {0, 0, 1});
  d.target = Vec3f{7, 8, 9};
  check_vector(distant(0.5f, 0.5f, 0.6f, 0.8f).origin, {7, 8, -1});
  d.target = CameraDescription::TargetArea{Transform::translate({7, 8, 9}) * Transform::scale({2, 3, 1}), false};
  check_vector(distant(0, 0, 0.6f, 0.8f).origin, {5, 5, -1});
  check_vector(distant(1, 0.5f, 0.6f, 0.8f).origin, {9, 8, -1});
  d.target = CameraDescription::TargetArea{Transform::translate({7, 8, 9}) * Transform::scale({2, 3, 1}), true};
  check_vector(distant(0, 0, 0, -1).origin, {7, 5, -1});

  d.projection = Projection::kIrradianceMeter;
  d.to_world = Transform::translate({1, 0, 0}) * Transform::rotate({0, 1, 0}, 90) * Transform::scale({2, 2, 2});
  const Camera camera = make_camera(d, 2, 2);
  CHECK(camera.weight == near(3.14159265));
  const auto corner = camera.ray<Scalar>(0, 0, 0, 0), middle = camera.ray<Scalar>(1, 1, 0.6f, 0);
  CHECK(length(corner.origin - Vec3f{1, -2, 2}) < 1e-5f);
  CHECK(corner.origin.x > 1);  // at an offset from the surface
  check_vector(corner.direction, {1, 0, 0});
  CHECK(length(middle.origin - Vec3f{1, 0, 0}) < 1e-5f);
  CHECK(middle.direction.x == near(0.8));
  for (const Projection projection : {Projection::kRadianceMeter, Projection::kDistant, Projection::kIrradianceMeter}) {
    d.projection = projection;
    CHECK_FALSE(make_camera(d, 1, 1).sees_points);
  }
}

TEST_CASE("camera: orthographic cameras with a lens are sharp in the focal plane") {
  CameraDescription d;
  d.projection = CameraDescription::Projection::kOrthographic;
  d.aperture_radius = 0.25f;
  d.focus_distance = 4;
  const Camera camera = make_camera(d, 100, 100);
  CHECK(camera.has_lens());
  const auto ray = camera.ray<Scalar>(25, 50, 0.6f, -0.8f);
  CHECK(length(ray.origin - Vec3f{0.5f + 0.15f, -0.2f, 0}) < 1e-6f);
  CHECK(length(ray.origin + ray.direction * (4 / ray.direction.z) - Vec3f{0.5f, 0, 4}) < 1e-5f);
}

TEST_CASE("camera: SIMD results equal scalar ones") {
  CameraDescription d = camera_with(70, Axis::kDiagonal);
  d.to_world = Transform::look_at({3, -1, 2}, {0, 1, 0}, {0, 1, 0});
  d.aperture_radius = 0.3f;
  d.focus_distance = 2;
  d.near_clip = 0.1f;
  d.far_clip = 9;
  const Camera camera = make_camera(d, 640, 480);
  double worst = 0;
  for (std::uint32_t i = 0; i < 1024; i += kWidth) {
    const auto u = wide_random(6, i);
    const auto wide = camera.ray<Wide>(u.x * WideFloat(640.0f), u.y * WideFloat(480.0f), u.z, u.w);
    for (int lane = 0; lane < kWidth; ++lane) {
      const auto one = camera.ray<Scalar>(u.x[lane] * 640.0f, u.y[lane] * 480.0f, u.z[lane], u.w[lane]);
      worst = std::max(worst, record_difference<Vec3>(lane_record(wide.origin, lane), one.origin));
      worst = std::max(worst, record_difference<Vec3>(lane_record(wide.direction, lane), one.direction));
      worst = std::max(worst, difference(wide.t_max[lane], one.t_max));
    }
  }
  CHECK(worst < 1e-6);
}

TEST_CASE("camera: the view of a point is the ray that hits it and its importance the area of a patch on the film") {
  for (int kind = 0; kind < 3; ++kind) {
    CAPTURE(kind);
    CameraDescription description;
    description.to_world = Transform::look_at({1, 2, 3}, {-0.3f, 0.5f, 0.2f}, {0, 0, 1});
    description.fov = 50;
    description.principal_point_x = 0.1f;
    description.near_clip = 0.5f;
    if (kind == 1) description.projection = CameraDescription::Projection::kOrthographic;
    if (kind == 2) description.aperture_radius = 0.3f, description.focus_distance = 2;
    const Camera camera = make_camera(description, 40, 30);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> u(-1, 1);
    for (int i = 0; i < 100; ++i) {
      const float x = 20 + 20 * u(random), y = 15 + 15 * u(random), lens_u = 0.7f * u(random),
                  lens_v = 0.7f * u(random);
      const auto ray = camera.ray<Scalar>(x, y, lens_u, lens_v);
      const float t = 2 + u(random);
      const auto at = [&](float film_x, float film_y) {
        const auto r = camera.ray<Scalar>(film_x, film_y, lens_u, lens_v);
        // Point where the neighboring ray meets the plane perpendicular to the ray.
        return r.origin + r.direction * (dot(ray.origin + ray.direction * t - r.origin, ray.direction) /
                                         dot(r.direction, ray.direction));
      };
      const auto view = camera.view<Scalar>(ray.origin + ray.direction * t, lens_u, lens_v);
      CHECK(view.valid);
      CHECK(view.film_x == near(x, 1e-4));
      CHECK(view.film_y == near(y, 1e-4));
      CHECK(length(view.target - ray.origin) < 1e-5f);
      constexpr float kStep = 0.05f;
      const Vec3f dx = at(x + kStep, y) - at(x - kStep, y), dy = at(x, y + kStep) - at(x, y - kStep);
      CHECK(view.importance * length(cross(dx, dy)) == near(4 * kStep * kStep, 2e-3));
    }
  }
}

}  // namespace sheaf::test_camera
