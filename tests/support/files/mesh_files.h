// Helpers for tests of mesh files: temporary files, and sums over meshes.
#pragma once

#include "core/io/error.h"
#include "scene/description.h"
#include "tests/support/contains.h"
#include "tests/support/temporary_folder.h"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <filesystem>
#include <string>
#include <string_view>

namespace sheaf::test {

/// A file with the given content in a folder of its own, which is removed with it.
class TemporaryFile {
 public:
  TemporaryFile(const std::string& name, const std::string& content) : path_(folder_ / name) {
    write_bytes(path_, content);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  TemporaryFolder folder_;
  std::filesystem::path path_;
};

/// The message of the SceneError that `call` throws; empty if it does not throw.
template <std::invocable Call> std::string error_of(Call&& call) {
  try {
    call();
  } catch (const SceneError& error) { return error.what(); }
  return {};
}

/// Unnormalized normal (b - a) x (c - a) of a triangle, twice its area in length.
inline Vec3f area_normal(const Mesh& mesh, std::size_t triangle) {
  const auto& t = mesh.triangles[triangle];
  return cross(mesh.positions[t[1]] - mesh.positions[t[0]], mesh.positions[t[2]] - mesh.positions[t[0]]);
}

/// Total area of all triangles.
inline double total_area(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vec3f n = area_normal(mesh, i);
    sum += 0.5 * std::sqrt(double(n.x) * n.x + double(n.y) * n.y + double(n.z) * n.z);
  }
  return sum;
}

/// Whether all values are equal; NaNs never are.
inline bool are_equal(const Mesh& a, const Mesh& b) {
  const auto same = [](Vec2f p, Vec2f q) { return p.x == q.x && p.y == q.y; };
  return a.positions == b.positions && a.normals == b.normals && a.triangles == b.triangles &&
         std::equal(a.uvs.begin(), a.uvs.end(), b.uvs.begin(), b.uvs.end(), same);
}

}  // namespace sheaf::test
