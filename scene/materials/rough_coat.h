// Average reflectance and transmittance of the coats of plastics and coated materials. They depend only on the index of
// refraction and the roughness, and are computed once per material.
#pragma once

#include "scene/materials/roughness.h"

#include <array>
#include <cstddef>
#include <map>
#include <utility>

namespace sheaf {

/// Internal diffuse reflectance of a smooth coat with relative index `eta` (inside over outside).
float smooth_coat_internal_reflectance(double eta);

/// A rough coat, lit from a direction outside or diffusely from inside.
struct RoughCoat {
  /// Internal diffuse reflectance, as for a smooth coat; light that would hit a second facet is lost.
  float internal_reflectance = 0;
  std::array<float, kTransmittanceTerms> transmittance{};  ///< function of the cosine; see kernels/bsdf/rough_plastic.h
};

/// Computed by numerical integration over visible facets, in about 1 ms. `alpha` and `eta` > 0. The transmittance fit
/// is within 3e-3 (tested), mostly 1e-3, for alpha in [1e-4, 1] and eta in [1.05, 2.5].
RoughCoat rough_coat(RoughnessDescription::Distribution distribution, double alpha, double eta);

/// Samples to which a rough coat is fitted.
struct RoughCoatSamples {
  static constexpr std::size_t kCosines = 28;
  double internal_reflectance = 0;
  std::array<double, kCosines> transmitted{};  ///< transmittance from outside, at sample cosines
};

/// The coats of a scene. For each distribution and index, the first kMaxExact roughnesses are computed by rough_coat().
/// Further ones are interpolated between shared nodes 1/4 octave apart: within 2e-3 (tested), comparable to the error
/// of the quadrature.
class RoughCoats {
 public:
  RoughCoat coat(RoughnessDescription::Distribution distribution, double alpha, double eta);

  static constexpr std::size_t kMaxExact = 64;

 private:
  struct Family {
    std::map<double, RoughCoat> exact;      ///< by alpha
    std::map<int, RoughCoatSamples> nodes;  ///< by alpha in quarter octaves
  };
  std::map<std::pair<RoughnessDescription::Distribution, double>, Family> families_;
};

}  // namespace sheaf
