// The medium in which camera rays start.
#include "scene/compile/compile.h"
#include "scene/formats/mesh.h"
#include "tests/support/media_testing.h"

#include <doctest/doctest.h>

namespace sheaf::test_camera_medium {

namespace {

/// A camera at the origin that looks along +z, and a sphere of gas around `center`.
Description beside_gas(Vec3f center, float radius) {
  Description d = empty_scene(16, 8);
  fill(d, add_sphere(d, center, radius), add_medium(d, fog(1, 0.5f)));
  return d;
}

struct Found {
  std::uint32_t medium;
  std::size_t warnings;
};

Found find(const Description& d) {
  const auto scene = compile_scene(d);
  for (const std::string& warning : scene->warnings()) CAPTURE(warning);
  return {scene->view().media.camera_medium, scene->warnings().size()};
}

void check(const Description& d, std::uint32_t medium, bool warns) {
  const Found found = find(d);
  CHECK(found.medium == medium);
  CHECK(found.warnings == (warns ? 1u : 0u));
}

}  // namespace

TEST_CASE("camera medium: the medium of a pinhole camera is found at the near plane") {
  check(beside_gas({0, 0, 0}, 1), 1, false);
  check(beside_gas({0, 0, 3}, 1), 0, false);
  Description d = beside_gas({0, 0, 3}, 1);
  d.camera.fov = 5;
  d.camera.near_clip = 2.5f;
  check(d, 1, false);
  // Outside the image, the near plane leaves the gas.
  d.camera.fov = 90;
  check(d, 1, true);
}

TEST_CASE("camera medium: the medium of an orthographic camera is found at the center of its film") {
  Description d = beside_gas({0, 0, 0}, 2);
  d.camera.projection = CameraDescription::Projection::kOrthographic;
  check(d, 1, false);
  check(
      [&] {
        Description e = d;
        e.shapes[0].geometry = SphereShape{{0, 0, 0}, 0.5f};
        return e;
      }(),
      1, true);
  check(
      [&] {
        Description e = d;
        e.shapes[0].geometry = SphereShape{{1, 0.5f, 0}, 0.2f};
        return e;
      }(),
      0, true);
}

TEST_CASE("camera medium: a lens across a boundary gives a warning") {
  Description d = beside_gas({0, 0, -1}, 1.05f);
  d.camera.focus_distance = 5;
  d.camera.aperture_radius = 0.02f;
  check(d, 1, false);
  d.camera.aperture_radius = 0.5f;
  check(d, 1, true);
  // A named medium gives no warning.
  d.camera.medium = MediumId{0};
  check(d, 1, false);
}

TEST_CASE("boundaries of media: open meshes give a warning") {
  const auto warns = [](const Mesh& mesh, bool bounds) {
    Description d = empty_scene(4, 4);
    ShapeDescription& shape = add_shape(d, mesh, Transform::translate({0, 0, 5}));
    if (bounds) fill(d, shape, add_medium(d, fog(1, 0.5f)));
    bool found = false;
    const auto scene = compile_scene(d);
    for (const std::string& warning : scene->warnings()) found |= warning.find("3 open edges") != warning.npos;
    return found;
  };
  Mesh lidless = cube_mesh();
  lidless.triangles.pop_back();
  // Two meshes that close each other
  const auto warns_of_both = [&](const Mesh& other) {
    Description d = empty_scene(4, 4);
    const MediumId medium = add_medium(d, fog(1, 0.5f));
    for (const Mesh& mesh : {lidless, other}) fill(d, add_shape(d, mesh, Transform::translate({0, 0, 5})), medium);
    return !compile_scene(d)->warnings().empty();
  };
  Mesh lid = cube_mesh();
  lid.triangles = {lid.triangles.back()};
  CHECK_FALSE(warns_of_both(lid));
  for (Vec3f& p : lid.positions) p.x *= 1.01f;
  CHECK(warns_of_both(lid));
  CHECK(warns(lidless, true));
  CHECK_FALSE(warns(lidless, false));
  CHECK_FALSE(warns(cube_mesh(), true));
}

}  // namespace sheaf::test_camera_medium
