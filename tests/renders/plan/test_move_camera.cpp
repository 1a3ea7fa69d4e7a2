// A compiled scene with another camera gives the image of the scene that is compiled with that camera.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "scene/compile/move_camera.h"
#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

namespace sheaf::test_move_camera {

using test::read_text;

namespace {

/// A glass ball with a colored medium and a lamp, from the side. `origin`: of the camera, and of the scene.
Description read(const std::string& from, double origin = 0) {
  const std::string at = fmt::format("<translate x='{}'/>", origin);
  return read_text(
      "<scene version='3.0.0'><integrator type='volpath'/><sensor type='perspective'><transform name='to_world'>"
      "<lookat origin='" +
      from + "' target='0, 0, 0' up='0, 1, 0'/>" + at +
      "</transform><film type='hdrfilm'><integer name='width' value='24'/><integer name='height' value='16'/></film>"
      "<sampler type='independent'><integer name='sample_count' value='4'/></sampler></sensor>"
      "<shape type='sphere'><transform name='to_world'>" +
      at +
      "</transform><bsdf type='null'/><medium type='homogeneous' name='interior'>"
      "<rgb name='sigma_t' value='0.1, 0.5, 2'/><rgb name='albedo' value='0.5'/></medium></shape>"
      "<shape type='rectangle'><transform name='to_world'><scale value='0.5'/><translate z='-3'/>" +
      at +
      "</transform><emitter type='area'><rgb name='radiance' value='4'/></emitter></shape>"
      "<shape type='sphere'><transform name='to_world'><scale value='50'/>" +
      at + "</transform><bsdf type='twosided'><bsdf type='diffuse'/></bsdf></shape></scene>");
}

Image image_of(const Scene& scene) { return render(scene, {}).to_image(); }

}  // namespace

TEST_CASE("a moved camera sees what a compiled one does, from outside and inside of a medium") {
  for (const char* place : {"4, 1, 3", "0.1, 0.2, 0.3", "0, 0, 5"}) {
    CAPTURE(std::string(place));
    const Description after = read(place);
    std::unique_ptr<Scene> scene = compile_scene(read("0, 0, 5"));
    const Accel* const accel = scene->view().accel;
    move_camera(after.camera, after.film, scene);
    CHECK(scene->view().accel == accel);
    CHECK(image_of(*scene).data == image_of(*compile_scene(after)).data);
  }
}

TEST_CASE("a camera moves in a scene far from the origin of the world") {
  constexpr double kFar = 1e6;
  const Description after = read("4, 1, 3", kFar);
  std::unique_ptr<Scene> scene = compile_scene(read("0, 0, 5", kFar));
  REQUIRE(scene->origin() != Vec3d());
  move_camera(after.camera, after.film, scene);
  // The tables are relative to another point, so that rounding differs
  const Image moved = image_of(*scene), compiled = image_of(*compile_scene(after));
  double sum = 0, difference = 0;
  for (std::size_t i = 0; i < moved.data.size(); ++i) {
    sum += double{compiled.data[i]};
    difference += std::abs(double{moved.data[i]} - double{compiled.data[i]});
  }
  CHECK(difference < 0.01 * sum);
}

TEST_CASE("the size of the film may change with the camera") {
  const Description scene = read("4, 1, 3");
  Description small = scene;
  small.film.width = 12;
  small.film.height = 8;
  std::unique_ptr<Scene> moved = compile_scene(scene);
  move_camera(scene.camera, small.film, moved);
  CHECK(image_of(*moved).data == image_of(*compile_scene(small)).data);
}

TEST_CASE("a camera that cannot be compiled leaves the scene as it was") {
  const Description scene = read("4, 1, 3");
  std::unique_ptr<Scene> moved = compile_scene(scene);
  CameraDescription camera = scene.camera;
  camera.fov = 180;
  CHECK_THROWS_AS(move_camera(camera, scene.film, moved), SceneError);
  REQUIRE(moved != nullptr);
  CHECK(image_of(*moved).data == image_of(*compile_scene(scene)).data);
}

}  // namespace sheaf::test_move_camera
