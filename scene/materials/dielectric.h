// A boundary between two dielectrics: smooth, rough, or thin; in spectral mode also dispersive.
#pragma once

#include "scene/description/dispersion.h"
#include "scene/materials/model.h"
#include "scene/materials/roughness.h"

#include <optional>

namespace sheaf {

/// Parameters of kernels/bsdf/dielectric.h and thin_dielectric.h.
template <class L> struct DielectricParameters {
  typename L::Float eta;      ///< int / ext
  Spectrum<L> reflectance;    ///< factor on reflected light
  Spectrum<L> transmittance;  ///< factor on transmitted light
  /// See kernels/bsdf/specular_scale.h.
  typename L::Float specular = typename L::Float(1.0f);
  Spectrum<L> specular_color = Spectrum<L>(typename L::Float(1.0f));
  static constexpr auto fields(auto& s) {
    return std::tie(s.eta, s.reflectance, s.transmittance, s.specular, s.specular_color);
  }
};

/// Parameters of kernels/bsdf/rough_dielectric.h.
template <class L> struct RoughDielectricParameters {
  typename L::Float eta;                   ///< int / ext
  Spectrum<L> reflectance, transmittance;  ///< as for DielectricParameters
  typename L::Float alpha_u, alpha_v;      ///< roughness along the tangent and the bitangent
  typename L::Float specular = typename L::Float(1.0f);
  Spectrum<L> specular_color = Spectrum<L>(typename L::Float(1.0f));
  static constexpr auto fields(auto& s) {
    return std::tie(s.eta, s.reflectance, s.transmittance, s.alpha_u, s.alpha_v, s.specular, s.specular_color);
  }
};

/// DielectricParameters with an index per wavelength (kernels/bsdf/dispersive_dielectric.h). Spectral mode only.
template <class L> struct DispersiveDielectricParameters {
  Spectrum<L> eta;  ///< int / ext
  Spectrum<L> reflectance, transmittance;
  typename L::Float specular = typename L::Float(1.0f);
  Spectrum<L> specular_color = Spectrum<L>(typename L::Float(1.0f));
  static constexpr auto fields(auto& s) {
    return std::tie(s.eta, s.reflectance, s.transmittance, s.specular, s.specular_color);
  }
};

/// RoughDielectricParameters with an index per wavelength (kernels/bsdf/dispersive_rough_dielectric.h).
template <class L> struct DispersiveRoughDielectricParameters {
  Spectrum<L> eta, reflectance, transmittance;
  typename L::Float alpha_u, alpha_v;
  typename L::Float specular = typename L::Float(1.0f);
  Spectrum<L> specular_color = Spectrum<L>(typename L::Float(1.0f));
  static constexpr auto fields(auto& s) {
    return std::tie(s.eta, s.reflectance, s.transmittance, s.alpha_u, s.alpha_v, s.specular, s.specular_color);
  }
};

struct DielectricClosure : ClosureOf<DielectricParameters> {
  static constexpr ClosureInfo kInfo = {.name = "dielectric"};
};
struct ThinDielectricClosure : ClosureOf<DielectricParameters> {
  static constexpr ClosureInfo kInfo = {.name = "thin_dielectric", .is_thin_dielectric = true};
};
struct RoughDielectricBeckmannClosure : ClosureOf<RoughDielectricParameters> {
  static constexpr ClosureInfo kInfo = {.name = "rough_dielectric_beckmann"};
};
struct RoughDielectricGgxClosure : ClosureOf<RoughDielectricParameters> {
  static constexpr ClosureInfo kInfo = {.name = "rough_dielectric_ggx"};
};
struct DispersiveDielectricClosure : ClosureOf<DispersiveDielectricParameters> {
  static constexpr ClosureInfo kInfo = {.name = "dispersive_dielectric"};
};
struct DispersiveThinDielectricClosure : ClosureOf<DispersiveDielectricParameters> {
  static constexpr ClosureInfo kInfo = {.name = "dispersive_thin_dielectric", .is_thin_dielectric = true};
};
struct DispersiveRoughDielectricBeckmannClosure : ClosureOf<DispersiveRoughDielectricParameters> {
  static constexpr ClosureInfo kInfo = {.name = "dispersive_rough_dielectric_beckmann"};
};
struct DispersiveRoughDielectricGgxClosure : ClosureOf<DispersiveRoughDielectricParameters> {
  static constexpr ClosureInfo kInfo = {.name = "dispersive_rough_dielectric_ggx"};
};

/// A boundary between two dielectrics, smooth or rough, or a thin dielectric.
struct DielectricDescription {
  float int_ior = 1.5046f;    ///< on the side opposite to the geometric normal
  float ext_ior = 1.000277f;  ///< on the side of the geometric normal
  /// Index of refraction by wavelength, for spectral mode. Empty: constant.
  std::optional<Dispersion> int_dispersion = {}, ext_dispersion = {};
  SpectrumInput specular_reflectance = SpectrumDescription::constant(1.0f);
  SpectrumInput specular_transmittance = SpectrumDescription::constant(1.0f);
  bool thin = false;  ///< thin dielectric: transmitted light keeps its direction; never rough
  std::optional<RoughnessDescription> roughness;  ///< empty: smooth
  /// Factors on the reflectance (KHR_materials_specular): at all angles, and at normal incidence. The rest is
  /// transmitted. The color may exceed 1.
  ScalarInput specular = 1.0f;
  SpectrumInput specular_color = SpectrumDescription::constant(1.0f);

  using Closures = ClosureList<DielectricClosure, ThinDielectricClosure, RoughDielectricBeckmannClosure,
                               RoughDielectricGgxClosure, DispersiveDielectricClosure, DispersiveThinDielectricClosure,
                               DispersiveRoughDielectricBeckmannClosure, DispersiveRoughDielectricGgxClosure>;
  static DielectricDescription read_smooth(Properties& p, const BsdfDialect& dialect);
  static DielectricDescription read_thin(Properties& p, const BsdfDialect& dialect);
  static DielectricDescription read_rough(Properties& p, const BsdfDialect& dialect);
  static constexpr Plugin<DielectricDescription> kPlugins[] = {
      {"dielectric", read_smooth}, {"thindielectric", read_thin}, {"roughdielectric", read_rough}};
  static constexpr auto fields(auto& s) {
    return std::tie(s.int_ior, s.ext_ior, s.int_dispersion, s.ext_dispersion, s.specular_reflectance,
                    s.specular_transmittance, s.thin, s.roughness, s.specular, s.specular_color);
  }
  bool transmits() const { return true; }
  MaterialRow make_row(RowContext& context) const;
};

}  // namespace sheaf
