// Skins of glTF: singular joints, and normals and tangents under joints of unequal scale.
#include "scene/compile/compile.h"
#include "scene/dialects/gltf/pose.h"
#include "tests/support/files/gltf_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_gltf_skins {

using namespace test;
using nlohmann::json;

namespace {

Description read_document(const GltfBuilder& gltf, const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  return read_scene(write_below(folder, "model.gltf", gltf.text()), options);
}

ReadOptions at_time(double time, bool opens = false) {
  ReadOptions options;
  options.moment = {time, {}};
  if (opens) options.shutter = ShutterDescription{0, 1, 0};
  return options;
}

void check_vector(Vec3f found, Vec3f expected) {
  CHECK(found.x == within(expected.x, 1e-5));
  CHECK(found.y == within(expected.y, 1e-5));
  CHECK(found.z == within(expected.z, 1e-5));
}

/// Two triangles (0, 0, 0), (1, 0, 0), (0, 1, 0) with normals and tangents, the first one at the node 1, the second one
/// at the node 2, whose child is the node 3.
GltfBuilder two_joints() {
  GltfBuilder gltf;
  json& primitive =
      gltf.add_mesh({{"POSITION", gltf.add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3")}});
  const float c = std::sqrt(0.5f);
  std::vector<float> normals, tangents;
  std::vector<std::uint8_t> joints;
  std::vector<float> weights;
  for (std::uint8_t i = 0; i < 6; ++i) {
    normals.insert(normals.end(), {0, c, c});
    tangents.insert(tangents.end(), {0, c, -c, 1});
    joints.insert(joints.end(), {static_cast<std::uint8_t>(i / 3), 0, 0, 0});
    weights.insert(weights.end(), {1, 0, 0, 0});
  }
  primitive["attributes"]["NORMAL"] = gltf.add(normals, "VEC3");
  primitive["attributes"]["TANGENT"] = gltf.add(tangents, "VEC4");
  primitive["attributes"]["JOINTS_0"] = gltf.add(joints, "VEC4");
  primitive["attributes"]["WEIGHTS_0"] = gltf.add(weights, "VEC4");
  primitive["material"] = 0;
  gltf.json["materials"] = {{{"extensions", {{"KHR_materials_anisotropy", {{"anisotropyStrength", 1}}}}}}};
  gltf.json["nodes"] = {{{"mesh", 0}, {"skin", 0}}, {{"name", "arm"}}, {{"children", {3}}}, json::object()};
  gltf.json["scenes"][0]["nodes"] = {0, 1, 2};
  gltf.json["skins"] = {{{"joints", {1, 2}}}};
  return gltf;
}

const Mesh& first_mesh(const Description& d) { return std::get<Mesh>(d.shapes.at(0).geometry); }

/// Where a vertex of the first mesh is in the scene.
Vec3f position_of(const Description& d, std::uint32_t vertex) {
  return d.shapes.at(0).to_world.point(first_mesh(d).positions.at(vertex));
}

/// Animates the scale of a node from `first` to `last` within a second.
void animate_scale(GltfBuilder& gltf, int node, const std::vector<float>& values) {
  const int times = gltf.add<float>({0, 1}, "SCALAR"), output = gltf.add(values, "VEC3");
  gltf.json["animations"].push_back({{"channels", {{{"sampler", 0}, {"target", {{"node", node}, {"path", "scale"}}}}}},
                                     {"samplers", {{{"input", times}, {"output", output}}}}});
}

}  // namespace

TEST_CASE("gltf skins: normals go by the inverse transpose, tangents as vectors, mirrors turn the handedness") {
  GltfBuilder gltf = two_joints();
  gltf.json["nodes"][1]["scale"] = {1, 2, 1};
  gltf.json["nodes"][2]["scale"] = {1, -2, 1};
  const Mesh mesh = first_mesh(read_document(gltf));
  REQUIRE(mesh.positions.size() == 6);
  const auto direction = [](Vec3f v) { return v / length(v); };
  const float long_side = 2 / std::sqrt(5.0f), short_side = 1 / std::sqrt(5.0f);
  check_vector(direction(mesh.normals[0]), {0, short_side, long_side});
  check_vector(direction(mesh.tangents.at(0).direction), {0, long_side, -short_side});
  CHECK(mesh.tangents.at(0).handedness == 1);
  check_vector(direction(mesh.normals[3]), {0, -short_side, long_side});
  check_vector(direction(mesh.tangents.at(3).direction), {0, -long_side, -short_side});
  CHECK(mesh.tangents.at(3).handedness == -1);
}

TEST_CASE("gltf skins: a joint of scale zero collapses its vertices") {
  GltfBuilder gltf = two_joints();
  gltf.json["nodes"][1]["translation"] = {0, 2, 0};
  gltf.json["nodes"][2]["scale"] = {0, 0, 0};
  gltf.json["nodes"][2]["translation"] = {5, 0, 0};
  const auto check = [&] {
    const Description d = read_document(gltf);
    const Mesh& mesh = first_mesh(d);
    REQUIRE(mesh.triangles.size() == 1);
    check_vector(position_of(d, mesh.triangles[0][1]), {1, 2, 0});
    CHECK(compile_scene(d)->info().triangles > 0);
  };
  check();
  // Also joints below it
  gltf.json["nodes"][3]["translation"] = {0, 3, 0};
  gltf.json["skins"][0]["joints"] = {1, 3};
  check();
  // A vertex between two joints goes half of the way
  gltf.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] =
      gltf.add<std::uint8_t>({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  const std::vector<float> halves = {0.5f, 0.5f, 0, 0, 0.5f, 0.5f, 0, 0, 0.5f, 0.5f, 0, 0,
                                     1,    0,    0, 0, 1,    0,    0, 0, 1,    0,    0, 0};
  gltf.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = gltf.add(halves, "VEC4");
  const Description d = read_document(gltf);
  REQUIRE(first_mesh(d).triangles.size() == 1);
  check_vector(position_of(d, first_mesh(d).triangles[0][1]), {3, 1, 0});
}

TEST_CASE("gltf skins: a mesh that collapses as a whole leaves an empty image, if there is a camera") {
  GltfBuilder gltf = two_joints();
  gltf.json["nodes"][1]["scale"] = {0, 0, 0};
  gltf.json["nodes"][2]["scale"] = {0, 0, 0};
  CHECK_THROWS_WITH_AS(read_document(gltf), doctest::Contains("no triangles to render"), SceneError);
  gltf.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}}};
  gltf.json["nodes"].push_back({{"camera", 0}});
  gltf.json["scenes"][0]["nodes"].push_back(4);
  const Description d = read_document(gltf);
  CHECK(d.shapes.empty());
  REQUIRE(!d.notes.empty());
  CHECK(contains(d.notes.back(), "no triangles to render"));
  CHECK(compile_scene(d)->info().triangles == 0);
}

TEST_CASE("gltf skins: joints that are flat give finite normals of the plane") {
  GltfBuilder gltf = two_joints();
  gltf.json["nodes"][1]["scale"] = {1, 1, 0};
  gltf.json["nodes"][2]["scale"] = {0, 1, 1};
  const Description d = read_document(gltf);
  const Mesh& mesh = first_mesh(d);
  REQUIRE(mesh.triangles.size() == 1);  // the other one is seen from its edge
  for (const Vec3f n : mesh.normals) check_vector(n, {0, 0, 1});
  compile_scene(d);
}

TEST_CASE("gltf skins: joints that reach a scale of zero by animation") {
  GltfBuilder gltf = two_joints();
  animate_scale(gltf, 2, {1, 1, 1, 0, 0, 0});
  CHECK(first_mesh(read_document(gltf, at_time(0))).triangles.size() == 2);
  CHECK(first_mesh(read_document(gltf, at_time(1))).triangles.size() == 1);
  // While the shutter is open
  const Description d = read_document(gltf, at_time(0, true));
  const auto& mesh = std::get<DeformingMesh>(d.shapes.at(0).geometry);
  REQUIRE(mesh.keys.size() >= 2);
  const Mesh &first = std::get<Mesh>(mesh.keys.front().mesh), &last = std::get<Mesh>(mesh.keys.back().mesh);
  check_vector(first.positions.at(4), {1, 0, 0});
  check_vector(last.positions.at(4), {0, 0, 0});
  for (const DeformingMesh::Key& key : mesh.keys)
    for (const Vec3f n : std::get<Mesh>(key.mesh).normals) CHECK(is_finite(n));
  CHECK(compile_scene(d)->info().triangles >= 2);
}

TEST_CASE("gltf skins: nodes that are flat keep their plane, nodes that collapse are left out with a note") {
  GltfBuilder gltf;
  json& primitive = gltf.add_triangle();
  primitive["attributes"]["NORMAL"] = gltf.add<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  const float half = std::sqrt(0.5f);
  // The parent turns z to x, and flattens x after that
  gltf.json["nodes"][0]["rotation"] = {0, half, 0, half};
  gltf.json["nodes"].push_back({{"children", {0}}, {"scale", {0, 1, 1}}, {"translation", {3, 0, 0}}});
  gltf.json["scenes"][0]["nodes"] = {1};
  const Description d = read_document(gltf);
  CHECK(d.notes.empty());
  check_vector(d.shapes.at(0).to_world.point({1, 0, 0}), {3, 0, -1});
  check_vector(d.shapes.at(0).to_world.point({0, 1, 1}), {3, 1, 0});
  // An instance
  gltf.json["nodes"].push_back({{"mesh", 0}, {"scale", {1, 1, 0}}});
  gltf.json["scenes"][0]["nodes"] = {1, 2};
  CHECK(read_document(gltf).instances.size() == 2);
  gltf.json["nodes"][2]["scale"] = {1, 0, 0};
  const Description e = read_document(gltf);
  CHECK(e.instances.size() == 1);
  REQUIRE(e.notes.size() == 1);
  CHECK(contains(e.notes[0], "nodes[2]: its transform collapses it to a line or a point (not rendered)"));
}

TEST_CASE("gltf skins: lights and cameras below nodes of scale zero keep their directions") {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "directional"}},
                                                              {{"type", "spot"}, {"spot", json::object()}}};
  gltf.json["cameras"] = {
      {{"type", "orthographic"}, {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0.1}, {"zfar", 9}}}}};
  const float half = std::sqrt(0.5f);
  gltf.json["nodes"].push_back({{"scale", {0, 0, 0}}, {"rotation", {0, half, 0, half}}, {"children", {2, 3, 4}}});
  for (const int light : {0, 1})
    gltf.json["nodes"].push_back(
        {{"translation", {0, 0, 4}}, {"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}});
  gltf.json["nodes"].push_back({{"camera", 0}});
  gltf.json["scenes"][0]["nodes"] = {0, 1};
  const Description d = read_document(gltf);
  REQUIRE(d.lights.size() == 2);
  check_vector(std::get<DirectionalLightDescription>(d.lights[0].model).direction, {-1, 0, 0});
  const Transform& spot = std::get<SpotLightDescription>(d.lights[1].model).to_world;
  check_vector(spot.point({0, 0, 0}), {0, 0, 0});
  check_vector(spot.vector({0, 0, 1}), {-1, 0, 0});
  check_vector(d.camera.to_world.vector({0, 0, 1}), {-1, 0, 0});
}

}  // namespace sheaf::test_gltf_skins
