// Geometry kept from one frame to the next: it is reused exactly if the acceleration structure would be the same.
#include "scene/compile/compile.h"
#include "scene/compile/geometry/kept_geometry.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <string>

namespace sheaf::test_kept_geometry {

using namespace test;

namespace {

struct Variant {
  const char* color = "0.5";
  const char* origin = "0, 0, 9";
  const char* shift = "0";     ///< of a cube
  const char* position = "2";  ///< of an instance
  const char* light = "";      ///< another emitter
  const char* inside = "";     ///< another shape
};

Description read(const Variant& v) {
  return read_text(
      "<scene version='3.0.0'><integrator type='path'/><sensor type='perspective'><transform name='to_world'>"
      "<lookat origin='" +
      std::string(v.origin) +
      "' target='0, 0, 0' up='0, 1, 0'/></transform></sensor>"
      "<shape type='cube'><transform name='to_world'><translate x='" +
      v.shift +
      "'/></transform>"
      "<bsdf type='diffuse'><rgb name='reflectance' value='" +
      v.color + "'/></bsdf></shape>" + v.inside +
      "<shape type='sphere'><emitter type='area'><rgb name='radiance' value='1'/></emitter></shape>"
      "<shape type='shapegroup' id='group'><shape type='disk'/><shape type='rectangle'/></shape>"
      "<shape type='instance'><ref id='group'/><transform name='to_world'><translate y='" +
      std::string(v.position) + "'/></transform></shape>" + v.light + "</scene>");
}

std::unique_ptr<Scene> compile(const Variant& v, KeptGeometry& kept, bool watertight = false) {
  CompileOptions options;
  options.watertight = watertight;
  options.kept = &kept;
  return compile_scene(read(v), options);
}

/// Whether the second scene takes the geometry of the first one, to which the kept acceleration structure refers.
bool reuses(const Variant& first, const Variant& second, bool watertight = false) {
  KeptGeometry kept;
  std::unique_ptr<Scene> scene = compile(first, kept);
  const VertexRow* const vertices = scene->view().geometry.vertices;
  keep_geometry(std::move(scene), kept);
  scene = compile(second, kept, watertight);
  REQUIRE(scene->view().accel != nullptr);
  CHECK(kept.accel == nullptr);
  // Other geometry is in memory before the kept one is freed, so that equal addresses mean the same tables.
  return scene->view().geometry.vertices == vertices;
}

}  // namespace

TEST_CASE("kept geometry: reused if only cameras, materials and lights at infinity change") {
  CHECK(reuses({}, {}));
  CHECK(reuses({}, {.origin = "0, 3, 9"}));
  CHECK(reuses({}, {.color = "0.2"}));
  CHECK(reuses({}, {.light = "<emitter type='constant'/>"}));
}

TEST_CASE("kept geometry: not reused if any shape, instance or option of the structure changes") {
  CHECK_FALSE(reuses({}, {.shift = "0.001"}));
  CHECK_FALSE(reuses({}, {.position = "2.5"}));
  CHECK_FALSE(reuses({}, {.inside = "<shape type='disk'/>"}));
  CHECK_FALSE(reuses({}, {.inside = "<shape type='rectangle'/>"}));
  CHECK_FALSE(reuses({}, {}, true));
}

TEST_CASE(
    "kept geometry: the second change of vertices updates the acceleration structure, the first one rebuilds it") {
  KeptGeometry kept;
  kept.expects_changes = true;
  const VertexRow* last = nullptr;  // see reuses()
  int step = 0;
  for (const char* const shift : {"0", "1", "4", "0", "0"}) {
    std::unique_ptr<Scene> scene = compile({.shift = shift}, kept);
    const Accel* const accel = scene->view().accel;
    CHECK((scene->view().geometry.vertices == last) == (step > 1));
    RayPacket packet;
    const float x = std::stof(shift);
    packet.set_ray(0, {x + 0.5f, 0.25f, 9}, {0, 0, -1});   // the cube
    packet.set_ray(1, {0.25f, 0.125f, 9}, {0, 0, -1});     // the sphere or the cube
    packet.set_ray(2, {x + 1.25f, 0.25f, 9}, {0, 0, -1});  // beside the cube
    packet.set_ray(3, {0.5f, 2.25f, 9}, {0, 0, -1});       // the instance
    accel->intersect(packet, 4);
    CHECK(packet.shape[0] == 0);
    CHECK(packet.t_far[0] == near(8, 1e-6));  // depends on the width of Embree's registers
    CHECK(packet.shape[1] == (x < 2 ? 0 : 1));
    CHECK(packet.shape[2] == kNone);
    CHECK(packet.instance[3] == 0);
    last = scene->view().geometry.vertices;
    keep_geometry(std::move(scene), kept);
    ++step;
  }
  // More than vertices
  CHECK(compile({.inside = "<shape type='disk'/>"}, kept)->view().accel != nullptr);
}

TEST_CASE("kept geometry: rays hit the same surfaces, and rows have the new materials") {
  KeptGeometry kept;
  for (const char* const color : {"0.5", "0.25"}) {
    std::unique_ptr<Scene> scene = compile({.color = color}, kept);
    RayPacket packet;
    packet.set_ray(0, {0.5f, 0.25f, 9}, {0, 0, -1});
    packet.set_ray(1, {0.5f, 2.25f, 9}, {0, 0, -1});
    packet.set_ray(2, {5, 5, 9}, {0, 0, -1});
    scene->view().accel->intersect(packet, 3);
    CHECK(packet.shape[0] == 0);
    CHECK(packet.t_far[0] == near(8, 1e-6));  // depends on the width of Embree's registers
    CHECK(packet.instance[1] == 0);
    CHECK(packet.shape[2] == kNone);
    CHECK(scene->view().geometry.shape_count == 4);
    keep_geometry(std::move(scene), kept);
  }
}

}  // namespace sheaf::test_kept_geometry
