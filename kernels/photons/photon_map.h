// Photon maps: photons sorted into a uniform grid, for lookups around a point.
//
// Grid cells are cubes as wide as the diameter of the lookup sphere, so a sphere overlaps at most eight of them. Cells
// are hashed to buckets, and the photons are stored by bucket, in columns (Teschner et al., "Optimized Spatial Hashing
// for Collision Detection of Deformable Objects", 2003). A lookup visits the buckets of all eight cells, each once, and
// tests the distance of every photon.
#pragma once

#include "kernels/photons/photon.h"
#include "scene/tables/scene.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sheaf {

/// A photon map as kernels read it.
struct PhotonMapView {
  const float* x = nullptr;
  const float* y = nullptr;
  const float* z = nullptr;
  const float* power[4] = {};  ///< W
  const std::uint32_t* direction = nullptr;
  const std::uint32_t* surface = nullptr;       ///< see photon_surface()
  const std::uint32_t* bucket_begin = nullptr;  ///< first photon of each bucket, then the end
  std::uint32_t bucket_mask = 0;
  float radius = 0, inverse_cell = 0;  ///< metres; 1 / metres
  PhotonKernel kernel = PhotonKernel::kDisc;
  int lookup_size = 0;  ///< see PhotonMappingSettings

  bool empty() const { return x == nullptr; }

  /// Bucket of the cell with these coordinates.
  std::uint32_t bucket(std::int32_t i, std::int32_t j, std::int32_t k) const {
    return (static_cast<std::uint32_t>(i) * 73856093u ^ static_cast<std::uint32_t>(j) * 19349663u ^
            static_cast<std::uint32_t>(k) * 83492791u) &
           bucket_mask;
  }
  /// Cell coordinate of `x`, given in units of cells; clamped for points far outside.
  static std::int32_t cell(float x) {
    return static_cast<std::int32_t>(std::floor(std::fmin(std::fmax(x, -2.0e9f), 2.0e9f)));
  }
  /// Finds the distinct buckets of the cells that the lookup sphere around `p` may overlap; returns their number.
  int buckets_around(Vec3f p, std::uint32_t (&buckets)[8]) const {
    const std::int32_t i = cell(p.x * inverse_cell - 0.5f), j = cell(p.y * inverse_cell - 0.5f),
                       k = cell(p.z * inverse_cell - 0.5f);
    for (int corner = 0; corner < 8; ++corner)
      buckets[corner] = bucket(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2));
    std::sort(std::begin(buckets), std::end(buckets));
    return static_cast<int>(std::unique(std::begin(buckets), std::end(buckets)) - std::begin(buckets));
  }
};

/// Owns the columns. Immutable.
class PhotonMap {
 public:
  PhotonMap() = default;
  /// Takes the photons of all tasks, in order. `emitted`: number of emitted photons; `radius`: in metres, positive;
  /// `four_lanes`: whether powers have a fourth lane. The map does not depend on the number of threads.
  PhotonMap(std::vector<std::vector<Photon>> tasks, std::uint64_t emitted, float radius, PhotonKernel kernel,
            int lookup_size = 0, bool four_lanes = true);

  PhotonMapView view() const;
  std::size_t size() const { return size_; }
  std::size_t bytes() const { return memory_.size() * sizeof(float) + bucket_begin_.size() * sizeof(std::uint32_t); }

 private:
  static constexpr std::size_t kMaxColumns = 9;

  std::size_t columns() const { return four_lanes_ ? kMaxColumns : kMaxColumns - 1; }
  const float* column(std::size_t i) const { return first_ + i * stride_; }

  /// Sets bucket_begin_, and returns the photon indices sorted by bucket.
  template <class F> std::vector<std::uint32_t> sort_into_buckets(F&& photon_of);

  std::size_t size_ = 0, stride_ = 0;
  std::vector<float> memory_;
  float* first_ = nullptr;  ///< aligned to kSimdAlignment
  std::vector<std::uint32_t> bucket_begin_;
  float radius_ = 0;
  PhotonKernel kernel_ = PhotonKernel::kDisc;
  int lookup_size_ = 0;
  bool four_lanes_ = true;
};

}  // namespace sheaf
