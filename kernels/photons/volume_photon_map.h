// A map of photons in media, which are searched along rays. Each photon is a disc that faces the ray (Jarosz, Zwicker
// and Jensen, "The Beam Radiance Estimate for Volumetric Photon Mapping", 2008).
#pragma once

#include "kernels/photons/photon.h"
#include "scene/accel/accel.h"
#include "scene/tables/scene_view.h"

#include <vector>

namespace sheaf {

/// Owns the photons. Immutable.
class VolumePhotonMap {
 public:
  VolumePhotonMap() = default;
  /// Takes the photons of all tasks, in order. `emitted`: number of emitted photons; `radius`: of the discs, in meters,
  /// positive.
  VolumePhotonMap(const std::vector<std::vector<Photon>>& tasks, std::uint64_t emitted, float radius,
                  PhotonKernel kernel);

  /// Data of a photon that a ray has found.
  struct Record {
    Spectrum4 power;           ///< W
    std::uint32_t direction;   ///< octahedral, towards the previous vertex
    std::uint32_t medium_key;  ///< see photon_medium_key()
  };

  const PointAccel& points() const { return points_; }
  const Record& photon(std::uint32_t i) const { return records_[i]; }
  float radius() const { return radius_; }
  PhotonKernel kernel() const { return kernel_; }
  std::size_t size() const { return records_.size(); }
  std::size_t bytes() const { return records_.size() * (sizeof(Record) + sizeof(AccelPoint)) + points_.bytes(); }

 private:
  PointAccel points_;
  std::vector<Record> records_;
  float radius_ = 0;
  PhotonKernel kernel_ = PhotonKernel::kDisc;
};

}  // namespace sheaf
