// Scaled Fresnel reflectance of dielectrics that transmit light (KHR_materials_specular): what the surface does not
// reflect, it transmits in the direction of its index of refraction.
#pragma once

#include "kernels/bsdf/fresnel.h"

namespace sheaf {

/// Scales the reflectance `fresnel` of a boundary with the relative index `eta`: the reflectance at normal incidence by
/// `color`, clamped to 1, and that at all angles by `specular`. Total internal reflection remains, since there is no
/// direction in which light could be transmitted. With factors of 1 the result is exactly `fresnel`.
template <class F> SHEAF_INLINE F scaled_reflectance(F fresnel, F eta, F specular, F color) {
  const F one(1.0f), normal = normal_reflectance(eta), rest = (one - fresnel) / max(one - normal, F(1e-6f));
  const F scaled = specular * fma(min(normal * color, one) - normal, rest, fresnel);
  return select(fresnel < one, clamp(scaled, F(0.0f), one), one);
}

/// A choice between reflection and transmission where the lanes of the reflectance differ. Its weights are exactly 1
/// where they do not.
template <class L> struct SpecularChoice {
  Spectrum<L> reflectance;
  typename L::Float probability;  ///< of reflection

  /// `fresnel`: reflectance before scaling.
  SHEAF_INLINE SpecularChoice(Float<L> fresnel, Float<L> eta, Float<L> specular, const Spectrum<L>& color)
      : reflectance(map_spectrum<L>(
            color, [&](Float<L> c) SHEAF_LAMBDA_INLINE { return scaled_reflectance(fresnel, eta, specular, c); })),
        probability(middle(reflectance)) {}

  /// The middle of the first three lanes, the only ones in both color modes.
  static SHEAF_INLINE Float<L> middle(const Spectrum<L>& s) {
    return Float<L>(0.5f) * (min(min(s.c0, s.c1), s.c2) + max(max(s.c0, s.c1), s.c2));
  }

  /// Reflectance or transmittance over the probability of the choice.
  SHEAF_INLINE Spectrum<L> weight(Mask<L> reflected) const {
    using F = Float<L>;
    const F chosen = select(reflected, probability, F(1.0f) - probability);
    return map_spectrum<L>(reflectance, [&](F r) SHEAF_LAMBDA_INLINE {
      return select(reflected, r, F(1.0f) - r) / max(chosen, F(1e-20f));
    });
  }
};

}  // namespace sheaf
