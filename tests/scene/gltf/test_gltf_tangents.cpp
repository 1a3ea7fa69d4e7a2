// Tangents of glTF meshes: their attribute in all of its forms, and their way through meshes and deformations.
#include "scene/compile/compile.h"
#include "scene/compile/geometry/kept_geometry.h"
#include "scene/formats/draco.h"
#include "scene/formats/mesh.h"
#include "tests/support/files/gltf_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#ifdef SHEAF_HAS_DRACO
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#endif

#include <cmath>

namespace sheaf::test_gltf_tangents {

using namespace test;
using nlohmann::json;

namespace {

Description read_document(const GltfBuilder& gltf, const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  return read_scene(write_below(folder, "model.gltf", gltf.text()), options);
}

/// A triangle with normals along z and an anisotropic material.
GltfBuilder triangle() {
  GltfBuilder gltf;
  json& primitive = gltf.add_triangle();
  primitive["attributes"]["NORMAL"] = gltf.add<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  primitive["material"] = 0;
  gltf.json["materials"] = {{{"extensions", {{"KHR_materials_anisotropy", {{"anisotropyStrength", 1}}}}}}};
  return gltf;
}

json& attributes(GltfBuilder& gltf) { return gltf.json["meshes"][0]["primitives"][0]["attributes"]; }

int add_float_tangents(GltfBuilder& gltf) {
  return gltf.add<float>({0.6f, 0.8f, 0, -1, 0.6f, 0.8f, 0, -1, 0.6f, 0.8f, 0, -1}, "VEC4");
}

const Mesh& first_mesh(const Description& d) { return std::get<Mesh>(d.shapes.at(0).geometry); }

void check_tangents(const Mesh& mesh, float x, float y, float handedness, double tolerance) {
  REQUIRE(mesh.tangents.size() == mesh.positions.size());
  REQUIRE(mesh.tangents.size() == 3);
  for (const MeshTangent& t : mesh.tangents) {
    CHECK(t.direction.x == within(x, tolerance));
    CHECK(t.direction.y == within(y, tolerance));
    CHECK(t.direction.z == within(0, tolerance));
    CHECK(t.handedness == handedness);
  }
}

}  // namespace

TEST_CASE("gltf tangents: floats, and normalized bytes and shorts (KHR_mesh_quantization)") {
  GltfBuilder gltf = triangle();
  attributes(gltf)["TANGENT"] = add_float_tangents(gltf);
  check_tangents(first_mesh(read_document(gltf)), 0.6f, 0.8f, -1, 1e-6);
  attributes(gltf)["TANGENT"] =
      gltf.add<std::int8_t>({76, 102, 0, -127, 76, 102, 0, -127, 76, 102, 0, -127}, "VEC4", true);
  check_tangents(first_mesh(read_document(gltf)), 0.6f, 0.8f, -1, 0.005);
  attributes(gltf)["TANGENT"] =
      gltf.add<std::int16_t>({19660, 26214, 0, 32767, 19660, 26214, 0, 32767, 19660, 26214, 0, 32767}, "VEC4", true);
  check_tangents(first_mesh(read_document(gltf)), 0.6f, 0.8f, 1, 1e-4);
}

TEST_CASE("gltf tangents: ignored without normals, and by materials that have no use for them") {
  GltfBuilder gltf = triangle();
  attributes(gltf)["TANGENT"] = add_float_tangents(gltf);
  const int normals = attributes(gltf)["NORMAL"];
  attributes(gltf).erase("NORMAL");
  CHECK(first_mesh(read_document(gltf)).tangents.empty());
  attributes(gltf)["NORMAL"] = normals;
  gltf.json["materials"] = {{{"name", "plain"}}};
  CHECK(first_mesh(read_document(gltf)).tangents.empty());
  CHECK(compile_scene(read_document(gltf))->view().geometry.tangents == nullptr);
}

TEST_CASE("gltf tangents: morph targets change them, but not their handedness") {
  GltfBuilder gltf = triangle();
  attributes(gltf)["TANGENT"] = add_float_tangents(gltf);
  gltf.json["meshes"][0]["primitives"][0]["targets"] = {
      {{"TANGENT", gltf.add<float>({-1.2f, 0, 0, -1.2f, 0, 0, -1.2f, 0, 0}, "VEC3")}}};
  gltf.json["meshes"][0]["weights"] = {0.5};
  check_tangents(first_mesh(read_document(gltf)), 0, 0.8f, -1, 1e-6);
  // While the shutter is open
  const int times = gltf.add<float>({0, 1}, "SCALAR"), weights = gltf.add<float>({0, 1}, "SCALAR");
  gltf.json["animations"] = {{{"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}},
                              {"samplers", {{{"input", times}, {"output", weights}}}}}};
  ReadOptions options;
  options.moment = {0, {}};
  options.shutter = ShutterDescription{0, 1, 0};
  const Description d = read_document(gltf, options);
  const auto& mesh = std::get<DeformingMesh>(d.shapes.at(0).geometry);
  check_tangents(std::get<Mesh>(mesh.keys.front().mesh), 0.6f, 0.8f, -1, 1e-6);
  check_tangents(std::get<Mesh>(mesh.keys.back().mesh), -0.6f, 0.8f, -1, 1e-6);
  const auto scene = compile_scene(d);
  const GeometryView& geometry = scene->view().geometry;
  REQUIRE(geometry.tangents != nullptr);
  const std::uint32_t first = geometry.shapes[0].first_vertex;
  CHECK(geometry.tangents[first].direction.x == near(0.6));
  CHECK(geometry.tangents[first + 3].direction.x == near(-0.6));
}

TEST_CASE("gltf tangents: meshes without tangents beside others have none") {
  GltfBuilder gltf = triangle();
  const json plain = attributes(gltf);
  attributes(gltf)["TANGENT"] = add_float_tangents(gltf);
  for (const json& other : {plain, attributes(gltf), plain}) {
    gltf.add_mesh(other)["material"] = 0;
    gltf.json["nodes"].push_back({{"mesh", gltf.json["meshes"].size() - 1}});
    gltf.json["scenes"][0]["nodes"].push_back(gltf.json["nodes"].size() - 1);
  }
  const auto scene = compile_scene(read_document(gltf));
  const GeometryView& geometry = scene->view().geometry;
  REQUIRE(geometry.shape_count >= 4);
  REQUIRE(geometry.tangents != nullptr);
  for (std::uint32_t shape = 0; shape < 4; ++shape)
    for (std::uint32_t k = 0; k < 3; ++k) {
      const TangentRow& row = geometry.tangents[geometry.shapes[shape].first_vertex + k];
      CHECK(row.direction.x == within(shape % 2 == 0 ? 0.6 : 0, 1e-6));
      CHECK(row.handedness == (shape % 2 == 0 ? -1 : 0));
    }
}

TEST_CASE("gltf tangents: meshes keep the bitangent when they are mirrored or turned inside out") {
  const Mesh original{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                      {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}},
                      {},
                      {{0, 1, 2}},
                      {},
                      {{{1, 0, 0}, -1}, {{1, 0, 0}, -1}, {{1, 0, 0}, -1}}};
  const auto bitangent = [](const Mesh& mesh) {
    const MeshTangent& t = mesh.tangents.at(0);
    return cross(mesh.normals.at(0), t.direction) * t.handedness;
  };
  CHECK(bitangent(original).y == -1);
  Mesh mesh = original;
  transform_mesh(mesh, Transform::scale({-2, 3, 1}));
  CHECK(mesh.tangents[0].direction.x == -1);
  CHECK(bitangent(mesh).y == -1);
  transform_mesh(mesh, Transform::scale({1, -1, 1}));
  CHECK(bitangent(mesh).y == 1);
  flip_mesh(mesh);
  CHECK(mesh.normals[0].z == -1);
  CHECK(bitangent(mesh).y == 1);
  append_vertex_copies(mesh, {2});
  CHECK(mesh.tangents.size() == 4);
  CHECK(extract_triangles(mesh, {0}).tangents.size() == 3);
  mesh.tangents.pop_back();
  CHECK_THROWS_WITH_AS(check_mesh(mesh, {}), doctest::Contains("3 tangents for 4 vertices"), SceneError);
}

TEST_CASE("gltf tangents: frames that keep the geometry get their own tangents") {
  KeptGeometry kept;
  CompileOptions options;
  options.kept = &kept;
  const auto compile = [&](float x, float y) {
    GltfBuilder gltf = triangle();
    attributes(gltf)["TANGENT"] = gltf.add<float>({x, y, 0, 1, x, y, 0, 1, x, y, 0, 1}, "VEC4");
    return compile_scene(read_document(gltf), options);
  };
  std::unique_ptr<Scene> scene = compile(1, 0);
  const VertexRow* const vertices = scene->view().geometry.vertices;
  keep_geometry(std::move(scene), kept);
  scene = compile(0, 1);
  CHECK(scene->view().geometry.vertices == vertices);
  REQUIRE(scene->view().geometry.tangents != nullptr);
  CHECK(scene->view().geometry.tangents[0].direction.y == 1);
}

#ifdef SHEAF_HAS_DRACO

TEST_CASE("gltf tangents: of meshes compressed by Draco") {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(1);
  const int positions = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int normals = builder.AddAttribute(draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32);
  const int tangents = builder.AddAttribute(draco::GeometryAttribute::GENERIC, 4, draco::DT_FLOAT32);
  const float p[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, n[3] = {0, 0, 1}, t[4] = {0.6f, 0.8f, 0, -1};
  const draco::FaceIndex face(0);
  builder.SetAttributeValuesForFace(positions, face, p[0], p[1], p[2]);
  builder.SetAttributeValuesForFace(normals, face, n, n, n);
  builder.SetAttributeValuesForFace(tangents, face, t, t, t);
  draco::Encoder encoder;
  draco::EncoderBuffer buffer;
  REQUIRE(encoder.EncodeMeshToBuffer(*builder.Finalize(), &buffer).ok());
  GltfBuilder gltf = triangle();
  const int view = gltf.add_view(buffer.data(), buffer.size());
  const auto add = [&](const char* type) {
    gltf.json["accessors"].push_back({{"componentType", 5126}, {"count", 3}, {"type", type}});
    return gltf.json["accessors"].size() - 1;
  };
  json& primitive = gltf.json["meshes"][0]["primitives"][0];
  primitive["attributes"] = {{"POSITION", add("VEC3")}, {"NORMAL", add("VEC3")}, {"TANGENT", add("VEC4")}};
  primitive["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", view}, {"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"TANGENT", 2}}}};
  check_tangents(first_mesh(read_document(gltf)), 0.6f, 0.8f, -1, 1e-6);
}

#endif

}  // namespace sheaf::test_gltf_tangents
