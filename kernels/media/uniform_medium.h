// Homogeneous media for the rays of a tile: the SIMD forms of track_homogeneous() and pass_homogeneous()
// (kernels/media/medium_tracking.h).
#pragma once

#include "kernels/media/medium_tracking.h"

namespace sheaf {

/// A medium at the wavelengths of the rays of a tile: homogeneous, or a grid where its density is 1.
template <class L> struct UniformMedium {
  Spectrum<L> sigma_s, sigma_t;  ///< 1/m
  typename L::Uint hero;         ///< lane by which distances are sampled
  bool weighted;                 ///< the other lanes have their own pdfs; see MediumRay
  bool scatters;                 ///< see kMediumScatters

  /// The component of the hero.
  SHEAF_INLINE Float<L> of_hero(const Spectrum<L>& s) const {
    using U = Uint<L>;
    return select(hero < U(2u), select(hero == U(0u), s.c0, s.c1), select(hero == U(2u), s.c2, s.c3));
  }
  /// See MediumRay::pdf_ratio().
  SHEAF_INLINE Spectrum<L> pdf_ratio(const Spectrum<L>& ratio) const {
    return weighted ? ratio : Spectrum<L>(of_hero(ratio));
  }
  /// Transmittance over a distance in meters.
  SHEAF_INLINE Spectrum<L> transmittance(Float<L> distance) const {
    return map_spectrum<L>(sigma_t, [distance](Float<L> sigma) SHEAF_LAMBDA_INLINE { return exp(sigma * -distance); });
  }
};

/// Throughput and RescaledPdfs of the paths of a tile.
template <class L> struct TileWeights {
  Spectrum<L> beta, r_u, r_l;

  /// See PathWeights::rescale().
  SHEAF_INLINE void rescale() {
    using F = Float<L>;
    const F largest = max_component(r_u);
    const F factor = select(largest > F(kLargestPdf), F(1.0f) / largest, F(1.0f));
    beta = beta * factor;
    r_u = r_u * factor;
    r_l = r_l * factor;
  }
};

/// Samples the distances at which paths scatter, by u in [0, 1), and updates their weights. Returns the distances, or
/// `length` where paths pass.
template <class L>
SHEAF_INLINE Float<L> track_uniform(const UniformMedium<L>& medium, Float<L> length, Float<L> u,
                                    TileWeights<L>& weights) {
  using F = Float<L>;
  if (!medium.scatters) {
    weights.beta = weights.beta * medium.transmittance(length);
    return length;
  }
  const F sigma = medium.of_hero(medium.sigma_t);
  const F sampled = select(sigma > F(0.0f), detail::exponential<L>(u) / max(sigma, F(1e-37f)), F(kInfinity));
  const auto scatters = sampled < length;
  const F t = select(scatters, sampled, length);
  // The pdf of passing is that of the hero's transmittance; scattering has the extinction as a factor.
  const Spectrum<L> passed = medium.transmittance(t);
  const F hero = medium.of_hero(passed);
  const Spectrum<L> ratio = passed * (F(1.0f) / (hero * select(scatters, sigma, F(1.0f))));
  weights.beta = weights.beta * ratio * select<L>(scatters, medium.sigma_s, Spectrum<L>(F(1.0f)));
  weights.r_u = weights.r_u * medium.pdf_ratio(ratio * select<L>(scatters, medium.sigma_t, Spectrum<L>(F(1.0f))));
  weights.r_l = weights.r_l * select(scatters, F(1.0f), F(1.0f) / hero);
  return t;
}

}  // namespace sheaf
