// A path's ray as tracking sees it.
#pragma once

#include "kernels/medium_tracking.h"
#include "kernels/path_wavelengths.h"

namespace sheaf {

/// The lane by whose extinction a path samples distances: the first wavelength in spectral mode, in RGB mode each of
/// the three alike, by the path's number.
inline std::uint32_t hero_lane_flags(std::uint32_t lane) { return lane << kRayHeroShift; }
inline int hero_lane(std::uint32_t flags) { return static_cast<int>((flags & kRayHeroMask) >> kRayHeroShift); }

/// The wavelengths of a path; zeros in RGB mode.
inline Spectrum4 lane_wavelengths(const SceneView& scene, const Wave& wave, Slot slot) {
  return scene.color == ColorMode::kSpectral ? path_wavelengths<Scalar>(wave, &slot) : Spectrum4{};
}

/// The stretch of `length` metres from `origin` in the medium that `flags` (RayState::flags) name.
inline MediumRay make_medium_ray(const SceneView& scene, std::uint32_t flags, const Spectrum4& lambda, Vec3f origin,
                                 Vec3f direction, float length) {
  const MediumRow& medium = scene.media[(flags >> kRayMediumShift) - 1u];
  const MediumSpectra spectra = medium_spectra(scene, medium, lambda);
  const MediumEstimator estimator = scene.integrator.medium_estimator;
  const bool by_largest = (estimator == MediumEstimator::kDelta || estimator == MediumEstimator::kRatio) &&
                          (medium.flags & kMediumColored) == 0;
  int hero = hero_lane(flags);
  if (by_largest) {
    const Quad most =
        (medium.flags & kMediumAbsorptionScattering) != 0 ? spectra.first + spectra.second : spectra.first;
    for (int lane = 0; lane < 4; ++lane)
      if (most[lane] > most[hero]) hero = lane;
  }
  return {scene,  medium,    spectra,                      lambda,
          origin, direction, min(length, kLongestStretch), hero, !by_largest};
}

/// The mean over the lanes of probabilities, as light that is found is divided by it.
inline float lane_mean(const SceneView& scene, Quad r) {
  if (scene.color == ColorMode::kSpectral) return 0.25f * total(r);
  float lanes[4];
  r.store(lanes);
  return (lanes[0] + lanes[1] + lanes[2]) * (1.0f / 3.0f);
}

}  // namespace sheaf
