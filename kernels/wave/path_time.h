// The times of paths within the shutter interval. In static scenes paths have no time, and no column for it.
#pragma once

#include "core/sampling/sampler.h"
#include "core/soa/lane_array.h"
#include "kernels/wave/wave.h"

namespace sheaf {

/// Times of the paths, from 0 when the shutter opens to 1 when it is closed. 0 in static scenes.
template <class L> SHEAF_INLINE Float<L> path_times(const SceneView& scene, const Wave& wave, const Slot* slots) {
  if (!scene.motion.any()) return Float<L>(0.0f);
  return make_lanes<Float<L>>([&](int lane) SHEAF_LAMBDA_INLINE { return wave.times[slots[lane]]; });
}

/// Time of one path.
SHEAF_INLINE float path_time(const SceneView& scene, const Wave& wave, Slot slot) {
  return scene.motion.any() ? wave.times[slot] : 0.0f;
}

/// Maps a uniform number to a time, in proportion to the open area of a shutter. `ramp`: see ShutterDescription::ramp.
template <class L> SHEAF_INLINE Float<L> sample_shutter(float ramp, Float<L> u) {
  using F = Float<L>;
  if (ramp <= 0.0f) return u;
  // The area is t^2 / (2 ramp) up to the end of the first ramp, and t - ramp / 2 up to the start of the second.
  const F area = u * F(1.0f - ramp), left = F(1.0f - ramp) - area;
  const F opening = sqrt(area * F(2.0f * ramp)), closing = F(1.0f) - sqrt(max(left, F(0.0f)) * F(2.0f * ramp));
  const F half(0.5f * ramp);
  return clamp(select(area < half, opening, select(left < half, closing, area + half)), F(0.0f), F(1.0f));
}

/// Stores the first `count` lanes of `time` to words of Wave::times.
template <class L> SHEAF_INLINE void scatter_times(Wave& wave, const Slot* slots, int count, Float<L> time) {
  const LaneArray<Float<L>> words(time);
  for (int lane = 0; lane < count; ++lane) wave.times[slots[lane]] = words[lane];
}

/// Copies the times of the paths to a packet. Does nothing in static scenes.
template <class L>
SHEAF_INLINE void pack_times(const SceneView& scene, const Wave& wave, const Slot* slots, float* to) {
  if (scene.motion.any()) store(to, path_times<L>(scene, wave, slots));
}

}  // namespace sheaf
