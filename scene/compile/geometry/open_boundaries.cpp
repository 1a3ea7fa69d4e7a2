#include "scene/compile/geometry/open_boundaries.h"

#include <algorithm>
#include <utility>

namespace sheaf {

OpenBoundaries::Boundary OpenBoundaries::find(const Mesh& mesh, const SourceLocation& where) {
  Boundary boundary{where, {}};
  for (const auto& [first, second] : open_edges(mesh)) {
    // -0 becomes 0
    const auto position = [&](std::uint32_t vertex) {
      const Vec3f& p = mesh.positions[vertex];
      return std::array<float, 3>{p.x + 0.0f, p.y + 0.0f, p.z + 0.0f};
    };
    std::array<float, 3> a = position(first), b = position(second);
    if (b < a) std::swap(a, b);
    boundary.edges.push_back({a[0], a[1], a[2], b[0], b[1], b[2]});
  }
  return boundary;
}

void OpenBoundaries::add(Boundary boundary) {
  if (!boundary.edges.empty()) boundaries_.push_back(std::move(boundary));
}

std::vector<OpenBoundaries::Gap> OpenBoundaries::gaps() const {
  std::vector<Edge> all;
  for (const Boundary& boundary : boundaries_) all.insert(all.end(), boundary.edges.begin(), boundary.edges.end());
  std::sort(all.begin(), all.end());
  std::vector<Gap> gaps;
  for (const Boundary& boundary : boundaries_) {
    const auto is_alone = [&](const Edge& edge) {
      const auto [begin, end] = std::equal_range(all.begin(), all.end(), edge);
      return end - begin == 1;
    };
    const auto count = std::count_if(boundary.edges.begin(), boundary.edges.end(), is_alone);
    if (count > 0) gaps.push_back({boundary.where, static_cast<std::size_t>(count)});
  }
  return gaps;
}

}  // namespace sheaf
