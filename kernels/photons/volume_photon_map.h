// Photons in media, to be found along rays: each is a disc that faces the ray (Jarosz, Zwicker and Jensen, "The Beam
// Radiance Estimate for Volumetric Photon Mapping", 2008).
#pragma once

#include "kernels/photons/photon.h"
#include "scene/tables/accel.h"
#include "scene/tables/scene.h"

#include <vector>

namespace sheaf {

/// A photon near a ray, with the transmittance from the ray's origin.
struct NearPhoton {
  NearPoint point;
  Spectrum4 transmittance;
};

/// Scratch of whoever gathers photons along rays.
struct BeamScratch {
  std::vector<NearPoint> found;
  std::vector<NearPhoton> photons;
  std::vector<NearLine> lines;
};

/// Owns the photons. Immutable.
class VolumePhotonMap {
 public:
  VolumePhotonMap() = default;
  /// Takes the photons of all tasks, in order; `emitted`: how many were emitted. `radius`: of the discs, metres,
  /// positive.
  VolumePhotonMap(std::vector<std::vector<Photon>> tasks, std::uint64_t emitted, float radius, PhotonKernel kernel);

  /// A photon as rays find it.
  struct Record {
    Spectrum4 power;          ///< W
    std::uint32_t direction;  ///< octahedral, towards where it came from
    std::uint32_t place;      ///< see photon_place()
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
