// Division of OBJ meshes by the materials of their MTL files.
#include "scene/dialects/model/obj_materials.h"

#include "scene/formats/mesh.h"
#include "scene/formats/mesh_io.h"
#include "tests/support/files/mesh_files.h"

#include <doctest/doctest.h>

#include <algorithm>

namespace sheaf::test_obj_materials {

using namespace test;

namespace {

/// A folder with an OBJ file and its libraries, and a description with one shape that uses it.
struct ObjScene {
  TemporaryFolder folder;
  Description description;

  explicit ObjScene(const std::string& obj, const std::string& mtl = "") {
    write_bytes(folder / "mesh.obj", obj);
    if (!mtl.empty()) write_bytes(folder / "lib.mtl", mtl);
    ShapeDescription shape;
    MeshFileShape file;
    file.file = folder / "mesh.obj";
    shape.geometry = file;
    shape.where = {"scene.xml", 7};
    description.shapes.push_back(shape);
  }
  ShapeDescription& shape() { return description.shapes.at(0); }
  const Mesh& mesh(std::size_t i) const { return std::get<Mesh>(description.shapes.at(i).geometry); }
  bool is_cut() const { return std::holds_alternative<Mesh>(description.shapes.at(0).geometry); }
  bool has_note(std::string_view part) const {
    return std::any_of(description.notes.begin(), description.notes.end(),
                       [&](const std::string& note) { return contains(note, part); });
  }
};

/// Calls expand_obj_materials().
void expand(Description& description, bool lenient = false) {
  ErrorSink errors(lenient, description.substitutions);
  errors.run([&] { expand_obj_materials(description, errors); });
}

Vec3f rgb(const SpectrumInput& input) {
  return std::get<SpectrumDescription::Rgb>(std::get<SpectrumDescription>(input).value).value;
}

/// A tent of two rectangles that share the edge 2 3, with materials `left` and `right`.
std::string tent(const std::string& left, const std::string& right, const std::string& library = "lib.mtl") {
  return "mtllib " + library + "\nv 0 0 0\nv 0 1 0\nv 1 1 1\nv 1 0 1\nv 2 1 0\nv 2 0 0\nusemtl " + left +
         "\nf 1 4 3 2\nusemtl " + right + "\nf 4 6 5 3\n";
}
const std::string kRedAndBlue = "newmtl red\nKd 0.5 0.25 0.125\nnewmtl blue\nKd 0 0 1\n";

}  // namespace

TEST_CASE("obj materials: each material becomes a shape with the flags and radiance of the original") {
  ObjScene scene(tent("red", "blue") + "usemtl red\nf 1 2 4\n", kRedAndBlue + "newmtl unused\nmap_Kd nowhere.png\n");
  scene.shape().flip_normals = true;
  scene.shape().to_world = Transform::translate({0, 0, 5});
  expand(scene.description);
  const Description& d = scene.description;
  REQUIRE(d.shapes.size() == 2);
  CHECK(d.textures.empty());
  CHECK(d.notes.empty());
  CHECK(scene.mesh(0).triangles.size() == 3);
  CHECK(scene.mesh(1).triangles.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    check_mesh(scene.mesh(i), {});
    CHECK(d.shapes[i].flip_normals);
    CHECK(d.shapes[i].where.line == 7);
    CHECK_FALSE(d.shapes[i].radiance);
    CHECK(d.materials.at(static_cast<std::size_t>(*d.shapes[i].material)).id == (i == 0 ? "red" : "blue"));
    CHECK(d.shapes[i].to_world.point(scene.mesh(i).positions[0]).z >= 5.0f);
  }
}

TEST_CASE("obj materials: normals are those of the undivided mesh") {
  for (const bool face_normals : {false, true}) {
    for (const bool smooth : {false, true}) {
      ObjScene scene(tent("red", "blue") + "f 1 1 2\n", kRedAndBlue);
      scene.shape().face_normals = face_normals;
      std::get<MeshFileShape>(scene.shape().geometry).smooth_normals = smooth;
      scene.shape().to_world = Transform::scale({1, -2, 3});
      Mesh whole = read_obj(scene.folder / "mesh.obj", true).mesh;
      transform_mesh(whole, scene.shape().to_world);
      drop_degenerate_triangles(whole);
      compute_vertex_normals(whole);
      expand(scene.description);
      REQUIRE(scene.description.shapes.size() == 2);
      CHECK(scene.has_note("scene.xml:7: 1 degenerate or non-finite triangles ignored"));
      for (std::size_t i = 0; i < 2; ++i) {
        const Mesh& part = scene.mesh(i);
        REQUIRE(part.normals.size() == (smooth && !face_normals ? 4 : 0));
        for (std::size_t k = 0; k < part.normals.size(); ++k) {
          const auto found = std::find(whole.positions.begin(), whole.positions.end(), part.positions[k]);
          REQUIRE(found != whole.positions.end());
          CHECK(part.normals[k] == whole.normals[static_cast<std::size_t>(found - whole.positions.begin())]);
        }
      }
    }
  }
}

TEST_CASE("obj materials: emission becomes an area light unless the shape emits already") {
  const std::string mtl = "newmtl red\nKe 3 2 1\nnewmtl blue\nKe 0 0 0\n";
  ObjScene scene(tent("red", "blue"), mtl);
  expand(scene.description);
  REQUIRE(scene.description.shapes.size() == 2);
  CHECK(rgb(scene.description.shapes[0].radiance.value()) == Vec3f{3, 2, 1});
  CHECK_FALSE(scene.description.shapes[1].radiance);
  ObjScene lamp(tent("red", "blue"), mtl);
  lamp.shape().radiance = SpectrumDescription::rgb(7, 7, 7);
  expand(lamp.description);
  for (const ShapeDescription& part : lamp.description.shapes) CHECK(rgb(part.radiance.value()) == Vec3f{7, 7, 7});
}

TEST_CASE("obj materials: shapes in groups are divided") {
  ObjScene scene(tent("red", "blue"), "newmtl red\nKe 3 2 1\nnewmtl blue\n");
  scene.description.groups.resize(1);
  scene.description.groups[0].shapes = std::move(scene.description.shapes);
  scene.description.shapes.clear();
  expand(scene.description);
  const std::vector<ShapeDescription>& shapes = scene.description.groups[0].shapes;
  REQUIRE(shapes.size() == 2);
  for (const ShapeDescription& shape : shapes) CHECK(shape.material);
  CHECK(rgb(shapes[0].radiance.value()) == Vec3f{3, 2, 1});
  CHECK_FALSE(shapes[1].radiance);
}

TEST_CASE("obj materials: shapes with a BSDF of their own or without usable materials are not divided") {
  const auto check_uncut = [](ObjScene& scene) {
    expand(scene.description);
    CHECK(scene.description.shapes.size() == 1);
    CHECK_FALSE(scene.is_cut());
  };
  ObjScene with_material(tent("red", "blue"), kRedAndBlue);
  with_material.description.materials.push_back({});
  with_material.shape().material = MaterialId{0};
  check_uncut(with_material);
  CHECK(with_material.description.materials.size() == 1);
  ObjScene no_library("v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n", kRedAndBlue);
  check_uncut(no_library);
  ObjScene unused("mtllib lib.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl red\n", kRedAndBlue);
  check_uncut(unused);
  ObjScene empty("");  // the compiler reads it and reports the error
  check_uncut(empty);
  ObjScene no_file("");
  std::filesystem::remove(no_file.folder / "mesh.obj");
  check_uncut(no_file);
  ObjScene missing(tent("red", "blue"));
  check_uncut(missing);
  CHECK(missing.has_note("mesh.obj:1: material library 'lib.mtl' not found"));
}

TEST_CASE("obj materials: faces may lack a material and libraries may be several and names may contain spaces") {
  ObjScene scene("mtllib no.mtl lib.mtl\nmtllib my own lib.mtl\n" + tent("red", "steel", "") + "usemtl lost\nf 1 2 5\n",
                 kRedAndBlue);
  write_bytes(scene.folder / "my own lib.mtl", "newmtl steel\nPm 1\nnewmtl red\nKd 0 0 0\n");
  expand(scene.description);
  const Description& d = scene.description;
  REQUIRE(d.shapes.size() == 3);
  CHECK(d.materials.at(static_cast<std::size_t>(*d.shapes[0].material)).where.line == 1);
  CHECK(
      contains(d.materials.at(static_cast<std::size_t>(*d.shapes[1].material)).where.file.string(), "my own lib.mtl"));
  CHECK_FALSE(d.shapes[2].material);
  CHECK(scene.has_note("'no.mtl' not found"));
  CHECK(scene.has_note("material 'lost'"));
}

TEST_CASE("obj materials: a missing material is an error with file and line and diffuse in lenient mode") {
  const std::string obj = tent("red", "blu");
  ObjScene scene(obj, kRedAndBlue);
  const std::string message = error_of([&] { expand(scene.description); });
  CHECK(contains(message, "mesh.obj:10: material 'blu' is in no material library of the file, did you mean 'blue'?"));
  ObjScene lenient(obj, kRedAndBlue);
  expand(lenient.description, true);
  REQUIRE(lenient.description.shapes.size() == 2);
  CHECK_FALSE(lenient.description.shapes[1].material);
  REQUIRE(lenient.description.substitutions.size() == 1);
  CHECK(contains(lenient.description.substitutions[0], "'blu'"));
  CHECK(contains(lenient.description.substitutions[0], "(rendered as a diffuse surface)"));
}

TEST_CASE("obj materials: names may be quoted") {
  ObjScene scene("mtllib \"my lib.mtl\" lib.mtl\n" + tent("\"red paint\"", "blue", ""), kRedAndBlue);
  write_bytes(scene.folder / "my lib.mtl", "newmtl \"red paint\"\nKd 1 0 0\n");
  expand(scene.description);
  const Description& d = scene.description;
  REQUIRE(d.shapes.size() == 2);
  CHECK(d.notes.empty());
  CHECK(d.materials.at(static_cast<std::size_t>(*d.shapes[0].material)).id == "red paint");
  CHECK(d.materials.at(static_cast<std::size_t>(*d.shapes[1].material)).id == "blue");
}

TEST_CASE("obj materials: shapes of the same file share materials") {
  ObjScene scene(tent("red", "blue"), kRedAndBlue);
  scene.description.shapes.push_back(scene.shape());
  expand(scene.description);
  const auto& shapes = scene.description.shapes;
  REQUIRE(shapes.size() == 4);
  CHECK(shapes[0].material == shapes[2].material);
  CHECK(shapes[1].material == shapes[3].material);
  CHECK(shapes[0].material != shapes[1].material);
}

TEST_CASE("obj materials: errors have scene and file and line") {
  ObjScene bad_library(tent("red", "blue"), "newmtl red\nKd x\n");
  std::string message = error_of([&] { expand(bad_library.description); });
  CHECK(contains(message, "scene.xml:7: "));
  CHECK(contains(message, "lib.mtl:2: expected a number after 'Kd', found 'x'"));
  ObjScene bad_mesh(tent("red", "blue") + "f 1 2 9\n", kRedAndBlue);
  message = error_of([&] { expand(bad_mesh.description); });
  CHECK(contains(message, "scene.xml:7: "));
  CHECK(contains(message, "mesh.obj:12: a face refers to vertex 9"));
}

}  // namespace sheaf::test_obj_materials
