// The pbrt dialect: meshes in the scene file, and tessellation of curved surfaces.
#include "scene/dialects/pbrt/reader.h"
#include "scene/formats/loop_subdivision.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sheaf::pbrt {

namespace {

/// Quads along each side of a non-planar bilinear patch.
constexpr int kPatchSteps = 16;

std::vector<Vec3f> read_vectors(Parameters& p, const char* name) {
  const std::vector<float> n = p.numbers(name, 3);
  std::vector<Vec3f> vectors;
  for (std::size_t i = 0; i < n.size(); i += 3) vectors.push_back({n[i], n[i + 1], n[i + 2]});
  return vectors;
}

std::vector<Vec2f> read_coordinates(Parameters& p) {
  const char* name = p.has("uv") ? "uv" : "st";
  const std::vector<float> n = p.numbers(name, 2);
  std::vector<Vec2f> coordinates;
  for (std::size_t i = 0; i < n.size(); i += 2) coordinates.push_back({n[i], n[i + 1]});
  return coordinates;
}

/// Reads the indices of `corners` vertices per face. Without indices, one face uses the vertices in order.
std::vector<std::uint32_t> read_indices(Parameters& p, std::size_t vertices, std::size_t corners) {
  const Parameter* list = p.find("indices");
  std::vector<std::uint32_t> indices;
  if (list == nullptr) {
    if (vertices != corners) p.fail(fmt::format("has no 'indices' and {} vertices, expected indices", vertices));
    for (std::uint32_t i = 0; i < corners; ++i) indices.push_back(i);
    return indices;
  }
  if (list->type != "integer" || list->numbers.size() % corners != 0)
    p.fail_at("indices",
              fmt::format("has {} values, expected integers, a multiple of {}", list->numbers.size(), corners));
  for (const double index : list->numbers) {
    if (index < 0 || index >= static_cast<double>(vertices))
      p.fail_at("indices",
                fmt::format("has {}, expected an index of {} vertices", static_cast<long long>(index), vertices));
    indices.push_back(static_cast<std::uint32_t>(index));
  }
  return indices;
}

/// Reads P, N and uv of a mesh; ignores unused parameters.
Mesh read_vertices(Parameters& p) {
  Mesh mesh;
  mesh.positions = read_vectors(p, "P");
  mesh.normals = read_vectors(p, "N");
  mesh.uvs = read_coordinates(p);
  if (mesh.positions.empty()) p.fail("needs the points 'P'");
  for (const auto& [name, size] : {std::pair("N", mesh.normals.size()), std::pair("uv", mesh.uvs.size())})
    if (size != 0 && size != mesh.positions.size())
      p.fail_at(name, fmt::format("has {} entries, expected {}, one for each vertex", size, mesh.positions.size()));
  p.ignore({"S", "faceIndices"});
  return mesh;
}

/// Unshares the vertices and gives each triangle pbrt's default texture coordinates.
Mesh with_coordinates(const Mesh& mesh) {
  constexpr Vec2f kCorners[] = {{0, 0}, {1, 0}, {1, 1}};
  Mesh out;
  for (const auto& triangle : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(out.positions.size());
    out.triangles.push_back({first, first + 1, first + 2});
    for (std::size_t k = 0; k < 3; ++k) {
      out.positions.push_back(mesh.positions[triangle[k]]);
      if (!mesh.normals.empty()) out.normals.push_back(mesh.normals[triangle[k]]);
      out.uvs.push_back(kCorners[k]);
    }
  }
  return out;
}

Vec3f bilinear(const float* p, float u, float v) {
  const auto corner = [&](std::size_t k) { return Vec3f{p[3 * k], p[3 * k + 1], p[3 * k + 2]}; };
  return (corner(0) * (1 - u) + corner(1) * u) * (1 - v) + (corner(2) * (1 - u) + corner(3) * u) * v;
}

Vec3f bilinear_normal(const float* p, float u, float v) {
  const Vec3f along = bilinear(p, 1, v) - bilinear(p, 0, v), across = bilinear(p, u, 1) - bilinear(p, u, 0);
  return cross(along, across);
}

/// Adds a triangle unless it is degenerate, as at poles.
void add_triangle(Mesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const Vec3f ab = mesh.positions[b] - mesh.positions[a], ac = mesh.positions[c] - mesh.positions[a], bc = ac - ab;
  const Vec3f normal = cross(ab, ac);
  const float longest = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
  if (std::sqrt(dot(normal, normal)) > 1e-6f * longest) mesh.triangles.push_back({a, b, c});
}

}  // namespace

void append(Mesh& mesh, const Patch& patch) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto row = static_cast<std::uint32_t>(patch.steps_u + 1);
  for (int j = 0; j <= patch.steps_v; ++j)
    for (int i = 0; i <= patch.steps_u; ++i) {
      const float u = static_cast<float>(i) / static_cast<float>(patch.steps_u);
      const float v = static_cast<float>(j) / static_cast<float>(patch.steps_v);
      mesh.positions.push_back(patch.point(patch.shape, u, v));
      mesh.normals.push_back(patch.normal(patch.shape, u, v));
      mesh.uvs.push_back({u, v});
    }
  for (int j = 0; j < patch.steps_v; ++j)
    for (int i = 0; i < patch.steps_u; ++i) {
      const std::uint32_t corner = first + static_cast<std::uint32_t>(j) * row + static_cast<std::uint32_t>(i);
      add_triangle(mesh, corner, corner + 1, corner + row + 1);
      add_triangle(mesh, corner, corner + row + 1, corner + row);
    }
}

Mesh read_triangle_mesh(Parameters& p, bool textured) {
  Mesh mesh = read_vertices(p);
  const std::vector<std::uint32_t> indices = read_indices(p, mesh.positions.size(), 3);
  for (std::size_t i = 0; i < indices.size(); i += 3)
    mesh.triangles.push_back({indices[i], indices[i + 1], indices[i + 2]});
  return textured && mesh.uvs.empty() ? with_coordinates(mesh) : mesh;
}

Mesh read_subdivision(Parameters& p, bool textured) {
  constexpr int kMaxLevels = 12;
  p.ignore({"scheme"});
  const Mesh control = read_triangle_mesh(p, false);
  const int levels = p.integer("levels", 3, 0, kMaxLevels);
  try {
    Mesh mesh = subdivide({control.positions, {}, {}, control.triangles}, levels);
    return textured ? with_coordinates(mesh) : mesh;
  } catch (const SceneError& error) { p.fail(std::string(": ") + error.what(), error.code()); }
}

Mesh read_bilinear_mesh(Parameters& p) {
  const Mesh corners = read_vertices(p);
  const bool own_normals = !corners.normals.empty();
  p.ignore({"emissionfilename"});  // affects light sampling only
  const std::vector<std::uint32_t> indices = read_indices(p, corners.positions.size(), 4);
  Mesh mesh;
  bool flat = true;
  for (std::size_t i = 0; i < indices.size(); i += 4) {
    Patch patch{bilinear, bilinear_normal, {}, 1, 1};
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec3f corner = corners.positions[indices[i + k]];
      patch.shape[3 * k] = corner.x, patch.shape[3 * k + 1] = corner.y, patch.shape[3 * k + 2] = corner.z;
    }
    // Two triangles are exact for parallelograms.
    const Vec3f off = bilinear(patch.shape, 1, 1) - bilinear(patch.shape, 0, 1) - bilinear(patch.shape, 1, 0) +
                      bilinear(patch.shape, 0, 0);
    const Vec3f size = bilinear(patch.shape, 1, 1) - bilinear(patch.shape, 0, 0);
    const bool is_flat = dot(off, off) <= 1e-10f * dot(size, size);
    flat = flat && is_flat && !own_normals;
    if (!is_flat || own_normals) patch.steps_u = patch.steps_v = kPatchSteps;
    const std::size_t first = mesh.positions.size();
    append(mesh, patch);
    for (std::size_t v = first; v < mesh.uvs.size(); ++v) {
      const Vec2f at = mesh.uvs[v];
      const auto uv = [&](std::size_t k) { return corners.uvs[indices[i + k]]; };
      const float weights[] = {(1 - at.x) * (1 - at.y), at.x * (1 - at.y), (1 - at.x) * at.y, at.x * at.y};
      if (own_normals) mesh.normals[v] = {0, 0, 0};
      for (std::size_t k = 0; own_normals && k < 4; ++k)
        mesh.normals[v] = mesh.normals[v] + corners.normals[indices[i + k]] * weights[k];
      if (corners.uvs.empty()) continue;
      Vec2f sum{0, 0};
      for (std::size_t k = 0; k < 4; ++k) sum = {sum.x + weights[k] * uv(k).x, sum.y + weights[k] * uv(k).y};
      mesh.uvs[v] = sum;
    }
  }
  if (flat) mesh.normals.clear();
  return mesh;
}

}  // namespace sheaf::pbrt
