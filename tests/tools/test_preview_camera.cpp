// The camera that a hand turns: its motions, the text that places it, and requests from the network.
#include "scene/description/field_of_view.h"
#include "tests/support/contains.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"
#include "tests/support/temporary_folder.h"
#include "tools/preview/camera_request.h"
#include "tools/preview/orbit_camera.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace sheaf::test_preview_camera {

using test::contains;
using test::read_text;

namespace {

/// A camera of a Mitsuba scene. `inside`: elements of the transform.
Description scene_with(const std::string& inside, const std::string& type = "perspective") {
  return read_text("<scene version='3.0.0'><integrator type='path'/><sensor type='" + type +
                   "'><transform name='to_world'>" + inside +
                   "</transform><film type='hdrfilm'><integer name='width' value='400'/>"
                   "<integer name='height' value='200'/></film></sensor><shape type='sphere'/></scene>");
}

constexpr const char* kFromFront = "<lookat origin='0, 0, 5' target='0, 0, 0' up='0, 1, 0'/>";

OrbitCamera camera_of(const Description& scene, double distance = 5) { return {scene.camera, scene.film, distance}; }

/// Position of a point on the image, fractions of its height from the middle: x to the right, y down.
struct OnImage {
  double x, y;
};
OnImage projected(const OrbitCamera& camera, const Description& scene, Vec3d point) {
  const CameraDescription description = camera.camera();
  const Vec3d local = description.to_world.inverse().precise_point(point);
  const double half_width =
      half_width_of(description.fov, description.fov_axis, scene.film.width, scene.film.height, {});
  const double half_height = half_width * scene.film.height / scene.film.width;
  const double z = description.projection == CameraDescription::Projection::kOrthographic ? 1 / half_width : local.z;
  return {-local.x / z / half_height / 2, -local.y / z / half_height / 2};
}

void check_near(Vec3d a, Vec3d b, double tolerance) {
  INFO(a.x << " " << a.y << " " << a.z << ", expected " << b.x << " " << b.y << " " << b.z);
  CHECK(length(a - b) < tolerance);
}

}  // namespace

TEST_CASE("a camera that was not moved stays where the file puts it") {
  for (const char* place :
       {kFromFront, "<lookat origin='3, 4, 5' target='1, 0, 0' up='0, 0, 1'/>",
        "<scale x='-1'/><lookat origin='3, 4, 5' target='1, 0, 0' up='0, 1, 0'/>",
        "<scale value='3'/><rotate z='1' angle='20'/><lookat origin='0, 0, 5' target='0, 0, 0' up='0, 1, 0'/>"}) {
    CAPTURE(std::string(place));
    const Description scene = scene_with(place);
    const CameraDescription moved = camera_of(scene).camera();
    for (const Vec3d point : {Vec3d(0, 0, 0), Vec3d(1, 2, 3)})
      check_near(moved.to_world.precise_point(point), scene.camera.to_world.precise_point(point), 1e-9);
  }
}

TEST_CASE("orbiting keeps the distance and the horizon, and what is in front follows the hand") {
  for (const char* place : {kFromFront, "<scale x='-1'/><lookat origin='0, 0, 5' target='0, 0, 0' up='0, 1, 0'/>"}) {
    CAPTURE(std::string(place));
    const Description scene = scene_with(place);
    OrbitCamera camera = camera_of(scene);
    const Vec3d front(0, 0, 1);
    camera.orbit(0.05, 0);
    CHECK(projected(camera, scene, front).x > 0.01);
    camera.orbit(-0.05, 0.05);
    CHECK(projected(camera, scene, front).y > 0.01);
    CHECK(camera.origin().y > 0.1);
    for (int i = 0; i < 20; ++i) camera.orbit(0.3, 0.17);
    CHECK(length(camera.origin() - camera.target()) == near(5, 1e-4));
    // The axis to the left is horizontal, also at the pole where the motion ends
    CHECK(std::abs(camera.camera().to_world.vector({1, 0, 0}).y) < 1e-5f);
    CHECK(camera.origin().y > 4.99);
    CHECK(camera.origin().y < 5);
  }
}

TEST_CASE("panning moves the target with the hand") {
  for (const char* type : {"perspective", "orthographic"})
    for (const char* place : {kFromFront, "<scale x='-1'/><lookat origin='0, 0, 5' target='0, 0, 0' up='0, 1, 0'/>"}) {
      CAPTURE(std::string(type));
      CAPTURE(std::string(place));
      const Description scene = scene_with(place, type);
      OrbitCamera camera = camera_of(scene);
      camera.pan(0.25, -0.125);
      const OnImage after = projected(camera, scene, {0, 0, 0});
      CHECK(after.x == near(0.25, 1e-4));
      CHECK(after.y == near(-0.125, 1e-4));
    }
}

TEST_CASE("dollying halves the distance, or the size of an orthographic image") {
  OrbitCamera camera = camera_of(scene_with(kFromFront));
  camera.dolly(-1);
  check_near(camera.origin(), {0, 0, 2.5}, 1e-9);
  check_near(camera.target(), {0, 0, 0}, 1e-9);
  const Description flat = scene_with(kFromFront, "orthographic");
  OrbitCamera parallel = camera_of(flat);
  parallel.dolly(-1);
  check_near(parallel.origin(), {0, 0, 5}, 1e-9);
  CHECK(length(parallel.camera().to_world.vector({1, 0, 0})) == near(0.5, 1e-4));
  for (int i = 0; i < 1000; ++i) camera.dolly(-10);
  CHECK(length(camera.origin() - camera.target()) > 0);
  for (int i = 0; i < 1000; ++i) camera.dolly(10);
  CHECK(is_finite(camera.origin()));
}

TEST_CASE("a target turns the camera, and the focal plane is placed at a point") {
  OrbitCamera camera = camera_of(scene_with(kFromFront));
  camera.look_at({1, 1, 1});
  check_near(camera.target(), {1, 1, 1}, 1e-9);
  check_near(camera.origin(), {0, 0, 5}, 1e-9);
  const Vec3d forward(camera.camera().to_world.vector({0, 0, 1}));
  check_near(forward * (1 / length(forward)), Vec3d(1, 1, -4) * (1 / std::sqrt(18.0)), 1e-6);
  OrbitCamera focused = camera_of(scene_with(kFromFront));
  focused.focus({2, 1, 1});
  CHECK(focused.camera().focus_distance == near(4, 1e-4));
  focused.focus({0, 0, 9});  // behind the camera
  CHECK(focused.camera().focus_distance == near(4, 1e-4));
  CHECK(contains(focused.mitsuba_text(), "<float name=\"focus_distance\" value=\"4\"/>"));
  // The camera never stands on its head
  camera.look_at({0, 7, 5});
  check_near(camera.target(), {1, 1, 1}, 1e-9);
}

TEST_CASE("the text for scene files places the camera where it is") {
  for (const char* place : {kFromFront, "<lookat origin='3, 4, 5' target='1, 0, 0' up='0, 0, 1'/>",
                            "<scale x='-1'/><lookat origin='3, 4, 5' target='1, 0, 0' up='0, 1, 0'/>",
                            "<lookat origin='3000, 4000, 5000' target='1, 0, 0' up='0, 1, 0'/>"}) {
    CAPTURE(std::string(place));
    const Description scene = scene_with(place);
    const double distance = length(scene.camera.to_world.translation());
    OrbitCamera camera = camera_of(scene, distance);
    camera.orbit(0.12, -0.07);
    camera.pan(0.1, 0.2);
    const Transform moved = camera.camera().to_world;
    // Mitsuba
    CAPTURE(camera.mitsuba_text());
    std::string text = camera.mitsuba_text();
    const std::string begin = "<transform name=\"to_world\">", end = "</transform>";
    REQUIRE(text.starts_with(begin));
    REQUIRE(text.ends_with(end));
    const Description pasted = scene_with(text.substr(begin.size(), text.size() - begin.size() - end.size()));
    // pbrt
    TemporaryFolder folder;
    write_bytes(folder / "scene.pbrt", camera.pbrt_text() + "\nCamera \"perspective\"\nWorldBegin\nShape \"sphere\"\n");
    const Description other = read_scene(folder / "scene.pbrt");
    for (const Vec3d point : {Vec3d(0, 0, 0), Vec3d(1, 2, distance)}) {
      check_near(pasted.camera.to_world.precise_point(point), moved.precise_point(point), 1e-4 * distance);
      check_near(other.camera.to_world.precise_point(point), moved.precise_point(point), 1e-4 * distance);
    }
  }
}

TEST_CASE("sensors that form no image, and several cameras, cannot be moved") {
  CHECK(is_movable(scene_with(kFromFront)));
  CHECK(is_movable(scene_with(kFromFront, "orthographic")));
  for (const char* type : {"radiancemeter", "distant", "irradiancemeter"}) {
    Description scene = scene_with(kFromFront);
    scene.camera.projection = std::string(type) == "distant"         ? CameraDescription::Projection::kDistant
                              : std::string(type) == "radiancemeter" ? CameraDescription::Projection::kRadianceMeter
                                                                     : CameraDescription::Projection::kIrradianceMeter;
    CHECK_FALSE(is_movable(scene));
  }
  Description several = scene_with(kFromFront);
  several.more_cameras.push_back(several.camera);
  CHECK_FALSE(is_movable(several));
}

TEST_CASE("requests are parsed strictly") {
  const auto motion = parse_camera_request(R"({"orbit": [0.1, -0.2], "pan": [1, 2], "dolly": -0.5})");
  REQUIRE(motion);
  CHECK(motion->orbit[1] == -0.2);
  CHECK(motion->pan[0] == 1);
  CHECK(motion->dolly == -0.5);
  CHECK_FALSE(motion->reset);
  CHECK(parse_camera_request(R"({"reset":true})")->reset);
  CHECK(parse_camera_request(R"({"target":[0,1]})")->target->y == 1);
  CHECK(parse_camera_request(R"({"focus":[0.5,0.25]})")->focus->y == 0.25);
  for (const char* body : {"",
                           "{}",
                           "[]",
                           "null",
                           "1",
                           "{\"orbit\":[0,0]",
                           "{\"orbit\":[0,0]}x",
                           "{\"orbit\":0}",
                           "{\"orbit\":[0]}",
                           "{\"orbit\":[0,0,0]}",
                           "{\"orbit\":[\"0\",0]}",
                           "{\"orbit\":[null,0]}",
                           "{\"orbit\":[1e400,0]}",
                           "{\"orbit\":[11,0]}",
                           "{\"pan\":[0,-1e9]}",
                           "{\"dolly\":[1]}",
                           "{\"dolly\":11}",
                           "{\"dolly\":NaN}",
                           "{\"target\":[-0.1,0]}",
                           "{\"focus\":[0,1.1]}",
                           "{\"reset\":false}",
                           "{\"reset\":1}",
                           "{\"jump\":[0,0]}",
                           "{\"orbit\":[0,0],\"file\":\"/etc/passwd\"}",
                           "\xff\xfe",
                           "{\"orbit\":{\"0\":1,\"1\":1}}"}) {
    CAPTURE(std::string(body));
    CHECK_FALSE(parse_camera_request(body));
  }
  CHECK_FALSE(parse_camera_request(std::string(kMaxCameraRequest + 1, ' ') + "{\"reset\":true}"));
  CHECK_FALSE(parse_camera_request(std::string(kMaxCameraRequest, '[')));
}

TEST_CASE("positions on the image are parsed strictly") {
  const auto middle = parse_image_position("0.5", "1");
  REQUIRE(middle);
  CHECK(middle->x == 0.5);
  CHECK(middle->y == 1);
  for (const char* text : {"", " 0", "0 ", "0x1p-1", "nan", "inf", "-0.01", "1.01", "1e999", "0,5"}) {
    CAPTURE(std::string(text));
    CHECK_FALSE(parse_image_position(text, "0"));
    CHECK_FALSE(parse_image_position("0", text));
  }
}

}  // namespace sheaf::test_preview_camera
