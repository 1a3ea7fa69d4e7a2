// The energy-conserving Phong BRDF of Lafortune and Willems 1994.
#pragma once

#include "scene/materials/model.h"

namespace sheaf {

/// Parameters of kernels/bsdf/phong.h.
template <class L> struct PhongParameters {
  Spectrum<L> diffuse, specular;  ///< reflectances; their sum is at most 1
  typename L::Float exponent;     ///< not negative
  static constexpr auto fields(auto& s) { return std::tie(s.diffuse, s.specular, s.exponent); }
};

struct PhongClosure : ClosureOf<PhongParameters> {
  static constexpr ClosureInfo kInfo = {.name = "phong", .is_coatable = true};
};

/// The energy-conserving Phong BRDF of Lafortune and Willems 1994.
struct PhongDescription {
  SpectrumInput diffuse_reflectance = SpectrumDescription::constant(0.5f);
  SpectrumInput specular_reflectance = SpectrumDescription::constant(0.2f);
  ScalarInput exponent = 30.0f;

  using Closures = ClosureList<PhongClosure>;
  static PhongDescription read(Properties& p, const BsdfDialect& dialect);
  static constexpr Plugin<PhongDescription> kPlugins[] = {{"phong", read}};
  static constexpr ParameterName kParameters[] = {
      {"diffuse_reflectance"}, {"specular_reflectance"}, {"exponent", nullptr, {0, 1e9}}};
  static constexpr auto fields(auto& s) { return std::tie(s.diffuse_reflectance, s.specular_reflectance, s.exponent); }
  bool transmits() const { return false; }
};

}  // namespace sheaf
