// The BRDF of Burley 2012, of the Nori dialect.
#pragma once

#include "scene/materials/model.h"

namespace sheaf {

/// Parameters of kernels/bsdf/disney.h.
template <class L> struct DisneyParameters {
  Spectrum<L> base_color;
  typename L::Float metallic, subsurface, specular, specular_tint, roughness, anisotropic, sheen, sheen_tint, clearcoat,
      clearcoat_gloss;
  /// As for PrincipledParameters, with the weights of the course notes: 0.3, 0.6, 0.1.
  typename L::Float base_luminance{};
  static constexpr auto fields(auto& s) {
    return std::tie(s.base_color, s.metallic, s.subsurface, s.specular, s.specular_tint, s.roughness, s.anisotropic,
                    s.sheen, s.sheen_tint, s.clearcoat, s.clearcoat_gloss, s.base_luminance);
  }
};

struct DisneyClosure : ClosureOf<DisneyParameters> {
  static constexpr ClosureInfo kInfo = {.name = "disney", .is_coatable = true};
};

/// The BRDF of Burley 2012 with the parameter names of the Nori dialect. All parameters lie in [0, 1].
struct DisneyDescription {
  SpectrumInput base_color = SpectrumDescription::constant(0.5f);
  ScalarInput metallic = 0.0f, subsurface = 0.0f, specular = 0.5f, specular_tint = 0.0f, roughness = 0.5f,
              anisotropic = 0.0f, sheen = 0.0f, sheen_tint = 0.5f, clearcoat = 0.0f, clearcoat_gloss = 1.0f;

  using Closures = ClosureList<DisneyClosure>;
  static constexpr auto kPlugins = kNoPlugins;
  static constexpr ParameterName kParameters[] = {
      {"baseColor", "albedo"}, {"metallic"}, {"subsurface"}, {"specular"},  {"specularTint"},  {"roughness"},
      {"anisotropic"},         {"sheen"},    {"sheenTint"},  {"clearcoat"}, {"clearcoatGloss"}};
  static constexpr auto fields(auto& s) {
    return std::tie(s.base_color, s.metallic, s.subsurface, s.specular, s.specular_tint, s.roughness, s.anisotropic,
                    s.sheen, s.sheen_tint, s.clearcoat, s.clearcoat_gloss);
  }
  bool transmits() const { return false; }
  MaterialRow make_row(RowContext& context) const;
};

}  // namespace sheaf
