// Statistics: the counters of a worker, and their sum over all workers.
#pragma once

#include "kernels/media/tracking_counts.h"
#include "kernels/wave/stats.h"

#include <array>
#include <cstddef>
#include <vector>

namespace sheaf {

/// Position of a stage in the list of kernels/stages/stage_list.h.
enum class Stage : std::uint32_t {};
/// Upper bound on the number of stages.
inline constexpr std::size_t kMaxStages = 32;

/// Shadow rays of light sampling to one light, and the radiance that they contributed.
struct LightStats {
  std::uint64_t rays = 0;     ///< shadow rays towards it
  std::uint64_t arrived = 0;  ///< shadow rays that were not occluded
  double radiance = 0;        ///< contributed to the image, sum over samples and components

  LightStats& operator+=(const LightStats& other) {
    rays += other.rays;
    arrived += other.arrived;
    radiance += other.radiance;
    return *this;
  }
};

/// All counters of one worker; the sum over all workers describes a render. Aligned to cache lines, so that the
/// workers' elements of an array share no line.
struct alignas(64) Stats {
  std::array<StageStats, kMaxStages> stages;
  struct Rays {
    std::uint64_t camera = 0;   ///< from the camera
    std::uint64_t light = 0;    ///< photons from the lights
    std::uint64_t scatter = 0;  ///< continued after a surface or a medium
    std::uint64_t shadow = 0;   ///< visibility towards a light
    std::uint64_t total() const { return camera + light + scatter + shadow; }
  } rays;
  /// Queries of photon maps, and the photons within the lookup radius that contributed.
  struct Gathering {
    std::uint64_t queries = 0, photons = 0;

    Gathering& operator+=(const Gathering& other) {
      queries += other.queries;
      photons += other.photons;
      return *this;
    }
  };
  Gathering gathering, volume_gathering;  ///< at surfaces; along rays in media, beams included
  /// Specular chains from vertices to lights (manifold next-event estimation).
  struct Chains {
    std::uint64_t attempts = 0;   ///< first walks
    std::uint64_t solutions = 0;  ///< chains found by first walks that contribute
    std::uint64_t trials = 0;     ///< walks that estimate the reciprocal probabilities of the solutions
    std::uint64_t capped = 0;     ///< solutions whose number of trials has reached the limit
    std::uint64_t rays = 0;       ///< rays of all walks

    Chains& operator+=(const Chains& other) {
      attempts += other.attempts;
      solutions += other.solutions;
      trials += other.trials;
      capped += other.capped;
      rays += other.rays;
      return *this;
    }
  } chains;
  TrackingCounts collisions;      ///< of paths and shadow rays with media
  std::uint64_t trace_ticks = 0;  ///< inside Embree, of timestamp()
  std::uint64_t samples = 0;      ///< camera samples that reached the film
  struct Dropped {
    std::uint64_t rays = 0;     ///< not finite, not traced
    std::uint64_t samples = 0;  ///< NaN, infinite or negative radiance
  } dropped;

  std::vector<LightStats> lights;  ///< by row; lights beyond its end are not counted separately

  StageStats& operator[](Stage stage) { return stages[static_cast<std::size_t>(stage)]; }
  const StageStats& operator[](Stage stage) const { return stages[static_cast<std::size_t>(stage)]; }
  Stats& operator+=(const Stats& other);
};

}  // namespace sheaf
