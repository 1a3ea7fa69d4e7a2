// glTF meshes and buffers compressed by Draco and meshoptimizer. The encoders of both libraries make the data.
#include "scene/formats/draco.h"
#include "scene/formats/meshopt.h"
#include "tests/support/files/gltf_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#ifdef SHEAF_HAS_DRACO
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#endif
#ifdef SHEAF_HAS_MESHOPT
#include <meshoptimizer.h>
#endif

#include <algorithm>
#include <cmath>

namespace sheaf::test_gltf_compression {

using namespace test;
using nlohmann::json;

namespace {

[[maybe_unused]] const Mesh& first_mesh(const Description& d) {
  REQUIRE(!d.shapes.empty());
  return std::get<Mesh>(d.shapes.front().geometry);
}

#ifdef SHEAF_HAS_DRACO

/// Two triangles with positions and texture coordinates.
std::vector<char> encode_square() {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2);
  const int positions = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int uvs = builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32);
  const float p[4][3] = {{0, 0, 0}, {4, 0, 0}, {4, 2, 0}, {0, 2, 0}};
  const float t[4][2] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
  const int corners[2][3] = {{0, 1, 2}, {0, 2, 3}};
  for (int f = 0; f < 2; ++f) {
    const int* c = corners[f];
    builder.SetAttributeValuesForFace(positions, draco::FaceIndex(static_cast<std::uint32_t>(f)), p[c[0]], p[c[1]],
                                      p[c[2]]);
    builder.SetAttributeValuesForFace(uvs, draco::FaceIndex(static_cast<std::uint32_t>(f)), t[c[0]], t[c[1]], t[c[2]]);
  }
  const auto mesh = builder.Finalize();
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
  draco::EncoderBuffer buffer;
  REQUIRE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  return {buffer.data(), buffer.data() + buffer.size()};
}

GltfBuilder draco_square(const std::vector<char>& bytes) {
  GltfBuilder gltf;
  const int view = gltf.add_view(bytes.data(), bytes.size());
  gltf.json["accessors"] = {{{"componentType", 5126}, {"count", 4}, {"type", "VEC3"}},
                            {{"componentType", 5126}, {"count", 4}, {"type", "VEC2"}},
                            {{"componentType", 5123}, {"count", 6}, {"type", "SCALAR"}}};
  json& primitive = gltf.add_mesh({{"POSITION", 0}, {"TEXCOORD_0", 1}});
  primitive["indices"] = 2;
  primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", view},
                                                           {"attributes", {{"POSITION", 0}, {"TEXCOORD_0", 1}}}};
  gltf.json["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  gltf.json["nodes"] = {{{"mesh", 0}}};
  return gltf;
}

Description read_document(const GltfBuilder& gltf) {
  const TemporaryFolder folder;
  return read_scene(write_below(folder, "model.gltf", gltf.text()), {});
}

#endif

#ifdef SHEAF_HAS_MESHOPT

std::vector<float> decompressed(const MeshoptCompression& compression, const std::vector<unsigned char>& bytes) {
  const auto decoded = decode_meshopt(compression, bytes);
  REQUIRE(decoded);
  std::vector<float> out(decoded->size() / sizeof(float));
  std::memcpy(out.data(), decoded->data(), decoded->size());
  return out;
}

#endif

}  // namespace

#ifdef SHEAF_HAS_DRACO

TEST_CASE("gltf: meshes compressed by Draco have their triangles and attributes") {
  const Mesh mesh = first_mesh(read_document(draco_square(encode_square())));
  REQUIRE(mesh.triangles.size() == 2);
  REQUIRE(mesh.positions.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    // u runs with x, and v, which points upwards, with y.
    CHECK(mesh.uvs[i].x == near(mesh.positions[i].x / 4, 1e-2));
    CHECK(mesh.uvs[i].y == near(mesh.positions[i].y / 2, 1e-2));
  }
}

TEST_CASE("gltf: broken Draco data is an error") {
  const std::vector<char> valid = encode_square();
  for (std::size_t size : {std::size_t{0}, std::size_t{5}, valid.size() / 2}) {
    std::vector<char> bytes(valid.begin(), valid.begin() + static_cast<std::ptrdiff_t>(size));
    bytes.push_back(0);
    CHECK_THROWS_WITH_AS(read_document(draco_square(bytes)), doctest::Contains("compressed by Draco is invalid"),
                         SceneError);
  }
  GltfBuilder gltf = draco_square(valid);
  gltf.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] = 7;
  CHECK_THROWS_AS(read_document(gltf), SceneError);
}

#endif

#ifdef SHEAF_HAS_MESHOPT

TEST_CASE("gltf: buffers compressed by meshoptimizer are decompressed") {
  std::vector<float> vertices;
  for (int i = 0; i < 300; ++i) vertices.insert(vertices.end(), {float(i), float(i % 7), 1.0f});
  std::vector<unsigned char> bytes(meshopt_encodeVertexBufferBound(300, 12));
  bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), vertices.data(), 300, 12));
  CHECK(decompressed({300, 12, "ATTRIBUTES"}, bytes) == vertices);
  CHECK_FALSE(decode_meshopt({300, 16, "ATTRIBUTES"}, std::span(bytes).first(bytes.size() / 2)));
  CHECK_FALSE(decode_meshopt({300, 13, "ATTRIBUTES"}, bytes));
  CHECK_FALSE(decode_meshopt({std::size_t{1} << 40, 12, "ATTRIBUTES"}, bytes));
  CHECK_FALSE(decode_meshopt({300, 12, "UNKNOWN"}, bytes));
  CHECK_FALSE(decode_meshopt({0, 12, "ATTRIBUTES"}, bytes));
}

TEST_CASE("gltf: compressed views replace their buffers") {
  std::vector<float> vertices = {0, 0, 0, 2, 0, 0, 0, 3, 0};
  std::vector<unsigned char> bytes(meshopt_encodeVertexBufferBound(3, 12));
  bytes.resize(meshopt_encodeVertexBuffer(bytes.data(), bytes.size(), vertices.data(), 3, 12));
  GltfBuilder gltf;
  gltf.add_triangle();
  const int packed = gltf.add_view(bytes.data(), bytes.size());
  gltf.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {
      {"buffer", 0},
      {"byteOffset", gltf.json["bufferViews"][static_cast<std::size_t>(packed)]["byteOffset"]},
      {"byteLength", bytes.size()},
      {"byteStride", 12},
      {"count", 3},
      {"mode", "ATTRIBUTES"}};
  const TemporaryFolder folder;
  const Description d = read_scene(write_below(folder, "model.gltf", gltf.text()), {});
  CHECK(first_mesh(d).positions[2].y == 3);
}

#endif

}  // namespace sheaf::test_gltf_compression
