// A model without a scene: floor, environment, camera, materials.
#include "scene/compile/compile.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace sheaf::test_model {

using namespace test;

namespace {

/// A tetrahedron from (2, 1, 0) to (4, 5, 2) with a material on one face.
const char* const kTetrahedron =
    "mtllib look.mtl\nv 2 1 0\nv 4 1 0\nv 2 5 0\nv 2 1 2\n"
    "f 1 3 2\nf 1 2 4\nf 1 4 3\nusemtl red\nf 2 3 4\n";

/// Options for a model on a floor under a sky.
ReadOptions on_floor() {
  ReadOptions options;
  options.surroundings.studio = Studio::kSun;
  return options;
}

Description read_model_text(const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  write_below(folder, "look.mtl", "newmtl red\nKd 1 0 0\n");
  return read_scene(write_below(folder, "model.OBJ", kTetrahedron), options);
}

}  // namespace

TEST_CASE("model: a model stands on a floor and has its materials and is lit") {
  const Description d = read_model_text(on_floor());
  REQUIRE(d.shapes.size() == 3);  // two materials and the floor
  for (const ShapeDescription& shape : d.shapes) CHECK(shape.material.has_value());
  const ShapeDescription& floor = d.shapes.back();
  CHECK(std::holds_alternative<DiskShape>(floor.geometry));
  CHECK(floor.to_world.point({0.5f, 0.5f, 0}).y == near(1));
  CHECK(floor.to_world.vector({0, 0, 1}).y == near(1));
  CHECK(d.lights.size() == 2);
  CHECK(compile_scene(d)->info().triangles == 4);
}

TEST_CASE("model: the whole model is in the image from every direction") {
  for (const auto up : {ModelView::Up::kX, ModelView::Up::kY, ModelView::Up::kZ})
    for (const float elevation : {-90.0f, 0.0f, 20.0f, 90.0f})
      for (const float azimuth : {0.0f, 100.0f}) {
        CAPTURE(elevation);
        CAPTURE(azimuth);
        ReadOptions options;
        options.view = {up, azimuth, elevation, 40, 4.0 / 3};
        const Description d = read_model_text(options);
        const Transform to_camera = d.camera.to_world.inverse();
        for (const Vec3f corner : {Vec3f{2, 1, 0}, Vec3f{4, 1, 0}, Vec3f{2, 5, 0}, Vec3f{2, 1, 2}}) {
          const Vec3f seen = to_camera.point(corner);
          REQUIRE(seen.z > 0);
          CHECK(std::abs(seen.x) / seen.z < 4.0 / 3 * std::tan(20.0 * 3.14159265 / 180));
          CHECK(std::abs(seen.y) / seen.z < std::tan(20.0 * 3.14159265 / 180));
        }
        const Vec3f view = d.camera.to_world.vector({0, 0, -1});
        const float height = up == ModelView::Up::kX ? view.x : up == ModelView::Up::kY ? view.y : view.z;
        CHECK(std::abs(height / length(view) - std::sin(elevation * 3.14159265 / 180)) < 1e-6);
      }
}

TEST_CASE("model: a malformed file is an error with its line") {
  const TemporaryFolder folder;
  const std::string message = error_of(write_below(folder, "model.obj", "v 0 0 0\nf 1 2 3\n"));
  CHECK(contains(message, "model.obj"));
}

TEST_CASE("model: in lenient mode faces with missing vertices are dropped and other invalid indices ignored") {
  const TemporaryFolder folder;
  ReadOptions leniently;
  leniently.lenient = true;
  const auto model_of = [&](const char* name, const std::string& text) {
    Description d = read_scene(write_below(folder, name, text), leniently);
    const auto* mesh = std::get_if<Mesh>(&d.shapes.at(0).geometry);
    REQUIRE(mesh != nullptr);
    CHECK(mesh->triangles.size() == 3);
    compile_scene(d);
    return d;
  };
  const auto notes = [](const Description& d, const char* text) {
    return std::any_of(d.notes.begin(), d.notes.end(),
                       [text](const std::string& note) { return contains(note, text); });
  };
  // Faces with indices beyond the last or before the first vertex, or of missing texture coordinates and normals.
  const std::string obj =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nf 1 2 3\nf 1 2 5\nf 1/1 3/7 4/1\nf -9 1 2\nf 2//1 3//1 4//1\n";
  CHECK(contains(error_of(write_below(folder, "model.obj", obj)), "refers to vertex -9, but there are 4"));
  const Description by_obj = model_of("model.obj", obj);
  CHECK(notes(by_obj, "faces left out: 2 (line 9: a face refers to vertex -9, but there are 4)"));
  CHECK(notes(by_obj, "indices out of range ignored: line 8: a face refers to texture coordinate 7, but there are 1"));
  CHECK(notes(by_obj, "indices out of range ignored: line 10: a face refers to normal 1, but there are 0"));
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 4\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  const Description by_ply = model_of("model.ply", header +
                                                       "3 0 1 2 6 0 0 1 0 0 1\n3 0 1 4 6 0 0 1 0 0 1\n"
                                                       "3 0 2 3 6 0 1 1 0 0 1\n3 1 2 3 6 1 0 1 0 0 1\n");
  CHECK(notes(by_ply, "faces left out: 1 (expected the index of one of 4 vertices, found 4)"));
  // Materials of a missing file.
  CHECK_NOTHROW(read_scene(write_below(folder, "lost.obj", "mtllib lost.mtl\nusemtl a\n" + obj), leniently));
  // No face remains.
  write_below(folder, "none.obj", "v 0 0 0\nf 1 2 3\n");
  CHECK_THROWS_WITH_AS(read_scene(folder.path() / "none.obj", leniently),
                       doctest::Contains("no face is complete: line 2: a face refers to vertex 3, but there are 1"),
                       SceneError);
}

namespace {

const std::string kCube = "v -1 -1 -1\nv -1 -1 1\nv -1 1 -1\nv -1 1 1\nv 1 -1 -1\nv 1 -1 1\nv 1 1 -1\nv 1 1 1\n";
const std::string kCubeFaces = "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n";

/// The smallest cosine between the normals of a corner and of its triangle.
float smallest_cosine(const Mesh& mesh) {
  float smallest = 1;
  for (const auto& t : mesh.triangles) {
    const Vec3f normal =
        normalize(cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]));
    for (const std::uint32_t v : t) smallest = std::min(smallest, dot(normal, mesh.normals.at(v)));
  }
  return smallest;
}

float smallest_cosine_of(const std::string& name, const std::string& text) {
  const TemporaryFolder folder;
  write_below(folder, "look.mtl", "newmtl red\nKd 1 0 0\n");
  const Description d = read_scene(write_below(folder, name, text), on_floor());
  float smallest = 1;
  for (std::size_t i = 0; i + 1 < d.shapes.size(); ++i)  // the last is the floor
    smallest = std::min(smallest, smallest_cosine(std::get<Mesh>(d.shapes[i].geometry)));
  return smallest;
}

/// A square as PLY with properties of vertices and faces.
std::string square_ply(const std::string& comment, const std::string& vertex_properties, const std::string& vertex,
                       const std::string& face_properties = "", const std::string& face = "") {
  std::string text = "ply\nformat ascii 1.0\n" + comment +
                     "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n" + vertex_properties +
                     "element face 1\nproperty list uchar int vertex_indices\n" + face_properties + "end_header\n";
  for (const char* position : {"0 0 0", "1 0 0", "1 1 0", "0 1 0"}) text += std::string(position) + " " + vertex + "\n";
  return text + "4 0 1 2 3 " + face + "\n";
}

/// The texture of the model's first shape, or null if it is gray.
const TextureDescription* texture_of(const Description& d) {
  const auto& both =
      std::get<TwoSidedDescription>(d.materials.at(static_cast<std::size_t>(*d.shapes.at(0).material)).model);
  const auto& diffuse = std::get<DiffuseDescription>(d.materials.at(static_cast<std::size_t>(both.front)).model);
  const auto* id = std::get_if<TextureId>(&diffuse.reflectance);
  return id == nullptr ? nullptr : &d.textures.at(static_cast<std::size_t>(*id));
}

}  // namespace

TEST_CASE("model: a cube has flat faces without smoothing groups and is smooth in one group") {
  const float corner = 1 / std::sqrt(3.0f);
  CHECK(smallest_cosine_of("a.obj", kCube + "s off\n" + kCubeFaces) == near(1));
  CHECK(smallest_cosine_of("a.obj", kCube + "s 0\n" + kCubeFaces) == near(1));
  CHECK(smallest_cosine_of("a.obj", kCube + kCubeFaces) == near(1));
  CHECK(smallest_cosine_of("a.obj", kCube + "s 1\n" + kCubeFaces) == near(corner));
  CHECK(smallest_cosine_of("a.obj", "mtllib look.mtl\n" + kCube + "usemtl red\ns off\n" + kCubeFaces) == near(1));
  CHECK(smallest_cosine_of("a.obj", "mtllib look.mtl\n" + kCube +
                                        "s 1\nf 1 2 4 3\nf 5 7 8 6\nusemtl red\nf 1 5 6 2\n"
                                        "f 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\nf 1 1 2\n") == near(corner));
  std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 6\nproperty list uchar int vertex_indices\nend_header\n";
  for (std::size_t at = 0; at < kCube.size(); at = kCube.find('\n', at) + 1)
    ply += kCube.substr(at + 2, kCube.find('\n', at) - at - 1);
  ply += "4 0 1 3 2\n4 4 6 7 5\n4 0 4 5 1\n4 2 3 7 6\n4 0 2 6 4\n4 1 5 7 3\n";
  CHECK(smallest_cosine_of("a.ply", ply) == near(1));
}

TEST_CASE("model: normals of the file are kept") {
  const std::string normals = "vn -1 -1 -1\nvn 1 1 1\n", faces = "f 1//1 2//2 4//2 3//1\ns off\nf 1//1 5//2 6//2\n";
  CHECK(smallest_cosine_of("a.obj", kCube + normals + faces) < 0.6f);
}

TEST_CASE("model: colors of vertices and faces of PLY files are used") {
  const std::string floats = "property float red\nproperty float green\nproperty float blue\n";
  const std::string bytes = "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
  const TemporaryFolder folder;
  const auto check = [&](const std::string& text, const std::string& attribute) {
    const Description d = read_scene(write_below(folder, "a.ply", text));
    const TextureDescription* texture = texture_of(d);
    REQUIRE(texture != nullptr);
    CHECK(std::get<MeshAttributeDescription>(texture->model).name == attribute);
    const auto scene = compile_scene(d);
    CHECK(scene->warnings().empty());
    CHECK(scene->view().textures.attribute_values[1] == near(0.21586, 1e-4));
  };
  check(square_ply("", bytes, "255 128 0 255"), "vertex_color");
  check(square_ply("", floats, "1 0.21586 0"), "vertex_color");
  check(square_ply("", "", "", floats, "1 0.21586 0"), "face_color");
  check(square_ply("", floats, "1 0.21586 0", bytes, "0 0 0 0"), "vertex_color");
  CHECK(texture_of(read_scene(write_below(folder, "a.ply", square_ply("", "", "")))) == nullptr);
}

TEST_CASE("model: the image that a PLY file names is shown upright if it exists") {
  const TemporaryFolder folder;
  const std::string uv = "property float u\nproperty float v\n", comment = "comment TextureFile skin.png\n";
  const auto file = write_below(folder, "a.ply", square_ply(comment, uv, "0.25 0.25"));
  const Description without = read_scene(file);
  CHECK(texture_of(without) == nullptr);
  CHECK(std::any_of(without.notes.begin(), without.notes.end(),
                    [](const std::string& note) { return contains(note, "texture 'skin.png' not found"); }));
  write_below(folder, "skin.png", "");
  const Description d = read_scene(file);
  REQUIRE(texture_of(d) != nullptr);
  CHECK(std::get<BitmapDescription>(texture_of(d)->model).file.filename() == "skin.png");
  // v = 0.25 of the file is in the lower quarter of the image.
  const Vec2f uv_of_mesh = std::get<Mesh>(d.shapes[0].geometry).uvs[0];
  const std::array<float, 6>& to_uv = texture_of(d)->to_uv;
  CHECK(to_uv[0] * uv_of_mesh.x + to_uv[1] * uv_of_mesh.y + to_uv[2] == 0.25f);
  CHECK(to_uv[3] * uv_of_mesh.x + to_uv[4] * uv_of_mesh.y + to_uv[5] == 0.25f);
}

}  // namespace sheaf::test_model
