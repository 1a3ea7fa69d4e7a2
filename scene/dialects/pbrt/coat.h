// The pbrt dialect: base albedo of layered materials, including the energy losses of pbrt's random walk.
#pragma once

#include <compare>

namespace sheaf::pbrt {

/// The albedo that a Lambertian base needs under Sheaf's clear coat to match the reflection of pbrt's "coateddiffuse".
class LayeredBase {
 public:
  /// `alpha`: GGX roughness of the coat, 0 if smooth. `eta`: index of refraction of the coat. `thickness`: layer
  /// thickness; the layer absorbs with an extinction coefficient of 1. `max_depth`: maximum number of interfaces that a
  /// walk visits.
  LayeredBase(double alpha, double eta, double thickness, int max_depth);

  /// Returns the albedo for a base of albedo `base`, clamped to [0, 1].
  float albedo(float base) const;

  // NOLINTNEXTLINE(modernize-use-nullptr): a false positive of clang-tidy 14
  friend auto operator<=>(const LayeredBase&, const LayeredBase&) = default;

 private:
  double internal_reflectance_;  ///< of the coat, for diffuse light from the base
  double round_trip_;            ///< internal reflectance times the transmittance of both ways
  double transmittance_;         ///< mean one-way transmittance of light that passes the coat
  int reflections_;              ///< maximum number of reflections off the base
};

}  // namespace sheaf::pbrt
