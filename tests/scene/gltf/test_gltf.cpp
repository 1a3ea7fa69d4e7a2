// glTF files: containers, accessors, triangles, and errors.
#include "scene/compile/compile.h"
#include "scene/dialects/read_model.h"
#include "tests/support/files/gltf_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <array>

namespace sheaf::test_gltf {

using namespace test;
using nlohmann::json;

namespace {

Description read_gltf_text(const std::string& text, const char* name = "model.gltf", const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  return read_scene(write_below(folder, name, text), options);
}
Description read_document(const GltfBuilder& gltf, const ReadOptions& options = {}) {
  return read_gltf_text(gltf.text(), "model.gltf", options);
}

std::string error_of_gltf(const std::string& text, const char* name = "model.gltf") {
  const TemporaryFolder folder;
  return error_of(write_below(folder, name, text));
}

const Mesh& first_mesh(const Description& d) {
  REQUIRE(!d.shapes.empty());
  return std::get<Mesh>(d.shapes.front().geometry);
}

using Triangle = std::array<std::uint32_t, 3>;

/// Five vertices in the order that strips and fans need.
GltfBuilder five_vertices(int mode) {
  GltfBuilder gltf;
  const int positions = gltf.add<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0}, "VEC3");
  gltf.add_mesh({{"POSITION", positions}})["mode"] = mode;
  gltf.json["nodes"] = {{{"mesh", 0}}};
  return gltf;
}

}  // namespace

TEST_CASE("gltf: text and binary containers give the same scene") {
  GltfBuilder gltf;
  gltf.add_triangle();
  const Description text = read_document(gltf), binary = read_gltf_text(gltf.binary(), "model.glb");
  CHECK(dump(text) == dump(binary));
  CHECK(first_mesh(text).positions[1].x == 1);
  CHECK(first_mesh(text).triangles == std::vector<Triangle>{{0, 1, 2}});
}

TEST_CASE("gltf: buffers in files are found by their escaped names") {
  GltfBuilder gltf;
  gltf.add_triangle();
  const std::string binary = gltf.binary();
  json document = json::parse(gltf.text());
  document["buffers"][0]["uri"] = "a%20buffer.bin";
  const TemporaryFolder folder;
  write_below(folder, "a buffer.bin", binary.substr(binary.size() - 36));
  const Description d = read_scene(write_below(folder, "model.gltf", document.dump()));
  CHECK(first_mesh(d).positions[2].y == 1);
  CHECK(d.files.size() == 2);
}

TEST_CASE("gltf: a model without camera and lights stands in a studio") {
  GltfBuilder gltf;
  gltf.add_triangle();
  CHECK(has_studio(read_document(gltf)));
  ReadOptions outdoors;
  outdoors.surroundings.studio = Studio::kSun;
  const Description d = read_document(gltf, outdoors);
  CHECK(d.shapes.size() == 2);
  CHECK(d.lights.size() == 2);
  ReadOptions bare;
  bare.surroundings.floor = false;
  CHECK(read_document(gltf, bare).shapes.size() == 1);
}

TEST_CASE("gltf: strips alternate their winding and fans share a vertex") {
  CHECK(first_mesh(read_document(five_vertices(5))).triangles ==
        std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}});
  CHECK(first_mesh(read_document(five_vertices(6))).triangles ==
        std::vector<Triangle>{{1, 2, 0}, {2, 3, 0}, {3, 4, 0}});
  CHECK(first_mesh(read_document(five_vertices(4))).triangles == std::vector<Triangle>{{0, 1, 2}});
  GltfBuilder lines = five_vertices(1);
  lines.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}});
  const Description d = read_document(lines);
  CHECK(first_mesh(d).triangles.size() == 1);
  CHECK(contains(d.notes.front(), "points or lines"));
}

TEST_CASE("gltf: indices of every unsigned type select vertices") {
  const auto check = [](auto index) {
    using Index = decltype(index);
    GltfBuilder gltf = five_vertices(4);
    gltf.json["meshes"][0]["primitives"][0]["indices"] = gltf.add<Index>({4, 2, 3}, "SCALAR");
    const Mesh mesh = first_mesh(read_document(gltf));
    REQUIRE(mesh.triangles.size() == 1);
    CHECK(mesh.positions[mesh.triangles[0][0]].y == 2);
    CHECK(mesh.positions[mesh.triangles[0][2]].x == 1);
  };
  check(std::uint8_t{});
  check(std::uint16_t{});
  check(std::uint32_t{});
}

TEST_CASE("gltf: normalized integers become fractions and others stay") {
  GltfBuilder gltf;
  json& primitive = gltf.add_triangle();
  const int positions = gltf.add<std::int16_t>({0, 0, 0, 300, 0, 0, 0, -400, 0}, "VEC3");
  const int normals = gltf.add<std::int8_t>({0, 0, 127, 0, 0, -128, 127, 0, 0}, "VEC3", true);
  const int uvs = gltf.add<std::uint16_t>({0, 0, 65535, 0, 0, 65535}, "VEC2", true);
  const int colors = gltf.add<std::uint8_t>({255, 0, 51, 255, 0, 0, 0, 0, 0, 0, 0, 128}, "VEC4", true);
  primitive["attributes"] = {{"POSITION", positions}, {"NORMAL", normals}, {"TEXCOORD_0", uvs}, {"COLOR_0", colors}};
  const Mesh mesh = first_mesh(read_document(gltf));
  CHECK(mesh.positions[1].x == 300);
  CHECK(mesh.positions[2].y == -400);
  CHECK(mesh.normals[0].z == 1);
  CHECK(mesh.normals[1].z == -1);
  CHECK(mesh.uvs[1].x == 1);
  CHECK(mesh.uvs[0].y == 1);  // v points upwards
  CHECK(mesh.uvs[2].y == 0);
  REQUIRE(mesh.attributes.size() == 2);
  CHECK(mesh.attributes[0].name == "vertex_color");
  CHECK(mesh.attributes[0].values[2] == near(0.2));
  CHECK(mesh.attributes[1].values[2] == near(128.0 / 255));
}

TEST_CASE("gltf: interleaved views are read with their stride") {
  GltfBuilder gltf;
  json& primitive = gltf.add_triangle();
  const std::vector<float> interleaved = {0, 0, 0, 9, 5, 0, 0, 9, 0, 7, 0, 9};
  const int view = gltf.add_view(interleaved.data(), interleaved.size() * 4);
  gltf.json["bufferViews"][static_cast<std::size_t>(view)]["byteStride"] = 16;
  gltf.json["accessors"].push_back({{"bufferView", view}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
  primitive["attributes"]["POSITION"] = gltf.json["accessors"].size() - 1;
  const Mesh mesh = first_mesh(read_document(gltf));
  CHECK(mesh.positions[1].x == 5);
  CHECK(mesh.positions[2].y == 7);
}

TEST_CASE("gltf: sparse elements replace those of the accessor") {
  GltfBuilder gltf;
  gltf.add_triangle();
  const std::vector<std::uint8_t> indices = {2};
  const std::vector<float> values = {0, 6, 0};
  const int index_view = gltf.add_view(indices.data(), 1), value_view = gltf.add_view(values.data(), 12);
  gltf.json["accessors"][0]["sparse"] = {{"count", 1},
                                         {"indices", {{"bufferView", index_view}, {"componentType", 5121}}},
                                         {"values", {{"bufferView", value_view}}}};
  const Mesh mesh = first_mesh(read_document(gltf));
  CHECK(mesh.positions[1].x == 1);
  CHECK(mesh.positions[2].y == 6);
}

TEST_CASE("gltf: invalid documents are errors that name the part") {
  GltfBuilder valid;
  valid.add_triangle();
  const json document = json::parse(valid.text());
  struct Case {
    const char* path;
    json value;
    const char* expected;
  };
  const std::vector<Case> cases = {
      {"/asset/version", "1.0", "version 1.0"},
      {"/extensionsRequired", {"EXT_unknown"}, "'EXT_unknown', which Sheaf does not support"},
      {"/accessors/0/count", 4, "accessors[0]: ends behind its buffer view"},
      {"/accessors/0/count", 4611686018427387904, "accessors[0]: ends behind"},
      {"/accessors/0/bufferView", 7, "'bufferView' is 7, but there are 1"},
      {"/accessors/0/componentType", 5124, "'componentType' is 5124"},
      {"/accessors/0/type", "VEC2", "has 2 numbers per element, expected 3"},
      {"/bufferViews/0/byteLength", 40, "bufferViews[0]: ends behind its buffer of 36 bytes"},
      {"/bufferViews/0/byteOffset", 18446744073709551615u, "bufferViews[0]: ends behind"},
      {"/bufferViews/0/buffer", 1, "'buffer' is 1"},
      {"/buffers/0/byteLength", 37, "has 36 bytes, but 'byteLength' is 37"},
      {"/buffers/0/uri", "http://example.org/a.bin", "expected a path relative to the file"},
      {"/buffers/0/uri", "/etc/passwd", "expected a path relative to the file"},
      {"/buffers/0/uri", "gone.bin", "not found"},
      {"/nodes/0/mesh", 3, "nodes[0]: 'mesh' is 3, but there are 1"},
      {"/nodes/0/children", {0}, "is no root"},
      {"/nodes/0/rotation", {0, 1}, "'rotation' has 2 numbers"},
      {"/scenes/0/nodes", {5}, "'nodes' is 5"},
      {"/scene", 2, "'scene' is 2"},
      {"/meshes/0/primitives/0/attributes/NORMAL", 9, "'NORMAL' is 9"},
      {"/meshes/0/primitives/0/material", 0, "'material' is 0, but there are 0"},
      {"/meshes/0/primitives/0/mode", 9, "'mode' is 9"},
  };
  for (const Case& c : cases) {
    json changed = document;
    changed[json::json_pointer(c.path)] = c.value;
    const std::string message = error_of_gltf(changed.dump());
    CAPTURE(c.path);
    CHECK_MESSAGE(contains(message, c.expected), message);
    CHECK((message.starts_with("model.gltf") || message.starts_with("gone.bin")));
  }
}

TEST_CASE("gltf: triangles with vertices out of range are errors, or dropped in lenient mode") {
  GltfBuilder gltf;
  json& primitive = gltf.add_triangle();
  primitive["indices"] = gltf.add<std::uint16_t>({0, 1, 2, 0, 1, 3}, "SCALAR");
  CHECK(contains(error_of_gltf(gltf.text()), "refers to vertex 3, but there are 3"));
  ReadOptions lenient;
  lenient.lenient = true;
  const Description d = read_document(gltf, lenient);
  CHECK(first_mesh(d).triangles.size() == 1);
  CHECK(contains(d.notes.front(), "1 triangles without vertices"));
}

TEST_CASE("gltf: malformed text is an error with its line, and broken containers are errors") {
  CHECK(contains(error_of_gltf("{\n\"asset\": {,}\n}"), "model.gltf:2: is not valid JSON"));
  CHECK(contains(error_of_gltf("[]"), "is no object"));
  CHECK(contains(error_of_gltf(std::string(5000, '[')), "model.gltf"));
  GltfBuilder gltf;
  gltf.add_triangle();
  const std::string binary = gltf.binary();
  CHECK(contains(error_of_gltf(binary.substr(0, binary.size() - 8), "model.glb"), "is truncated"));
  CHECK(contains(error_of_gltf(binary.substr(0, 16), "model.glb"), "is truncated"));
  std::string version = binary;
  version[4] = 1;
  CHECK(contains(error_of_gltf(version, "model.glb"), "has version 1"));
  gltf.json["nodes"] = json::array();
  gltf.json["scenes"] = {{{"nodes", json::array()}}};
  CHECK(contains(error_of_gltf(gltf.text()), "no triangles to render"));
}

}  // namespace sheaf::test_gltf
