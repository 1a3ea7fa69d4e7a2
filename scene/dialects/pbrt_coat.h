// The pbrt dialect: the base of layered materials, with the losses of pbrt's random walk.
#pragma once

#include <compare>

namespace sheaf::pbrt {

/// The albedo that a Lambertian base needs under our clear coat to reflect what it does in pbrt's "coateddiffuse".
class LayeredBase {
 public:
  /// `alpha`: slope of the coat's GGX facets, 0 if smooth; `eta`: index of the coat; `thickness` of the layer, which
  /// absorbs with an extinction of 1; `max_depth`: interfaces that a walk meets.
  LayeredBase(double alpha, double eta, double thickness, int max_depth);

  /// For a base of albedo `base`, clamped to [0, 1].
  float albedo(float base) const;

  friend auto operator<=>(const LayeredBase&, const LayeredBase&) = default;

 private:
  double internal_reflectance_;  ///< of the coat for diffuse light from the base
  double round_trip_;            ///< the same, times the transmittance there and back
  double transmittance_;         ///< mean along one way, of light that gets through the coat
  int reflections_;              ///< off the base, at most
};

}  // namespace sheaf::pbrt
