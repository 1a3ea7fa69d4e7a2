// A hair fiber (Chiang et al. 2016).
#pragma once

#include "scene/materials/model.h"

#include <variant>

namespace sheaf {

/// Parameters of kernels/bsdf/hair.h.
template <class L> struct HairParameters {
  Spectrum<L> absorption;  ///< per fiber radius, times `scale`; or the color of dense hair, see `by_reflectance`
  Spectrum<L> eumelanin_absorption, pheomelanin_absorption;  ///< per fiber radius and unit of concentration
  typename L::Float scale;
  typename L::Float eumelanin, pheomelanin;                       ///< concentrations
  typename L::Float longitudinal_roughness, azimuthal_roughness;  ///< in [0, 1]
  typename L::Float tilt;                                         ///< tilt of the scales, radians
  typename L::Float eta;                                          ///< int / ext
  typename L::Uint by_reflectance;  ///< 1: absorption is derived from a reflectance; else 0
  typename L::Uint fourth;          ///< 1 if the fourth lane is a wavelength; else 0
  static constexpr auto fields(auto& s) {
    return std::tie(s.absorption, s.eumelanin_absorption, s.pheomelanin_absorption, s.scale, s.eumelanin, s.pheomelanin,
                    s.longitudinal_roughness, s.azimuthal_roughness, s.tilt, s.eta, s.by_reflectance, s.fourth);
  }
};

struct HairClosure : ClosureOf<HairParameters> {
  static constexpr ClosureInfo kInfo = {.name = "hair"};
};

/// A hair fiber (Chiang et al. 2016). Lengths inside are in units of the fiber's radius.
struct HairDescription {
  /// Absorption from the concentrations of pigments.
  struct Melanin {
    ScalarInput eumelanin = 1.3f, pheomelanin = 0.2f;
    static constexpr auto fields(auto& s) { return std::tie(s.eumelanin, s.pheomelanin); }
  };
  /// Absorption per fiber radius.
  struct Absorption {
    SpectrumInput sigma_a = SpectrumDescription::constant(0);
    float scale = 1;
    static constexpr auto fields(auto& s) { return std::tie(s.sigma_a, s.scale); }
  };
  /// Absorption for which dense hair reflects this color under white light.
  struct Reflectance {
    SpectrumInput color = SpectrumDescription::constant(0.5f);
    static constexpr auto fields(auto& s) { return std::tie(s.color); }
  };
  std::variant<Melanin, Absorption, Reflectance> color = Melanin{};
  ScalarInput longitudinal_roughness = 0.3f, azimuthal_roughness = 0.3f;  ///< in [0, 1]
  float scale_tilt = 2;  ///< degrees by which the scales rise from the fiber
  float int_ior = 1.55f, ext_ior = 1.000277f;

  using Closures = ClosureList<HairClosure>;
  static HairDescription read(Properties& p, const BsdfDialect& dialect);
  static constexpr Plugin<HairDescription> kPlugins[] = {{"hair", read}};
  static constexpr auto fields(auto& s) {
    return std::tie(s.color, s.longitudinal_roughness, s.azimuthal_roughness, s.scale_tilt, s.int_ior, s.ext_ior);
  }
  bool transmits() const { return true; }
  MaterialRow make_row(RowContext& context) const;
};

}  // namespace sheaf
