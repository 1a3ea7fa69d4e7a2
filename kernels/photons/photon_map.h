// Photon maps: photons sorted into the cells of a grid, to be found around a point.
//
// Cells are cubes as wide as the gathering sphere, so that a sphere touches eight of them; a hash takes cells to
// buckets, and photons lie in the order of buckets, in columns (Teschner et al., "Optimized Spatial Hashing for
// Collision Detection of Deformable Objects", 2003). Whoever gathers asks for the buckets of all eight cells, each
// once, and tests every photon's distance.
#pragma once

#include "kernels/photons/photon.h"
#include "scene/tables/scene.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sheaf {

/// A photon map as kernels see it.
struct PhotonMapView {
  const float* x = nullptr;
  const float* y = nullptr;
  const float* z = nullptr;
  const float* power[4] = {};  ///< W
  const std::uint32_t* direction = nullptr;
  const std::uint32_t* surface = nullptr;       ///< see photon_surface()
  const std::uint32_t* bucket_begin = nullptr;  ///< of each bucket, and the end
  std::uint32_t bucket_mask = 0;
  float radius = 0, inverse_cell = 0;  ///< metres; 1 / metres
  PhotonKernel kernel = PhotonKernel::kDisc;
  int lookup_size = 0;  ///< see PhotonMappingDescription

  bool empty() const { return x == nullptr; }

  /// The bucket of the cell with these coordinates.
  std::uint32_t bucket(std::int32_t i, std::int32_t j, std::int32_t k) const {
    return (static_cast<std::uint32_t>(i) * 73856093u ^ static_cast<std::uint32_t>(j) * 19349663u ^
            static_cast<std::uint32_t>(k) * 83492791u) &
           bucket_mask;
  }
  /// The coordinate of the cell that holds `x`, in units of cells; kept in range for what lies far outside.
  static std::int32_t cell(float x) {
    return static_cast<std::int32_t>(std::floor(std::fmin(std::fmax(x, -2.0e9f), 2.0e9f)));
  }
  /// The buckets of the cells that a sphere of the radius around `p` may touch, each once; returns how many.
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
  /// Takes the photons of all tasks, in order; `emitted`: how many were emitted. `radius`: metres, positive. The same
  /// photons give the same map, however many threads there are.
  /// `four_lanes`: powers have a fourth lane.
  PhotonMap(std::vector<std::vector<Photon>> tasks, std::uint64_t emitted, float radius, PhotonKernel kernel,
            int lookup_size = 0, bool four_lanes = true);

  PhotonMapView view() const;
  std::size_t size() const { return size_; }
  std::size_t bytes() const { return memory_.size() * sizeof(float) + bucket_begin_.size() * sizeof(std::uint32_t); }

 private:
  static constexpr std::size_t kMaxColumns = 9;

  std::size_t columns() const { return four_lanes_ ? kMaxColumns : kMaxColumns - 1; }
  const float* column(std::size_t i) const { return first_ + i * stride_; }

  /// Makes bucket_begin_; returns the photons' numbers in the order of buckets.
  template <class F> std::vector<std::uint32_t> sort_into_buckets(F&& photon_of);

  std::size_t size_ = 0, stride_ = 0;
  std::vector<float> memory_;
  float* first_ = nullptr;  ///< aligned
  std::vector<std::uint32_t> bucket_begin_;
  float radius_ = 0;
  PhotonKernel kernel_ = PhotonKernel::kDisc;
  int lookup_size_ = 0;
  bool four_lanes_ = true;
};

}  // namespace sheaf
