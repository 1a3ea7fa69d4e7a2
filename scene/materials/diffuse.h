// Lambertian reflection.
#pragma once

#include "scene/materials/model.h"

namespace sheaf {

/// Parameters of kernels/bsdf/diffuse.h.
template <class L> struct DiffuseParameters {
  Spectrum<L> reflectance;  ///< in [0, 1]
  static constexpr auto fields(auto& s) { return std::tie(s.reflectance); }
};

struct DiffuseClosure : ClosureOf<DiffuseParameters> {
  static constexpr ClosureInfo kInfo = {.name = "diffuse", .is_coatable = true};
};

/// Lambertian reflection.
struct DiffuseDescription {
  SpectrumInput reflectance = SpectrumDescription::constant(0.5f);

  using Closures = ClosureList<DiffuseClosure>;
  static constexpr Plugin<DiffuseDescription> kPlugins[] = {{"diffuse"}};
  static constexpr ParameterName kParameters[] = {{"reflectance", "diffuse_reflectance"}};
  static constexpr auto fields(auto& s) { return std::tie(s.reflectance); }
  bool transmits() const { return false; }
};

}  // namespace sheaf
