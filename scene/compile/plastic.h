// What the coat of a plastic does to light on average: numbers that depend on the index and the roughness alone and are
// computed once per material.
#pragma once

#include "scene/description/description.h"
#include "scene/tables/material.h"

#include <map>
#include <utility>

namespace sheaf {

/// Share of diffuse light from within that a smooth coat of relative index `eta` (inside over outside) sends back.
float smooth_coat_internal_reflectance(double eta);

/// A rough coat, lit from a direction or diffusely from within.
struct RoughCoat {
  float internal_reflectance = 0;  ///< as of a smooth coat; light that would meet a second facet is lost
  std::array<float, kTransmittanceTerms> transmittance{};  ///< over the cosine; see kernels/bsdf/rough_plastic.h
};

/// By numerical integration over visible facets; takes about a millisecond. `alpha` and `eta` > 0. The fit of the
/// transmittance is within 3e-3 (tested), mostly 1e-3, for alpha in [1e-4, 1] and eta in [1.05, 2.5].
RoughCoat rough_coat(RoughnessDescription::Distribution distribution, double alpha, double eta);

/// What a rough coat is fitted to.
struct RoughCoatSamples {
  static constexpr std::size_t kCosines = 28;
  double internal_reflectance = 0;
  std::array<double, kCosines> transmitted{};  ///< of light from outside, at cosines of its direction
};

/// The coats of a scene. The first kMaxExact roughnesses of each distribution and index are those of rough_coat();
/// others are interpolated between roughnesses a quarter of an octave apart, which they share: within 2e-3 (tested), as
/// far as quadrature itself is off.
class RoughCoats {
 public:
  RoughCoat coat(RoughnessDescription::Distribution distribution, double alpha, double eta);

  static constexpr std::size_t kMaxExact = 64;

 private:
  struct Family {
    std::map<double, RoughCoat> exact;      ///< by alpha
    std::map<int, RoughCoatSamples> nodes;  ///< by quarters of octaves of alpha
  };
  std::map<std::pair<RoughnessDescription::Distribution, double>, Family> families_;
};

}  // namespace sheaf
