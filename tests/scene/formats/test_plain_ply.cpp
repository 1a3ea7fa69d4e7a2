// Large PLY files of the most common layout: read by all threads to the same mesh as by the general reader.
#include "tests/scene/formats/ply_files.h"
#include "tests/support/files/mesh_files.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>

namespace sheaf::test_plain_ply {

using namespace test;
using namespace ply_files;

namespace {

constexpr int kSide = 250;  // rows and columns of a grid: more than 2 MB, and several reads of each element
constexpr int kVertices = (kSide + 1) * (kSide + 1), kFaces = 2 * kSide * kSide;

/// What differs from a grid without defects.
struct Variant {
  bool is_general = false;    ///< with numbers of corners of 32 bits, which only the general reader reads
  std::int32_t last = -1;     ///< last corner of the last triangle, unless negative
  bool has_quad = false;      ///< the first two triangles are a quadrangle
  std::size_t missing = 0;    ///< bytes at the end
  bool has_infinity = false;  ///< in a normal and in a texture coordinate
};

std::string file_of(const Variant& variant) {
  Body body(Body::Encoding::kLittle);
  for (int i = 0; i < kVertices; ++i) {
    const auto x = static_cast<float>(i % (kSide + 1)), y = static_cast<float>(i / (kSide + 1));
    const float odd = variant.has_infinity && i == 7 ? std::numeric_limits<float>::infinity() : 0.25f;
    body.put(odd).put(x / kSide).put(y / kSide).put(x).put(y).put(x * y).put(0.0f).put(odd);
  }
  const auto put_face = [&](std::initializer_list<std::int32_t> corners) {
    if (variant.is_general) {
      body.put(static_cast<std::int32_t>(corners.size()));
    } else {
      body.put(static_cast<std::uint8_t>(corners.size()));
    }
    for (const std::int32_t corner : corners) body.put(corner);
  };
  for (int i = 0; i < kSide * kSide; ++i) {
    const int a = i / kSide * (kSide + 1) + i % kSide, b = a + kSide + 1;
    const bool is_last = i == kSide * kSide - 1 && variant.last >= 0;
    if (variant.has_quad && i == 0) {
      put_face({a, a + 1, b + 1, b});
      continue;
    }
    put_face({a, a + 1, b + 1});
    put_face({a, b + 1, is_last ? variant.last : b});
  }
  std::string text =
      "ply\nformat binary_little_endian 1.0\ncomment TextureFile skin.png\nelement vertex " +
      std::to_string(kVertices) +
      "\nproperty float u\nproperty float nx\nproperty float ny\nproperty float x\nproperty float y\nproperty float z\n"
      "property float nz\nproperty float t\nelement face " +
      std::to_string(variant.has_quad ? kFaces - 1 : kFaces) + "\nproperty list " +
      (variant.is_general ? "int" : "uchar") + " int vertex_indices\nend_header\n" + body.text();
  text.resize(text.size() - variant.missing);
  return text;
}

}  // namespace

TEST_CASE("plain ply: the mesh is that of the general reader") {
  for (const bool has_infinity : {false, true})
    for (const bool flip : {false, true}) {
      const MeshFile plain = read(file_of({.has_infinity = has_infinity}), flip);
      const MeshFile general = read(file_of({.is_general = true, .has_infinity = has_infinity}), flip);
      CHECK(plain.mesh.positions.size() == kVertices);
      CHECK(plain.mesh.positions == general.mesh.positions);
      CHECK(plain.mesh.normals == general.mesh.normals);
      const auto same_uv = [](Vec2f a, Vec2f b) { return a.x == b.x && a.y == b.y; };
      CHECK(plain.mesh.uvs.size() == kVertices);
      CHECK(std::equal(plain.mesh.uvs.begin(), plain.mesh.uvs.end(), general.mesh.uvs.begin(), general.mesh.uvs.end(),
                       same_uv));
      CHECK(plain.mesh.triangles.size() == kFaces);
      CHECK(plain.mesh.triangles == general.mesh.triangles);
      CHECK(plain.texture == "skin.png");
      CHECK(plain.texture == general.texture);
      CHECK(plain.is_split == general.is_split);
      CHECK(plain.warnings.empty());
    }
}

TEST_CASE("plain ply: other large files and defects are left to the general reader") {
  CHECK(read(file_of({.has_quad = true})).mesh.triangles.size() == kFaces);
  const std::string bad_index = error_in(file_of({.last = kVertices}));
  CHECK(contains(bad_index, "row 124999 of element 'face'"));
  CHECK(contains(bad_index, "expected the index of one of 63001 vertices, found 63001"));
  CHECK(contains(error_in(file_of({.missing = 1})), "the file is truncated"));
}

}  // namespace sheaf::test_plain_ply
