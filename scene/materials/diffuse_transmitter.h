// Diffuse transmission, with or without diffuse reflection.
#pragma once

#include "scene/materials/model.h"

namespace sheaf {

/// Parameters of kernels/bsdf/diffuse_transmitter.h.
template <class L> struct DiffuseTransmitterParameters {
  Spectrum<L> transmittance, reflectance;  ///< in [0, 1]
  static constexpr auto fields(auto& s) { return std::tie(s.transmittance, s.reflectance); }
};

struct DiffuseTransmitterClosure : ClosureOf<DiffuseTransmitterParameters> {
  static constexpr ClosureInfo kInfo = {.name = "diffuse_transmitter"};
};

/// Diffuse transmission and reflection, equal from both sides.
struct DiffuseTransmitterDescription {
  SpectrumInput transmittance = SpectrumDescription::constant(0.5f);
  SpectrumInput reflectance = SpectrumDescription::constant(0);

  using Closures = ClosureList<DiffuseTransmitterClosure>;
  static constexpr Plugin<DiffuseTransmitterDescription> kPlugins[] = {{"difftrans"}};
  static constexpr ParameterName kParameters[] = {{"transmittance", "diffuse_transmittance"}, {}};
  static constexpr auto fields(auto& s) { return std::tie(s.transmittance, s.reflectance); }
  bool transmits() const { return true; }
};

}  // namespace sheaf
