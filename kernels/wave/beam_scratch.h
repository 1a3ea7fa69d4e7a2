// Scratch memory of the stage gather_volume for photon lookups along rays.
#pragma once

#include "core/color/spectrum.h"
#include "scene/accel/accel.h"

#include <vector>

namespace sheaf {

/// A photon near a ray, with the transmittance from the origin of the ray.
struct NearPhoton {
  NearPoint point;
  Spectrum4 transmittance;
};

/// Scratch memory for lookups along rays.
struct BeamScratch {
  std::vector<NearPoint> found;
  std::vector<NearPhoton> photons;
  std::vector<NearLine> lines;
};

}  // namespace sheaf
