// Tables of moving instances, lights, media and cameras: matrices at equidistant times over the shutter; and of meshes
// and curves that deform. scene/tables/motion_sample.h interpolates them.
#pragma once

#include "core/soa/record_table.h"
#include "scene/tables/shape_rows.h"
#include "scene/tables/table_bytes.h"

#include <vector>

namespace sheaf {

/// A transform at one time.
template <class L> struct alignas(row_alignment<L>(64)) MotionStepRecord {
  typename L::Float matrix[12];  ///< rows of a 3x4 matrix
  typename L::Float unused[4];
  static constexpr auto fields(auto& s) { return std::tie(s.matrix, s.unused); }
};
using MotionStepRow = MotionStepRecord<Scalar>;
static_assert(sizeof(MotionStepRow) == 64);

/// The steps of an object that may move.
template <class L> struct MotionRecord {
  typename L::Uint first_step{};     ///< into MotionView::steps
  typename L::Uint segment_count{};  ///< number of steps - 1; 0: does not move, and has no steps
  static constexpr auto fields(auto& s) { return std::tie(s.first_step, s.segment_count); }
};
using MotionRow = MotionRecord<Scalar>;

/// The steps of a mesh or of curves that deform, at equidistant times over the shutter. In GeometryView::vertices or
/// GeometryView::curve_points, the points of each step follow those of the step before.
struct DeformationRow {
  std::uint32_t segment_count;  ///< number of steps - 1; at least 1
  std::uint32_t vertex_count;   ///< of each step; curves: number of control points
};

/// Maximum of MotionRecord::segment_count and DeformationRow::segment_count: Embree accepts 129 time steps.
inline constexpr int kMaxMotionSegments = 128;

/// The motions of a scene for kernels. Static scenes have none of these tables.
struct MotionView {
  const MotionStepRow* steps = nullptr;  ///< null: no transform changes
  const MotionRow* instances = nullptr;  ///< group space to world space, by row of instance; null: no instance moves
  /// By row of light; null: no light moves. Transform from the light's rest pose to its pose at the time.
  const MotionRow* lights = nullptr;
  const MotionRow* cameras = nullptr;  ///< the same for the cameras, in the order of the film's columns; or null
  const MotionRow* media = nullptr;    ///< the same for the grids of media, by row of medium; null: no grid moves
  /// The meshes and curves that deform, to which shapes refer by their flags; null: none.
  const DeformationRow* deformations = nullptr;
  float shutter_ramp = 0;  ///< see ShutterDescription::ramp
  /// Rows of the instances of one shape with a motion of its own, whether or not it moves during the exposure:
  /// [first, end).
  std::uint32_t first_moving_shape = 0, end_of_moving_shapes = 0;

  /// Whether paths have a time.
  bool any() const { return steps != nullptr || deformations != nullptr; }
  /// The steps of the points of a shape; null: it does not deform.
  const DeformationRow* deformation(const ShapeRow& shape) const {
    const std::uint32_t row = shape.flags >> kDeformationShift;
    return row == 0 ? nullptr : deformations + (row - 1);
  }
};

/// Owns the tables of motion.
struct MotionTables {
  std::vector<MotionStepRow> steps;
  std::vector<MotionRow> instances, lights, cameras, media;
  std::vector<DeformationRow> deformations;
  float shutter_ramp = 0;
  std::uint32_t first_moving_shape = 0, end_of_moving_shapes = 0;  ///< see MotionView

  MotionView view() const {
    const auto table = [](const std::vector<MotionRow>& rows) { return rows.empty() ? nullptr : rows.data(); };
    return {steps.empty() ? nullptr : steps.data(),
            table(instances),
            table(lights),
            table(cameras),
            table(media),
            deformations.empty() ? nullptr : deformations.data(),
            shutter_ramp,
            first_moving_shape,
            end_of_moving_shapes};
  }
  /// Memory in bytes.
  std::size_t bytes() const { return bytes_of(steps, instances, lights, cameras, media, deformations); }
};

}  // namespace sheaf
