#include "scene/compile/compile_motion.h"

#include <algorithm>

namespace sheaf {

std::array<float, 12> single_rows(const Transform& transform) {
  std::array<float, 12> out;
  for (std::size_t i = 0; i < 12; ++i) out[i] = static_cast<float>(transform.matrix().m[i / 4][i % 4]);
  return out;
}

MotionRow MotionCompiler::add(const std::vector<MotionStepRow>& steps) {
  std::vector<MotionStepRow>& all = tables_.steps;
  if (all.size() + steps.size() > kMaxTableWords / 16) throw SceneError("too many moving objects");
  const MotionRow row{static_cast<std::uint32_t>(all.size()), static_cast<std::uint32_t>(steps.size() - 1)};
  all.insert(all.end(), steps.begin(), steps.end());
  return row;
}

MotionRow MotionCompiler::add_from_rest(const AnimatedTransform& motion, const MotionProbes& probes) {
  std::vector<MotionStepRow> steps = tabulate_motion({motion, motion.reference().inverse()}, probes, shutter_);
  const std::array<float, 12> identity = single_rows({});
  if (steps.size() == 1 && std::equal(identity.begin(), identity.end(), steps[0].matrix)) return {};
  // An object that only lies elsewhere has two equal steps
  if (steps.size() == 1) steps.push_back(steps[0]);
  return add(steps);
}

std::uint32_t MotionCompiler::add_deformation(std::size_t segment_count, std::size_t vertex_count) {
  std::vector<DeformationRow>& all = tables_.deformations;
  all.push_back({static_cast<std::uint32_t>(segment_count), static_cast<std::uint32_t>(vertex_count)});
  if (all.size() >= std::size_t(1) << (32 - kDeformationShift)) throw SceneError("too many shapes that deform");
  return static_cast<std::uint32_t>(all.size()) << kDeformationShift;
}

std::vector<InstanceRow> MotionCompiler::placements(const MotionRow& motion) const {
  std::vector<InstanceRow> out;
  for (std::uint32_t i = 0; motion.segment_count > 0 && i <= motion.segment_count; ++i)
    out.push_back(make_instance(std::to_array(tables_.steps[motion.first_step + i].matrix), 0, 0));
  return out;
}

std::vector<Vec3f> MotionCompiler::positions(const MotionRow& motion, Vec3f p) const {
  std::vector<Vec3f> out{p};
  for (const InstanceRow& step : placements(motion)) out.push_back(InstancePlacement<Scalar>(step).point(p));
  return out;
}

}  // namespace sheaf
