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
  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) { return std::tie(s.int_ior, s.ext_ior, s.alpha, s.kd); }
  bool transmits() const { return false; }

  static NoriMicrofacetDescription read(auto& p, const BsdfDialect&) {
    NoriMicrofacetDescription result;
    result.int_ior = read_ior(p, "intIOR", result.int_ior);
    result.ext_ior = read_ior(p, "extIOR", result.ext_ior);
    result.alpha = read_alpha(p, first_of(p, {"alpha", "m_alpha"}), result.alpha);
    result.kd = read_reflectance(p, first_of(p, {"kd", "albedo"}), result.kd);
    return result;
  }

  MaterialRow make_row(auto& context) const {
    auto m = context.template builder<NoriMicrofacetParameters>();
    m.set(m.p.kd, kd);
    m.set(m.p.alpha, alpha);
    m.p.eta = int_ior / ext_ior;
    return m.template row<NoriMicrofacetClosure>();
  }
};

}  // namespace sheaf
