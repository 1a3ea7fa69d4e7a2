// Transforms of moving objects and segments of deforming shapes at given times: linear interpolation, as Embree does
// it. Generic in the lane policy.
#pragma once

#include "scene/tables/instance.h"
#include "scene/tables/motion.h"

namespace sheaf {

/// The transform of a moving object at one time.
template <class L> struct MotionSample {
  typename L::Mask moves;
  InstancePlacement<L> placed;  ///< lanes that do not move: undefined
  /// The change of the matrix over the shutter if it always changed as now, absolute values.
  Vec3<L> speed_rows[3], speed_translation;

  /// Bound of the error of a transformed point, in units of one rounding error, that comes from rounding the time.
  SHEAF_INLINE typename L::Float error(Vec3<L> p) const {
    const Vec3<L> q = abs(p);
    return max_component(Vec3<L>{dot(speed_rows[0], q), dot(speed_rows[1], q), dot(speed_rows[2], q)} +
                         speed_translation);
  }
};

/// The motions of rows `index` of a table; lanes outside of `active` do not move.
template <class L> SHEAF_INLINE MotionRecord<L> load_motion(const MotionRow* rows, Uint<L> index, Mask<L> active) {
  using U = Uint<L>;
  const U safe = select(active, index, U(0u));
  return {gather_member<L>(rows, &MotionRow::first_step, safe),
          select(active, gather_member<L>(rows, &MotionRow::segment_count, safe), U(0u))};
}

/// Interpolates the transforms of `motion` at times in [0, 1].
template <class L>
SHEAF_INLINE MotionSample<L> sample_motion(const MotionView& view, const MotionRecord<L>& motion,
                                           typename L::Float time) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const auto moves = motion.segment_count != U(0u);
  // Find the segment
  const F segments = to_float(motion.segment_count);
  const F scaled = time * segments;
  const U segment = min(to_uint(scaled), select(moves, motion.segment_count - U(1u), U(0u)));
  const F t = scaled - to_float(segment);
  // Interpolate linearly
  const U row = select(moves, motion.first_step + segment, U(0u));
  const MotionStepRecord<L> a = gather_rows<L>(view.steps, row);
  const MotionStepRecord<L> b = gather_rows<L>(view.steps, select(moves, row + U(1u), U(0u)));
  InstanceRecord<L> placed{};
  F change[12];
  for (int i = 0; i < 12; ++i) {
    change[i] = b.matrix[i] - a.matrix[i];
    placed.to_world[i] = a.matrix[i] + change[i] * t;
    change[i] = abs(change[i]) * segments;
  }
  const F* m = placed.to_world;
  placed.determinant = dot(Vec3<L>{m[0], m[1], m[2]}, cross(Vec3<L>{m[4], m[5], m[6]}, Vec3<L>{m[8], m[9], m[10]}));
  return {moves,
          InstancePlacement<L>(placed),
          {{change[0], change[1], change[2]}, {change[4], change[5], change[6]}, {change[8], change[9], change[10]}},
          {change[3], change[7], change[11]}};
}

/// Segments between the steps of shapes that deform, with the position of times in them.
template <class L> struct DeformationSegment {
  typename L::Mask deforms;  ///< other lanes: undefined
  typename L::Uint step;     ///< the step before
  typename L::Float t;       ///< from 0 at that step to 1 at the next one
  typename L::Float segments;
  typename L::Uint vertex_count;
};

/// The segments at times in [0, 1] of shapes with these flags. Requires MotionView::deformations.
template <class L>
SHEAF_INLINE DeformationSegment<L> deformation_segment(const MotionView& view, Uint<L> shape_flags, Mask<L> active,
                                                       Float<L> time) {
  using U = Uint<L>;
  DeformationSegment<L> out;
  const U number = shape_flags >> kDeformationShift;
  out.deforms = active & (number != U(0u));
  const U row = select(out.deforms, number - U(1u), U(0u));
  const U segment_count = gather_member<L>(view.deformations, &DeformationRow::segment_count, row);
  out.segments = to_float(segment_count);
  const Float<L> scaled = time * out.segments;
  out.step = min(to_uint(scaled), segment_count - U(1u));
  out.t = scaled - to_float(out.step);
  out.vertex_count = gather_member<L>(view.deformations, &DeformationRow::vertex_count, row);
  return out;
}

/// Placements of instances at times in [0, 1].
template <class L> struct InstanceAt {
  InstancePlacement<L> placed;
  typename L::Float error;  ///< see MotionSample::error(), of the point `p`; 0 for instances that do not move
};

/// TextureCoordinates instances `index`, whose rows are `row`, in the lanes of `active`. `p`: a point of the group's
/// space.
template <class L>
SHEAF_INLINE InstanceAt<L> placement_at(const MotionView& view, const InstanceRecord<L>& row, Uint<L> index,
                                        Mask<L> active, Float<L> time, Vec3<L> p = {}) {
  using F = Float<L>;
  InstanceAt<L> out{InstancePlacement<L>(row), F(0.0f)};
  if (view.instances == nullptr) return out;
  const MotionSample<L> moved = sample_motion<L>(view, load_motion<L>(view.instances, index, active), time);
  if (!any(moved.moves)) return out;
  out.placed = select<L>(moved.moves, moved.placed, out.placed);
  out.error = select(moved.moves, moved.error(p), F(0.0f));
  return out;
}

}  // namespace sheaf
