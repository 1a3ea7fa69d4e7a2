// Nori's microfacet BRDF.
#pragma once

#include "scene/materials/model.h"

namespace sheaf {

/// Parameters of kernels/bsdf/nori_microfacet.h.
template <class L> struct NoriMicrofacetParameters {
  Spectrum<L> kd;           ///< diffuse reflectance; the rest is reflected specularly
  typename L::Float alpha;  ///< Beckmann roughness
  typename L::Float eta;    ///< int / ext
  static constexpr auto fields(auto& s) { return std::tie(s.kd, s.alpha, s.eta); }
};

struct NoriMicrofacetClosure : ClosureOf<NoriMicrofacetParameters> {
  static constexpr ClosureInfo kInfo = {.name = "nori_microfacet", .is_coatable = true};
};

/// Nori's microfacet BRDF: Beckmann reflection over a diffuse base, ks = 1 - max(kd).
struct NoriMicrofacetDescription {
  float int_ior = 1.5046f, ext_ior = 1.000277f;
  ScalarInput alpha = 0.1f;
  SpectrumInput kd = SpectrumDescription::constant(0.5f);

  using Closures = ClosureList<NoriMicrofacetClosure>;
  static NoriMicrofacetDescription read(Properties& p, const BsdfDialect& dialect);
  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) { return std::tie(s.int_ior, s.ext_ior, s.alpha, s.kd); }
  bool transmits() const { return false; }
  MaterialRow make_row(RowContext& context) const;
};

}  // namespace sheaf
