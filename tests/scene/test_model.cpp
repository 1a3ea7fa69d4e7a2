// A model without a scene: floor, sky, camera, materials.
#include "scene/compile/compile.h"
#include "tests/support/scene_files.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_model {

using namespace test;

namespace {

/// A tetrahedron from (2, 1, 0) to (4, 5, 2), with a material on one face.
const char* const kTetrahedron =
    "mtllib look.mtl\nv 2 1 0\nv 4 1 0\nv 2 5 0\nv 2 1 2\n"
    "f 1 3 2\nf 1 2 4\nf 1 4 3\nusemtl red\nf 2 3 4\n";

Description read_model_text(const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  write_below(folder, "look.mtl", "newmtl red\nKd 1 0 0\n");
  return read_scene(write_below(folder, "model.OBJ", kTetrahedron), options);
}

}  // namespace

TEST_CASE("model: it stands on a floor, has its materials, and is lit") {
  const Description d = read_model_text();
  REQUIRE(d.shapes.size() == 3);  // two materials and the floor
  for (const ShapeDescription& shape : d.shapes) CHECK(shape.material.has_value());
  const ShapeDescription& floor = d.shapes.back();
  CHECK(std::holds_alternative<DiskShape>(floor.geometry));
  CHECK(floor.to_world.point({0.5f, 0.5f, 0}).y == doctest::Approx(1));
  CHECK(floor.to_world.vector({0, 0, 1}).y == doctest::Approx(1));
  CHECK(d.lights.size() == 2);
  CHECK(compile_scene(d)->info().triangles == 4);
}

TEST_CASE("model: all of it is in the picture, from wherever it is seen") {
  for (const auto up : {ModelView::Up::kX, ModelView::Up::kY, ModelView::Up::kZ})
    for (const float elevation : {-90.0f, 0.0f, 20.0f, 90.0f})
      for (const float azimuth : {0.0f, 100.0f}) {
        CAPTURE(elevation);
        CAPTURE(azimuth);
        ReadOptions options;
        options.view = {up, azimuth, elevation, 40};
        const Description d = read_model_text(options);
        const Transform to_camera = d.camera.to_world.inverse();
        for (const Vec3f corner : {Vec3f{2, 1, 0}, Vec3f{4, 1, 0}, Vec3f{2, 5, 0}, Vec3f{2, 1, 2}}) {
          const Vec3f seen = to_camera.point(corner);
          REQUIRE(seen.z > 0);
          CHECK(std::hypot(seen.x, seen.y) / seen.z < std::tan(20.0 * 3.14159265 / 180));
        }
        const Vec3f eye = d.camera.to_world.point({0, 0, 0}) - Vec3f{3, 3, 1};
        const float height = up == ModelView::Up::kX ? eye.x : up == ModelView::Up::kY ? eye.y : eye.z;
        CHECK(height / length(eye) == doctest::Approx(std::sin(elevation * 3.14159265 / 180)).epsilon(1e-3));
      }
}

TEST_CASE("model: a broken file is an error with its line") {
  const TemporaryFolder folder;
  const std::string message = error_of(write_below(folder, "model.obj", "v 0 0 0\nf 1 2 3\n"));
  CHECK(contains(message, "model.obj"));
}

}  // namespace sheaf::test_model
