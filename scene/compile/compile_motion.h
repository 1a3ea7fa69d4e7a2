// Compiles motions: tabulates the transforms of everything that moves, and the steps of shapes that deform.
#pragma once

#include "scene/compile/motion_steps.h"
#include "scene/description.h"
#include "scene/tables/instance.h"

#include <vector>

namespace sheaf {

/// Maximum number of 32-bit words in a table, so that kernels can address them by 32-bit indices.
inline constexpr std::size_t kMaxTableWords = 0xffffffff - 64;

/// Rounds the matrix of a transform to single precision.
std::array<float, 12> single_rows(const Transform& transform);

/// Fills the tables of motions for the compilers of cameras, geometry, lights and media.
class MotionCompiler {
 public:
  /// Both arguments must outlive the object.
  MotionCompiler(const Description& description, MotionTables& tables)
      : motions_(description.motions), shutter_(description.shutter), tables_(tables) {
    tables_.shutter_ramp = shutter_.ramp;
  }

  const ShutterDescription& shutter() const { return shutter_; }
  /// The transform of a motion; null: does not move.
  const AnimatedTransform* transform(const std::optional<MotionId>& id) const {
    return id ? &motions_.at(static_cast<std::size_t>(*id)) : nullptr;
  }
  const MotionTables& tables() const { return tables_; }
  MotionTables& tables() { return tables_; }

  /// Appends steps.
  MotionRow add(const std::vector<MotionStepRow>& steps);
  /// Adds the motion of an object relative to its rest pose, the transform at the first key. Returns a row without
  /// segments if the object is static.
  MotionRow add_from_rest(const AnimatedTransform& motion, const MotionProbes& probes);
  /// Adds a shape that deforms, with `vertex_count` points at each of `segment_count` + 1 steps. Returns its bits of
  /// ShapeRow::flags.
  std::uint32_t add_deformation(std::size_t segment_count, std::size_t vertex_count);
  /// Appends the motion of a row to a table, in which rows without a motion may be missing.
  static void set(std::vector<MotionRow>& table, std::size_t row, const MotionRow& motion) {
    table.resize(row);
    table.push_back(motion);
  }
  /// The motion of a row of such a table.
  static MotionRow of(const std::vector<MotionRow>& table, std::size_t row) {
    return row < table.size() ? table[row] : MotionRow{};
  }

  /// The transform of each step of a motion, as the row of an instance.
  std::vector<InstanceRow> placements(const MotionRow& motion) const;
  /// The positions of a point at rest and at each step of a motion.
  std::vector<Vec3f> positions(const MotionRow& motion, Vec3f p) const;

 private:
  const std::vector<AnimatedTransform>& motions_;
  const ShutterDescription& shutter_;
  MotionTables& tables_;
};

}  // namespace sheaf
