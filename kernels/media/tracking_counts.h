// Counters of tracking through media.
#pragma once

#include <cstdint>

namespace sheaf {

/// Collisions while tracking through media.
struct TrackingCounts {
  std::uint64_t real = 0;       ///< real collisions of paths
  std::uint64_t null = 0;       ///< null collisions of paths, or steps of ray marching
  std::uint64_t shadow = 0;     ///< tentative collisions, or steps, of shadow rays
  std::uint64_t abandoned = 0;  ///< rays that ended after kMaxCollisions (density_tracking.h)
  TrackingCounts& operator+=(const TrackingCounts& other) {
    real += other.real;
    null += other.null;
    shadow += other.shadow;
    abandoned += other.abandoned;
    return *this;
  }
};

}  // namespace sheaf
