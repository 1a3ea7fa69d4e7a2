// Construction of maps of photons in media.
#include "kernels/photons/volume_photon_map.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>

namespace sheaf {

namespace {

/// Inserts two zeros between each of the low ten bits.
std::uint32_t spread_bits(std::uint32_t x) {
  x = (x | x << 16) & 0x030000ffu;
  x = (x | x << 8) & 0x0300f00fu;
  x = (x | x << 4) & 0x030c30c3u;
  return (x | x << 2) & 0x09249249u;
}

/// Sorted keys: the Morton code of each photon (Morton 1966) in the high bits and its index in the low ones. Photons
/// that are close in space become close in memory.
std::vector<std::uint64_t> sorted_keys(const std::vector<Photon>& photons) {
  // Find the bounds
  Vec3f low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};
  for (const Photon& photon : photons) {
    low = {min(low.x, photon.p.x), min(low.y, photon.p.y), min(low.z, photon.p.z)};
    high = {max(high.x, photon.p.x), max(high.y, photon.p.y), max(high.z, photon.p.z)};
  }
  // Compute and sort the keys
  constexpr float kCells = 1023;
  const float size = std::max({high.x - low.x, high.y - low.y, high.z - low.z, 1e-30f});
  const auto cell = [&](float x, float lowest) {
    return spread_bits(static_cast<std::uint32_t>(clamp((x - lowest) / size * kCells, 0.0f, kCells)));
  };
  std::vector<std::uint64_t> keys(photons.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, keys.size(), 1 << 14),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        const Vec3f p = photons[i].p;
                        const std::uint32_t place = cell(p.x, low.x) | cell(p.y, low.y) << 1 | cell(p.z, low.z) << 2;
                        keys[i] = std::uint64_t{place} << 32 | i;
                      }
                    });
  tbb::parallel_sort(keys.begin(), keys.end());
  return keys;
}

}  // namespace

VolumePhotonMap::VolumePhotonMap(std::vector<std::vector<Photon>> tasks, std::uint64_t emitted, float radius,
                                 PhotonKernel kernel)
    : radius_(radius), kernel_(kernel) {
  std::vector<Photon> photons;
  for (std::vector<Photon>& task : tasks) {
    photons.insert(photons.end(), task.begin(), task.end());
    task = {};
  }
  std::vector<AccelPoint> points;
  points.reserve(photons.size());
  records_.reserve(photons.size());
  const float scale = 1.0f / static_cast<float>(emitted);
  for (const std::uint64_t key : sorted_keys(photons)) {
    const Photon& photon = photons[key & 0xffffffffu];
    points.push_back({photon.p.x, photon.p.y, photon.p.z, radius});
    records_.push_back({photon.power * scale, photon.direction, photon.surface});
  }
  points_ = PointAccel(std::move(points));
}

}  // namespace sheaf
