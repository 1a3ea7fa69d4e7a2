// Results of the functions that scatter light: BSDFs and phase functions.
#pragma once

#include "core/color/spectrum.h"

namespace sheaf {

/// Value of a BSDF for a pair of directions.
template <class L> struct BsdfValue {
  Spectrum<L> f_cos;                  ///< f |cos(wi)|; 0 if nothing is scattered
  typename L::Float pdf_solid_angle;  ///< pdf of sample()
};

/// A direction sampled from a BSDF.
template <class L> struct BsdfSample {
  Vec3<L> wi;
  /// f |cos(wi)| / pdf; delta lobes: scattered fraction over the lobe's probability
  Spectrum<L> weight;
  typename L::Float pdf_solid_angle;  ///< 0 for delta lobes
  typename L::Float eta_scale;        ///< 1, or the squared relative index of the medium entered
  typename L::Mask valid;             ///< false: absorbed
};

}  // namespace sheaf
