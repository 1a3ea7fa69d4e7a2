// Single scattering in a slab without refracting boundaries (Hanrahan and Krueger 1993).
#pragma once

#include "scene/materials/model.h"

namespace sheaf {

/// Parameters of kernels/bsdf/hanrahan_krueger.h.
template <class L> struct HanrahanKruegerParameters {
  Spectrum<L> first, second;   ///< extinction and albedo; or scattering and absorption
  typename L::Uint by_albedo;  ///< 1: the former; 0: the latter
  typename L::Float thickness;
  typename L::Float g;  ///< as for HenyeyGreensteinParameters
  static constexpr auto fields(auto& s) { return std::tie(s.first, s.second, s.by_albedo, s.thickness, s.g); }
};

struct HanrahanKruegerClosure : ClosureOf<HanrahanKruegerParameters> {
  static constexpr ClosureInfo kInfo = {.name = "hanrahan_krueger"};
};

/// Single scattering in a slab without refracting boundaries (Hanrahan and Krueger 1993).
struct HanrahanKruegerDescription {
  /// With by_albedo: sigma_t (1/m) and albedo. Otherwise: sigma_s and sigma_a (1/m).
  SpectrumInput first = SpectrumDescription::constant(1), second = SpectrumDescription::constant(0.75f);
  bool by_albedo = true;
  float thickness = 1;  ///< meters
  float g = 0;          ///< of the Henyey-Greenstein phase function

  using Closures = ClosureList<HanrahanKruegerClosure>;
  static HanrahanKruegerDescription read(Properties& p, const BsdfDialect& dialect);
  static constexpr Plugin<HanrahanKruegerDescription> kPlugins[] = {{"hk", read}};
  static constexpr auto fields(auto& s) { return std::tie(s.first, s.second, s.by_albedo, s.thickness, s.g); }
  bool transmits() const { return true; }
  MaterialRow make_row(RowContext& context) const;
};

}  // namespace sheaf
