// A map of photon beams, which are searched along rays.
#pragma once

#include "kernels/photons/photon_beam.h"
#include "scene/accel/accel.h"

#include <vector>

namespace sheaf {

/// Owns the beams. Immutable.
class PhotonBeamMap {
 public:
  PhotonBeamMap() = default;
  /// Takes the beams of all tasks, in order. `emitted`: number of emitted photons; `radius`: of the beams, in meters,
  /// positive; `piece`: see LineAccel.
  PhotonBeamMap(const std::vector<std::vector<PhotonBeam>>& tasks, std::uint64_t emitted, float radius, float piece,
                PhotonKernel kernel);

  /// Data of a beam that a ray has found.
  struct Record {
    Spectrum4 power;           ///< at the start, W
    Spectrum4 pdf_ratio;       ///< see PhotonBeam
    std::uint32_t medium_key;  ///< see photon_medium_key()
  };

  const LineAccel& lines() const { return lines_; }
  const Record& beam(std::uint32_t i) const { return records_[i]; }
  float radius() const { return radius_; }
  PhotonKernel kernel() const { return kernel_; }
  std::size_t size() const { return records_.size(); }
  std::size_t bytes() const { return records_.size() * sizeof(Record) + lines_.bytes(); }

 private:
  LineAccel lines_;
  std::vector<Record> records_;
  float radius_ = 0;
  PhotonKernel kernel_ = PhotonKernel::kDisc;
};

}  // namespace sheaf
