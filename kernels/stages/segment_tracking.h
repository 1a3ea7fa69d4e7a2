// Attenuation of connected segments by media with grids: from the origin of a ray to the point where its shadow ray
// starts. The transmittance is estimated as that of shadow rays is, for many segments at a time.
#pragma once

#include "kernels/media/density_weights.h"
#include "kernels/stages/medium_ray.h"
#include "kernels/stages/push_shadow_ray.h"
#include "kernels/wave/path_time.h"

#include <array>

namespace sheaf {

/// Takes new shadow rays from segments, which are the last rows of the queue, attenuates their contributions, and
/// removes those of which nothing is left.
template <class L> class SegmentTracking {
 public:
  /// `first`: the first of these rows.
  SegmentTracking(const StageContext& context, Wave& wave, int first)
      : context_(context), wave_(wave), kept_(first), queue_(context.sampler, MediumStream::kSegment) {}

  void run() {
    for (int i = kept_; i < wave_.shadow_count; ++i) {
      const ShadowItem<Scalar> shadow = wave_.shadows.load<Scalar>(i);
      const auto slot = static_cast<Slot>(shadow.slot);
      const RayState<Scalar> ray = wave_.rays.get(slot);
      const float length = dot(shadow.origin - ray.origin, ray.direction);
      const MediumRay segment =
          make_medium_ray(context_, ray.flags, lane_wavelengths(context_.scene, wave_, slot), ray.origin, ray.direction,
                          length, path_time(context_.scene, wave_, slot));
      const bool queued = !segment.has(kMediumHomogeneous);
      rows_[static_cast<std::size_t>(count_++)] = {i, queued ? queue_.size() : kNotQueued};
      if (queued) {
        const PathState<Scalar> path = wave_.paths.get(slot);
        queue_.add(segment, path.pixel, path.sample, path.dimension() | kSegmentDimension);
      }
      if (count_ == DensityQueue::kCapacity) finish();
    }
    finish();
    wave_.shadow_count = kept_;
  }

 private:
  static constexpr int kNotQueued = -1;
  struct Row {
    int shadow, queue_index;
  };

  /// Tracks the queued segments and moves the rows that are left to the front.
  void finish() {
    const bool delta = context_.integrator.medium_estimator == MediumEstimator::kDelta;
    queue_.track_shadows<L>(delta);
    for (int i = 0; i < count_; ++i) {
      const Row row = rows_[static_cast<std::size_t>(i)];
      ShadowItem<Scalar> shadow = wave_.shadows.load<Scalar>(row.shadow);
      const TransmittanceItem<Scalar> state = wave_.transmittances.load<Scalar>(row.shadow);
      if (row.queue_index != kNotQueued) {
        const auto passed = queue_.passed(row.queue_index, delta, wave_.stats.collisions);
        // The medium is gray
        if (!passed || !(passed->beta[0] > 0.0f)) continue;
        shadow.contribution = shadow.contribution * passed->beta[0];
      }
      wave_.shadows.store<Scalar>(kept_, shadow);
      wave_.transmittances.store<Scalar>(kept_++, state);
    }
    count_ = 0;
    queue_.clear();
  }

  const StageContext& context_;
  Wave& wave_;
  int kept_, count_ = 0;
  DensityQueue queue_;
  std::array<Row, DensityQueue::kCapacity> rows_;
};

}  // namespace sheaf
