// The metallic-roughness material of glTF 2.0.
#pragma once

#include "scene/materials/model.h"

namespace sheaf {

/// Parameters of kernels/bsdf/metallic_roughness.h.
template <class L> struct MetallicRoughnessParameters {
  Spectrum<L> base_color;
  Spectrum<L> specular_color;  ///< not negative, may exceed 1
  Spectrum<L> sheen_color;
  typename L::Float metallic, roughness, specular, transmission, anisotropy;
  typename L::Float anisotropy_rotation;  ///< radians
  typename L::Float sheen_roughness, clearcoat, clearcoat_roughness;
  typename L::Float f0;      ///< reflectance of the dielectric at normal incidence, before `specular_color`
  typename L::Uint is_thin;  ///< 1: looks the same from both sides; 0: black from inside
  static constexpr auto fields(auto& s) {
    return std::tie(s.base_color, s.specular_color, s.sheen_color, s.metallic, s.roughness, s.specular, s.transmission,
                    s.anisotropy, s.anisotropy_rotation, s.sheen_roughness, s.clearcoat, s.clearcoat_roughness, s.f0,
                    s.is_thin);
  }
};

struct MetallicRoughnessClosure : ClosureOf<MetallicRoughnessParameters> {
  static constexpr ClosureInfo kInfo = {.name = "metallic_roughness"};
};

/// The metallic-roughness material of glTF 2.0 (appendix B of the specification) with the extensions
/// KHR_materials_ior, _specular, _transmission (thin walls), _anisotropy, _sheen and _clearcoat. Colors and numbers
/// lie in [0, 1] unless stated otherwise. Materials that may transmit light are thin walls, alike from both sides;
/// others are black from inside.
struct MetallicRoughnessDescription {
  SpectrumInput base_color = SpectrumDescription::constant(1);
  ScalarInput metallic = 1.0f;
  ScalarInput roughness = 1.0f;  ///< perceptual: the square root of the facets' alpha
  /// Factor on the dielectric's reflectance at normal incidence; not negative, may exceed 1. The product is clamped to
  /// 1.
  SpectrumInput specular_color = SpectrumDescription::constant(1);
  ScalarInput specular = 1.0f;      ///< weight of the dielectric's specular reflection
  ScalarInput transmission = 0.0f;  ///< fraction of the light that enters a dielectric which is transmitted
  ScalarInput anisotropy = 0.0f;    ///< strength
  ScalarInput anisotropy_rotation =
      0.0f;  ///< of the direction of larger roughness, radians from the tangent, any value
  SpectrumInput sheen_color = SpectrumDescription::constant(0);
  ScalarInput sheen_roughness = 0.0f;  ///< perceptual; the model has a minimum of 0.1
  ScalarInput clearcoat = 0.0f;
  ScalarInput clearcoat_roughness = 0.0f;  ///< perceptual
  /// Index of refraction of the dielectric. Infinity, or 0 as in files, means a reflectance of 1 at normal
  /// incidence, as for materials converted from specular-glossiness.
  float eta = 1.5f;

  using Closures = ClosureList<MetallicRoughnessClosure>;
  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) {
    return std::tie(s.base_color, s.metallic, s.roughness, s.specular_color, s.specular, s.transmission, s.anisotropy,
                    s.anisotropy_rotation, s.sheen_color, s.sheen_roughness, s.clearcoat, s.clearcoat_roughness, s.eta);
  }
  bool transmits() const { return transmission != ScalarInput(0.0f); }
  MaterialRow make_row(RowContext& context) const;
};

}  // namespace sheaf
