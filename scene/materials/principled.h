// Mitsuba's principled BSDF (Burley 2015).
#pragma once

#include "scene/materials/model.h"

namespace sheaf {

/// Parameters of kernels/bsdf/principled.h, named as in Burley 2015.
template <class L> struct PrincipledParameters {
  Spectrum<L> base_color;
  typename L::Float roughness, anisotropic, metallic, spec_trans, spec_tint, sheen, sheen_tint, flatness, clearcoat,
      clearcoat_gloss;
  typename L::Float eta;  ///< int / ext
  /// Luminance of base_color for the tints, needed if base_color holds reflectances at four wavelengths. Zero: not
  /// given, or black.
  typename L::Float base_luminance{};
  static constexpr auto fields(auto& s) {
    return std::tie(s.base_color, s.roughness, s.anisotropic, s.metallic, s.spec_trans, s.spec_tint, s.sheen,
                    s.sheen_tint, s.flatness, s.clearcoat, s.clearcoat_gloss, s.eta, s.base_luminance);
  }
};

struct PrincipledClosure : ClosureOf<PrincipledParameters> {
  static constexpr ClosureInfo kInfo = {.name = "principled", .is_coatable = true};
};

/// Mitsuba's principled BSDF (Burley 2015). All parameters except base_color and eta lie in [0, 1].
struct PrincipledDescription {
  SpectrumInput base_color = SpectrumDescription::constant(0.5f);
  ScalarInput roughness = 0.5f, anisotropic = 0.0f, metallic = 0.0f, spec_trans = 0.0f, spec_tint = 0.0f, sheen = 0.0f,
              sheen_tint = 0.0f, flatness = 0.0f, clearcoat = 0.0f, clearcoat_gloss = 0.0f;
  float eta = 1.5f;  ///< inside over outside; `specular` of files is converted to it

  using Closures = ClosureList<PrincipledClosure>;
  static PrincipledDescription read(Properties& p, const BsdfDialect& dialect);
  static constexpr Plugin<PrincipledDescription> kPlugins[] = {{"principled", read}};
  static constexpr ParameterName kParameters[] = {{"base_color"}, {"roughness"}, {"anisotropic"},    {"metallic"},
                                                  {"spec_trans"}, {"spec_tint"}, {"sheen"},          {"sheen_tint"},
                                                  {"flatness"},   {"clearcoat"}, {"clearcoat_gloss"}};
  static constexpr auto fields(auto& s) {
    return std::tie(s.base_color, s.roughness, s.anisotropic, s.metallic, s.spec_trans, s.spec_tint, s.sheen,
                    s.sheen_tint, s.flatness, s.clearcoat, s.clearcoat_gloss, s.eta);
  }
  bool transmits() const { return spec_trans != ScalarInput(0.0f); }
  MaterialRow make_row(RowContext& context) const;
};

}  // namespace sheaf
