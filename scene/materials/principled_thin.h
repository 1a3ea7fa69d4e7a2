// Mitsuba's thin principled BSDF, for surfaces without an interior.
#pragma once

#include "scene/materials/model.h"

namespace sheaf {

/// Parameters of kernels/bsdf/principled_thin.h.
template <class L> struct PrincipledThinParameters {
  Spectrum<L> base_color;
  typename L::Float roughness, anisotropic, spec_trans, eta, spec_tint, sheen, sheen_tint, flatness, diff_trans;
  typename L::Float base_luminance{};  ///< as for PrincipledParameters
  static constexpr auto fields(auto& s) {
    return std::tie(s.base_color, s.roughness, s.anisotropic, s.spec_trans, s.eta, s.spec_tint, s.sheen, s.sheen_tint,
                    s.flatness, s.diff_trans, s.base_luminance);
  }
};

struct PrincipledThinClosure : ClosureOf<PrincipledThinParameters> {
  static constexpr ClosureInfo kInfo = {.name = "principled_thin"};
};

/// Mitsuba's thin principled BSDF, for surfaces without an interior.
struct PrincipledThinDescription {
  SpectrumInput base_color = SpectrumDescription::constant(0.5f);
  ScalarInput roughness = 0.5f, anisotropic = 0.0f, spec_trans = 0.0f, eta = 1.5f, spec_tint = 0.0f, sheen = 0.0f,
              sheen_tint = 0.0f, flatness = 0.0f;
  ScalarInput diff_trans = 0.0f;  ///< in [0, 2]; 1: equal diffuse transmission and reflection

  using Closures = ClosureList<PrincipledThinClosure>;
  static PrincipledThinDescription read(Properties& p, const BsdfDialect& dialect);
  static constexpr Plugin<PrincipledThinDescription> kPlugins[] = {{"principledthin", read}};
  static constexpr ParameterName kParameters[] = {
      {"base_color"}, {"roughness"}, {"anisotropic"}, {"spec_trans"}, {"eta", nullptr, kPositive},
      {"spec_tint"},  {"sheen"},     {"sheen_tint"},  {"flatness"},   {"diff_trans", nullptr, {0, 2}}};
  static constexpr auto fields(auto& s) {
    return std::tie(s.base_color, s.roughness, s.anisotropic, s.spec_trans, s.eta, s.spec_tint, s.sheen, s.sheen_tint,
                    s.flatness, s.diff_trans);
  }
  bool transmits() const { return true; }
  MaterialRow make_row(RowContext& context) const;
};

}  // namespace sheaf
