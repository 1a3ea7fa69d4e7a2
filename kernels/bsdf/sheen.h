// Sheen of cloth: the microfacet model of Estevez and Kulla, "Production Friendly Microfacet Sheen BRDF" (SIGGRAPH 2017
// course notes), in the form of KHR_materials_sheen. The normals of fibers are distributed as a power of the sine.
#pragma once

#include "kernels/bsdf/microfacet.h"

namespace sheaf {

/// The sheen lobe without its color.
///
/// The albedo of the model exceeds 1 at grazing incidence if the roughness is below 0.3. evaluate() divides by the
/// larger of the two albedos where that exceeds 1, which conserves energy and keeps the lobe reciprocal.
template <class L> struct SheenLobe {
  using F = typename L::Float;
  /// Range of the parameters and of the cosine; smaller values are raised to these.
  static constexpr float kMinRoughness = 0.1f, kMinCosine = 1e-3f;

  SheenLobe() = default;
  /// `roughness` is perceptual, the square root of the model's roughness.
  SHEAF_INLINE explicit SheenLobe(F roughness) {
    const F r = max(roughness, F(kMinRoughness)), alpha = r * r, sharp = sqr(F(1.0f) - alpha);
    exponent_ = F(1.0f) / alpha;
    a_ = lerp(sharp, F(21.5473f), F(25.3245f));
    b_ = lerp(sharp, F(3.82987f), F(3.32435f));
    c_ = lerp(sharp, F(0.19823f), F(0.16801f));
    d_ = lerp(sharp, F(-1.97760f), F(-1.27393f));
    e_ = lerp(sharp, F(-4.32054f), F(-4.85967f));
    twice_middle_ = F(2.0f) * log_shadowing(F(0.5f));
    set_albedo_terms(fma(F(3.0f), sqrt(r), F(-2.0f)));
  }

  /// Directional albedo of the model before the correction, for a cosine to the normal. A polynomial of degree 6 in the
  /// fourth root of the cosine and of degree 5 in the square root of the roughness, fitted to its logarithm by
  /// numerical integration of the BRDF. The error is at most 0.003, relative to the albedo where that exceeds 1.
  SHEAF_INLINE F albedo(F cos_theta) const {
    const F x = fma(F(2.4f), sqrt(sqrt(max(cos_theta, F(kMinCosine)))), F(-1.4f));
    F sum = albedo_[kDegree];
    for (int i = kDegree - 1; i >= 0; --i) sum = fma(sum, x, albedo_[i]);
    return exp(sum);
  }

  /// f cos_i, for directions above the surface with half vector `h`. `larger_albedo`: the larger one of both
  /// directions.
  SHEAF_INLINE F evaluate(F cos_o, F cos_i, Vec3<L> h, F larger_albedo) const {
    const F sin2 = max(h.x * h.x + h.y * h.y, F(1e-30f));
    const F density = (exponent_ + F(2.0f)) * F(0.5f * kInvPi) * exp(F(0.5f) * exponent_ * log(sin2));
    const F masking = F(1.0f) + shadowing(cos_o) + shadowing(cos_i);
    return density / (F(4.0f) * max(cos_o, F(1e-6f)) * masking * max(larger_albedo, F(1.0f)));
  }

 private:
  static constexpr int kDegree = 6;
  F exponent_{};                   ///< of the sine
  F a_{}, b_{}, c_{}, d_{}, e_{};  ///< parameters of log_shadowing()
  F twice_middle_{};               ///< 2 log_shadowing(0.5)
  F albedo_[kDegree + 1] = {};     ///< coefficients of the logarithm of the albedo

  SHEAF_INLINE F log_shadowing(F x) const {
    const F power = exp(c_ * log(max(x, F(1e-30f))));
    return a_ / fma(b_, power, F(1.0f)) + fma(d_, x, e_);
  }

  /// The function lambda of Smith's masking term, fitted by Estevez and Kulla.
  SHEAF_INLINE F shadowing(F cos_theta) const {
    const Mask<L> grazing = cos_theta < F(0.5f);
    const F log_lambda = log_shadowing(select(grazing, cos_theta, F(1.0f) - cos_theta));
    return exp(select(grazing, log_lambda, twice_middle_ - log_lambda));
  }

  SHEAF_INLINE void set_albedo_terms(F y) {
    albedo_[0] = polynomial(y, -0.652456f, 0.234255f, 0.359648f, -0.103142f, -0.291393f, 0.0916751f);
    albedo_[1] = polynomial(y, -1.19016f, 0.902056f, -0.539862f, 0.245624f, -0.632517f, 0.455065f);
    albedo_[2] = polynomial(y, -0.80804f, 0.694763f, -0.517894f, 0.934534f, -0.918498f, 0.247209f);
    albedo_[3] = polynomial(y, 0.0164402f, 0.222564f, -1.63983f, 1.95222f, 0.0125098f, -0.612548f);
    albedo_[4] = polynomial(y, -0.192898f, 0.645957f, -2.0049f, 0.899744f, 1.01046f, -0.661225f);
    albedo_[5] = polynomial(y, -0.674553f, 1.16518f, 0.243353f, -1.38771f, 0.280908f, 0.364768f);
    albedo_[6] = polynomial(y, -0.50706f, 0.54911f, 0.919329f, -1.07807f, -0.281745f, 0.453534f);
  }
};

}  // namespace sheaf
