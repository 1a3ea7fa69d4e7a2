// Reflection off a metal, smooth or rough.
#pragma once

#include "scene/materials/model.h"
#include "scene/materials/roughness.h"

#include <optional>

namespace sheaf {

/// Parameters of kernels/bsdf/conductor.h.
template <class L> struct ConductorParameters {
  Spectrum<L> eta, k;  ///< complex index of refraction relative to the outside; eta 0 with k 1 gives a perfect mirror
  Spectrum<L> reflectance;  ///< factor on the Fresnel reflectance
  static constexpr auto fields(auto& s) { return std::tie(s.eta, s.k, s.reflectance); }
};

/// Parameters of kernels/bsdf/rough_conductor.h.
template <class L> struct RoughConductorParameters {
  Spectrum<L> eta, k, reflectance;     ///< as for ConductorParameters
  typename L::Float alpha_u, alpha_v;  ///< roughness along the tangent and the bitangent
  static constexpr auto fields(auto& s) { return std::tie(s.eta, s.k, s.reflectance, s.alpha_u, s.alpha_v); }
};

struct ConductorClosure : ClosureOf<ConductorParameters> {
  static constexpr ClosureInfo kInfo = {.name = "conductor", .is_coatable = true};
};
struct RoughConductorBeckmannClosure : ClosureOf<RoughConductorParameters> {
  static constexpr ClosureInfo kInfo = {.name = "rough_conductor_beckmann", .is_coatable = true};
};
struct RoughConductorGgxClosure : ClosureOf<RoughConductorParameters> {
  static constexpr ClosureInfo kInfo = {.name = "rough_conductor_ggx", .is_coatable = true};
};

/// Reflection off a metal, smooth or rough. Without `ior` it is a perfect mirror.
struct ConductorDescription {
  struct Ior {
    SpectrumInput eta, k;
    static constexpr auto fields(auto& s) { return std::tie(s.eta, s.k); }
  };
  std::optional<Ior> ior;  ///< relative to the outside medium
  SpectrumInput specular_reflectance = SpectrumDescription::constant(1.0f);
  std::optional<RoughnessDescription> roughness;  ///< empty: smooth

  using Closures = ClosureList<ConductorClosure, RoughConductorBeckmannClosure, RoughConductorGgxClosure>;
  static ConductorDescription read_smooth(Properties& p, const BsdfDialect& dialect);
  static ConductorDescription read_rough(Properties& p, const BsdfDialect& dialect);
  static constexpr Plugin<ConductorDescription> kPlugins[] = {{"conductor", read_smooth},
                                                              {"roughconductor", read_rough}};
  static constexpr auto fields(auto& s) { return std::tie(s.specular_reflectance, s.ior, s.roughness); }
  bool transmits() const { return false; }
  MaterialRow make_row(RowContext& context) const;
};

}  // namespace sheaf
