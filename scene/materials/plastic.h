// A diffuse base under a dielectric coat, smooth or rough.
#pragma once

#include "scene/materials/model.h"
#include "scene/materials/roughness.h"

#include <optional>

namespace sheaf {

/// Parameters of kernels/bsdf/plastic.h.
template <class L> struct PlasticParameters {
  typename L::Float eta;                   ///< int / ext
  Spectrum<L> diffuse, specular;           ///< reflectance of the base; factor on the coat's reflection
  typename L::Uint nonlinear;              ///< 1: color shifts due to multiple scattering between base and coat; else 0
  typename L::Float internal_reflectance;  ///< internal diffuse reflectance of the coat
  static constexpr auto fields(auto& s) {
    return std::tie(s.eta, s.diffuse, s.specular, s.nonlinear, s.internal_reflectance);
  }
};

/// Parameters of kernels/bsdf/rough_plastic.h.
template <class L> struct RoughPlasticParameters {
  typename L::Float eta;                                 ///< int / ext
  Spectrum<L> diffuse, specular;                         ///< as for PlasticParameters
  typename L::Uint nonlinear;                            ///< as for PlasticParameters
  typename L::Float internal_reflectance;                ///< as for PlasticParameters
  typename L::Float alpha;                               ///< roughness
  typename L::Float transmittance[kTransmittanceTerms];  ///< transmittance of the coat as a function of the cosine
  static constexpr auto fields(auto& s) {
    return std::tie(s.eta, s.diffuse, s.specular, s.nonlinear, s.internal_reflectance, s.alpha, s.transmittance);
  }
};

struct PlasticClosure : ClosureOf<PlasticParameters> {
  static constexpr ClosureInfo kInfo = {.name = "plastic", .is_coatable = true};
};
struct RoughPlasticBeckmannClosure : ClosureOf<RoughPlasticParameters> {
  static constexpr ClosureInfo kInfo = {.name = "rough_plastic_beckmann", .is_coatable = true};
};
struct RoughPlasticGgxClosure : ClosureOf<RoughPlasticParameters> {
  static constexpr ClosureInfo kInfo = {.name = "rough_plastic_ggx", .is_coatable = true};
};

/// A diffuse base under a dielectric coat, smooth or rough (alpha_u equals alpha_v and is not textured).
struct PlasticDescription {
  float int_ior = 1.49f, ext_ior = 1.000277f;
  SpectrumInput diffuse_reflectance = SpectrumDescription::constant(0.5f);
  SpectrumInput specular_reflectance = SpectrumDescription::constant(1.0f);
  bool nonlinear = false;                         ///< color shifts due to multiple scattering between base and coat
  std::optional<RoughnessDescription> roughness;  ///< empty: smooth

  using Closures = ClosureList<PlasticClosure, RoughPlasticBeckmannClosure, RoughPlasticGgxClosure>;
  static PlasticDescription read_smooth(Properties& p, const BsdfDialect& dialect);
  static PlasticDescription read_rough(Properties& p, const BsdfDialect& dialect);
  static PlasticDescription read_polarized(Properties& p, const BsdfDialect& dialect);
  static constexpr Plugin<PlasticDescription> kPlugins[] = {
      {"plastic", read_smooth}, {"roughplastic", read_rough}, {"pplastic", read_polarized}};
  static constexpr auto fields(auto& s) {
    return std::tie(s.int_ior, s.ext_ior, s.diffuse_reflectance, s.specular_reflectance, s.nonlinear, s.roughness);
  }
  bool transmits() const { return false; }
  MaterialRow make_row(RowContext& context) const;
};

}  // namespace sheaf
