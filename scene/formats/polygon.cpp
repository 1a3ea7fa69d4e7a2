#include "scene/formats/polygon.h"

#include "core/soa/large_pages.h"
#include "scene/formats/triangulate.h"

#include <algorithm>

namespace sheaf {

std::vector<std::uint32_t> append_polygons(const PolygonList& polygons, Mesh& mesh,
                                           std::vector<std::string>& warnings) {
  const std::size_t max_triangles = polygons.corners.size() - 2 * polygons.ends.size();
  reserve_on_large_pages(mesh.triangles, max_triangles);
  std::vector<std::uint32_t> sources;
  reserve_on_large_pages(sources, max_triangles);
  std::vector<Vec3f> outline;
  std::vector<PolygonTriangle> triangles;
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::size_t polygon) {
    mesh.triangles.push_back({a, b, c});
    sources.push_back(static_cast<std::uint32_t>(polygon));
  };
  std::size_t begin = 0, crossed = 0, incomplete = 0;
  for (std::size_t polygon = 0; polygon < polygons.ends.size(); ++polygon) {
    const std::size_t end = polygons.ends[polygon];
    const std::uint32_t* const vertices = &polygons.corners[begin];
    const std::size_t count = end - begin;
    begin = end;
    if (std::find(vertices, vertices + count, kMissingVertex) != vertices + count) {
      ++incomplete;
      continue;
    }
    if (count == 3) {
      add(vertices[0], vertices[1], vertices[2], polygon);
      continue;
    }
    outline.resize(count);
    for (std::size_t i = 0; i < outline.size(); ++i) outline[i] = mesh.positions[vertices[i]];
    if (!triangulate_polygon(outline, triangles)) ++crossed;
    for (const PolygonTriangle& t : triangles) add(vertices[t[0]], vertices[t[1]], vertices[t[2]], polygon);
  }
  if (polygons.too_short > 0) {
    warnings.push_back(fmt::format("{} faces with fewer than three corners left out", polygons.too_short));
  }
  if (incomplete > 0) warnings.push_back(fmt::format("faces left out: {} ({})", incomplete, polygons.first_missing));
  if (crossed > 0)
    warnings.push_back(fmt::format("{} self-intersecting polygons are triangulated approximately", crossed));
  return sources;
}

}  // namespace sheaf
