// Reflection off diffuse microfacets (Oren and Nayar 1994).
#pragma once

#include "scene/materials/model.h"

namespace sheaf {

/// Parameters of kernels/bsdf/rough_diffuse.h.
template <class L> struct RoughDiffuseParameters {
  Spectrum<L> reflectance;  ///< of the facets
  typename L::Float alpha;  ///< roughness
  typename L::Uint fast;    ///< 1: simplified model without interreflection; else 0
  static constexpr auto fields(auto& s) { return std::tie(s.reflectance, s.alpha, s.fast); }
};

struct RoughDiffuseClosure : ClosureOf<RoughDiffuseParameters> {
  static constexpr ClosureInfo kInfo = {.name = "rough_diffuse", .is_coatable = true};
};

/// Reflection off diffuse microfacets (Oren and Nayar 1994).
struct RoughDiffuseDescription {
  SpectrumInput reflectance = SpectrumDescription::constant(0.5f);
  ScalarInput alpha = 0.2f;  ///< root mean square slope times sqrt 2, as for Beckmann microfacets
  bool fast = false;         ///< ignore interreflection between facets

  using Closures = ClosureList<RoughDiffuseClosure>;
  static constexpr Plugin<RoughDiffuseDescription> kPlugins[] = {{"roughdiffuse"}};
  static constexpr ParameterName kParameters[] = {
      {"reflectance", "diffuse_reflectance"}, {"alpha", nullptr, kNotNegative}, {"use_fast_approx"}};
  static constexpr auto fields(auto& s) { return std::tie(s.reflectance, s.alpha, s.fast); }
  bool transmits() const { return false; }
};

}  // namespace sheaf
