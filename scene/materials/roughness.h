// Roughness of microfacet surfaces.
#pragma once

#include "scene/description/inputs.h"

#include <tuple>

namespace sheaf {

/// Microfacet distribution of a rough surface.
struct RoughnessDescription {
  enum class Distribution { kBeckmann, kGgx } distribution = Distribution::kBeckmann;
  ScalarInput alpha_u = 0.1f, alpha_v = 0.1f;  ///< root mean square slopes along the tangent and the bitangent
  static constexpr auto fields(auto& s) { return std::tie(s.distribution, s.alpha_u, s.alpha_v); }
  bool is_ggx() const { return distribution == Distribution::kGgx; }
};

/// Terms of the polynomial fit to a rough coat's transmittance; see kernels/bsdf/rough_plastic.h.
inline constexpr int kTransmittanceTerms = 8;

}  // namespace sheaf
