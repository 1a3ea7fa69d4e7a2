// The geometry of a scene: meshes, quadrics, curves, SDF grids, and instances of groups of them.
#pragma once

#include "scene/tables/shape_rows.h"
#include "scene/tables/table_bytes.h"

#include <vector>

namespace sheaf {

/// Geometry for kernels.
struct GeometryView {
  const ShapeRow* shapes = nullptr;
  const VertexRow* vertices = nullptr;
  const std::uint32_t* triangles = nullptr;  ///< three per triangle, relative to the shape's first vertex
  const QuadricRow* quadrics = nullptr;
  const CurvePointRow* curve_points = nullptr;
  const std::uint32_t* curve_segments = nullptr;  ///< first point of each segment, relative to the shape's first point
  const SdfGridRow* sdf_grids = nullptr;
  const float* sdf_values = nullptr;
  const std::uint32_t* sdf_cells = nullptr;
  const InstanceRow* instances = nullptr;  ///< null: no instances
  const TangentRow* tangents = nullptr;    ///< one per vertex; null: no mesh has tangents
  std::uint32_t shape_count = 0;
};

/// Owns the tables of geometry. Padded at the end for kernels, which load triangles four words at a time.
struct GeometryTables {
  std::vector<ShapeRow> shapes;
  std::vector<VertexRow> vertices;
  std::vector<std::uint32_t> triangles;
  std::vector<QuadricRow> quadrics;
  std::vector<CurvePointRow> curve_points;
  std::vector<std::uint32_t> curve_segments;
  std::vector<SdfGridRow> sdf_grids;
  std::vector<float> sdf_values;
  std::vector<std::uint32_t> sdf_cells;
  std::vector<InstanceRow> instances;
  std::vector<TangentRow> tangents;  ///< of all vertices, or empty

  GeometryView view() const {
    return {shapes.data(),
            vertices.data(),
            triangles.data(),
            quadrics.data(),
            curve_points.data(),
            curve_segments.data(),
            sdf_grids.data(),
            sdf_values.data(),
            sdf_cells.data(),
            instances.empty() ? nullptr : instances.data(),
            tangents.empty() ? nullptr : tangents.data(),
            static_cast<std::uint32_t>(shapes.size())};
  }
  /// Memory in bytes.
  std::size_t bytes() const {
    return bytes_of(shapes, vertices, triangles, quadrics, curve_points, curve_segments, sdf_grids, sdf_values,
                    sdf_cells, instances, tangents);
  }
};

}  // namespace sheaf
