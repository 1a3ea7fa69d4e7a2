// Diffuse transmission.
#pragma once

#include "scene/materials/model.h"

namespace sheaf {

/// Parameters of kernels/bsdf/diffuse_transmitter.h.
template <class L> struct DiffuseTransmitterParameters {
  Spectrum<L> transmittance;  ///< in [0, 1]
  static constexpr auto fields(auto& s) { return std::tie(s.transmittance); }
};

struct DiffuseTransmitterClosure : ClosureOf<DiffuseTransmitterParameters> {
  static constexpr ClosureInfo kInfo = {.name = "diffuse_transmitter"};
};

/// Diffuse transmission, equal from both sides.
struct DiffuseTransmitterDescription {
  SpectrumInput transmittance = SpectrumDescription::constant(0.5f);

  using Closures = ClosureList<DiffuseTransmitterClosure>;
  static constexpr Plugin<DiffuseTransmitterDescription> kPlugins[] = {{"difftrans"}};
  static constexpr ParameterName kParameters[] = {{"transmittance", "diffuse_transmittance"}};
  static constexpr auto fields(auto& s) { return std::tie(s.transmittance); }
  bool transmits() const { return true; }
};

}  // namespace sheaf
