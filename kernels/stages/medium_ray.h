// Construction of a MediumRay from a path's ray, and of a UniformMedium for the rays of a tile.
#pragma once

#include "kernels/media/medium_tracking.h"
#include "kernels/media/moving_medium.h"
#include "kernels/media/uniform_medium.h"
#include "kernels/wave/lane_mean.h"
#include "kernels/wave/path_wavelengths.h"

#include <bit>
#include <cmath>

namespace sheaf {

/// The hero lane, whose extinction is used to sample distances. Spectral mode: the first wavelength. RGB mode: each of
/// the three lanes with equal probability, chosen by the path's index.
inline int hero_lane(std::uint32_t flags) { return static_cast<int>((flags & kRayHeroMask) >> kRayHeroShift); }

/// Wavelengths of a path; 0 in RGB mode.
inline Spectrum4 lane_wavelengths(const SceneView& scene, const Wave& wave, Slot slot) {
  return scene.color == ColorMode::kSpectral ? path_wavelengths<Scalar>(wave, &slot) : Spectrum4{};
}

/// Distance at which a ray without a hit leaves an unbounded medium, at the radius MediumView::outer_radius; 0 if the
/// ray is already outside. Paths and shadow rays that leave the scene both end there, so both attenuate light from
/// outside alike.
template <class L>
SHEAF_INLINE Float<L> medium_end(const SceneView& scene, const Vec3<L>& origin, const Vec3<L>& direction) {
  using F = Float<L>;
  if (!(scene.media.outer_radius < kInfinity)) return F(kInfinity);
  const Vec3<L> from = origin - broadcast<L>(scene.center);
  const F b = dot(from, direction), c = dot(from, from) - F(sqr(scene.media.outer_radius));
  const F square = b * b - c;
  const F root = sqrt(max(square, F(0.0f)));
  const F end = max(select(b > F(0.0f), -c / (b + root), root - b), F(0.0f));
  return select(square > F(0.0f), end, F(0.0f));
}

/// The segment of `length` meters from `origin` in the medium given by `flags` (RayState::flags), at a time in [0, 1].
inline MediumRay make_medium_ray(const StageContext& context, std::uint32_t flags, const Spectrum4& lambda,
                                 Vec3f origin, Vec3f direction, float length, float time) {
  const std::uint32_t row = (flags >> kRayMediumShift) - 1u;
  const MediumRow& medium = context.scene.media.rows[row];
  if (context.scene.motion.media != nullptr) [[unlikely]]
    rest_ray(context.scene, row, time, origin, direction);
  MediumSpectra spectra = medium_spectra(context.scene, medium, lambda);
  if ((medium.flags & kMediumFlakes) != 0) weigh_by_flakes(medium, direction, spectra);
  const MediumEstimator estimator = context.integrator.medium_estimator;
  const bool by_largest = (estimator == MediumEstimator::kDelta || estimator == MediumEstimator::kRatio) &&
                          (medium.flags & kMediumColored) == 0;
  // Choose the hero lane.
  int hero = hero_lane(flags);
  if (by_largest) {
    const Float4 majorants =
        (medium.flags & kMediumAbsorptionScattering) != 0 ? spectra.first + spectra.second : spectra.first;
    for (int lane = 0; lane < 4; ++lane)
      if (majorants[lane] > majorants[hero]) hero = lane;
  }
  return {context.scene, medium, spectra, lambda, origin, direction, min(length, kLongestStretch), hero, !by_largest};
}

/// Whether a medium is the same everywhere and in all directions, so that make_uniform_medium() describes it.
inline bool is_uniform(const MediumRow& medium) {
  return (medium.flags & (kMediumHomogeneous | kMediumFlakes)) == kMediumHomogeneous;
}

/// The medium of row `row` for rays with RayState::flags `flags`; a grid where its density is 1. `lambda`: wavelengths
/// of the paths; ignored in RGB mode.
template <class L>
SHEAF_INLINE UniformMedium<L> make_uniform_medium(const StageContext& context, std::uint32_t row,
                                                  typename L::Uint flags, const Spectrum<L>& lambda) {
  using F = Float<L>;
  using U = Uint<L>;
  const SceneView& scene = context.scene;
  const MediumRow& medium = scene.media.rows[row];
  const auto spectrum = [&](std::uint32_t k, const float(&rgb)[4]) SHEAF_LAMBDA_INLINE {
    if (scene.color == ColorMode::kRgb) return Spectrum<L>{F(rgb[0]), F(rgb[1]), F(rgb[2]), F(rgb[3])};
    return evaluate<L>(scene.spectral.media, U(row * std::uint32_t{kMediumSpectra} + k), scene.spectral.tables, lambda);
  };
  const Spectrum<L> first = spectrum(0, medium.first), second = spectrum(1, medium.second);
  const bool by_albedo = (medium.flags & kMediumAbsorptionScattering) == 0;
  const Spectrum<L> sigma_t = by_albedo ? first : first + second;
  // Choose the hero lane
  const MediumEstimator estimator = context.integrator.medium_estimator;
  const bool by_largest = estimator == MediumEstimator::kDelta || estimator == MediumEstimator::kRatio;
  U hero = (flags & U(kRayHeroMask)) >> kRayHeroShift;
  if (by_largest) {
    const F largest = max_component(sigma_t);
    hero = select(sigma_t.c0 == largest, U(0u),
                  select(sigma_t.c1 == largest, U(1u), select(sigma_t.c2 == largest, U(2u), U(3u))));
  }
  return {by_albedo ? first * second : second, sigma_t, hero, !by_largest, (medium.flags & kMediumScatters) != 0};
}

/// Wavelengths of the paths of a tile; empty in RGB mode.
template <class L>
SHEAF_INLINE Spectrum<L> tile_wavelengths(const SceneView& scene, const Wave& wave, const Slot* slots) {
  return scene.color == ColorMode::kSpectral ? path_wavelengths<L>(wave, slots) : Spectrum<L>{};
}

/// Calls f(medium, lanes) for each row of a medium in `lanes`, with the lanes that are in it. `row`: kNone for vacuum.
template <class L, class F> SHEAF_INLINE void for_each_medium(Uint<L> row, Mask<L> lanes, F&& f) {
  const LaneArray<Uint<L>> rows(row);
  for (std::uint32_t left = mask_bits(lanes); left != 0;) {
    const std::uint32_t medium = rows[std::countr_zero(left)];
    const auto in_medium = (row == Uint<L>(medium)) & lanes;
    left &= ~mask_bits(in_medium);
    f(medium, in_medium);
  }
}

/// lane_mean() of a register.
inline float lane_mean(const SceneView& scene, Float4 r) { return lane_mean<Scalar>(scene.color, to_spectrum(r)); }

}  // namespace sheaf
