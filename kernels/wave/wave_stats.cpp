#include "kernels/wave/wave_stats.h"

#include <algorithm>

namespace sheaf {

Stats& Stats::operator+=(const Stats& other) {
  for (std::size_t i = 0; i < kMaxStages; ++i) stages[i] += other.stages[i];
  rays.camera += other.rays.camera;
  rays.light += other.rays.light;
  rays.scatter += other.rays.scatter;
  rays.shadow += other.rays.shadow;
  gathering += other.gathering;
  volume_gathering += other.volume_gathering;
  chains += other.chains;
  collisions += other.collisions;
  trace_ticks += other.trace_ticks;
  samples += other.samples;
  dropped.rays += other.dropped.rays;
  dropped.samples += other.dropped.samples;
  lights.resize(std::max(lights.size(), other.lights.size()));
  for (std::size_t i = 0; i < other.lights.size(); ++i) lights[i] += other.lights[i];
  return *this;
}

}  // namespace sheaf
