// Roughness of microfacet surfaces.
#pragma once

#include "core/io/error.h"
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

/// The single number of an isotropic roughness without textures. Throws SceneError for others.
inline float uniform_roughness(const RoughnessDescription& roughness) {
  const float* alpha = std::get_if<float>(&roughness.alpha_u);
  if (alpha == nullptr || roughness.alpha_u != roughness.alpha_v)
    throw SceneError("the roughness of a coat is a texture or anisotropic, expected one number");
  return *alpha;
}

/// Terms of the polynomial fit to a rough coat's transmittance; see kernels/bsdf/rough_plastic.h.
inline constexpr int kTransmittanceTerms = 8;

}  // namespace sheaf
