// Radiance that a homogeneous medium scatters from photon beams towards a ray (Jarosz, Nowrouzezahrai, Sadeghi and
// Jensen 2011, "A Comprehensive Theory of Volumetric Radiance Estimation Using Photon Points and Beams": the beam-beam
// estimate with a one-dimensional blur, and beams that end where the photon is scattered):
//     L = sum of T(t_i) sigma_s p Phi_i(s_i) k(d_i) / sin(theta_i)
// Beam i is nearest to the ray at distance t_i along the ray and s_i along the beam. d_i is the distance between both
// at these points, and theta_i the angle between their directions. T is the transmittance, p the phase function, and k
// the kernel over [-radius, radius].
//
// A beam reaches s with probability T(s), which already accounts for the loss of power, so Phi remains the power at the
// start. If the lanes differ in extinction, any of them could have sampled the flight. Then Phi(s) is Phi T(s) over the
// mean over the lanes of the pdf ratios times T(s), as r_u would be for a photon scattered at s. This holds for each
// lane alone, and so also for rays that have lost the other wavelengths.
#pragma once

#include "core/color/wavelengths.h"
#include "core/soa/lane_array.h"
#include "kernels/media/phase_value.h"
#include "kernels/photons/photon_kernel.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/stages/medium_ray.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

/// A ray from the camera that gathers beams.
struct GatheringRay {
  MediumRay seen;            ///< in a homogeneous medium
  Spectrum4 lambda;          ///< of photons that still have four wavelengths
  bool single_wavelength;    ///< the ray has one wavelength left
  std::uint32_t medium;      ///< 1 + its row
  std::uint32_t edges_left;  ///< maximum number of segments of a photon's path
};

/// Finds the beams near the ray that count, in the order of their distance from its origin.
inline void find_beams(const PhotonBeamMap& map, const GatheringRay& ray, std::vector<NearLine>& found) {
  found.clear();
  if (ray.edges_left == 0 || !ray.seen.has(kMediumScatters)) return;
  map.lines().near_ray(ray.seen.origin, ray.seen.direction, ray.seen.length, found);
  const auto counts_not = [&](const NearLine& line) {
    const std::uint32_t medium_key = map.beam(line.index).medium_key;
    return (medium_key & kMaxPhotonEdges) > ray.edges_left || medium_key >> kPhotonMediumShift != ray.medium;
  };
  found.erase(std::remove_if(found.begin(), found.end(), counts_not), found.end());
  std::sort(found.begin(), found.end(),
            [](const NearLine& a, const NearLine& b) { return a.t != b.t ? a.t < b.t : a.index < b.index; });
}

/// Phi(s) over Phi, for lanes that differ in extinction.
class FlightTransmittance {
 public:
  FlightTransmittance(const StageContext& context, std::uint32_t flags, const GatheringRay& ray)
      : flight_(make_medium_ray(context, flags, ray.lambda, ray.seen.origin, ray.seen.direction, 0.0f, 0.0f)),
        sigma_t_(medium_coefficients(flight_.medium, flight_.spectra).sigma_t) {}

  Float4 operator()(const PhotonBeamMap::Record& beam, float along) const {
    // All lanes hold the same wavelength.
    if ((beam.medium_key & kPhotonSingleWavelength) != 0) return Float4(1.0f);
    const Float4 passed = transmittance(sigma_t_, along);
    return passed * (1.0f / lane_mean(flight_.scene, Float4(beam.pdf_ratio) * flight_.pdf_ratio(passed)));
  }

 private:
  MediumRay flight_;
  Float4 sigma_t_;
};

/// Radiance due to the beams. `flags`: RayState::flags of the ray.
template <class L>
Float4 gather_beams(const StageContext& context, const PhotonBeamMap& map, std::uint32_t flags, const GatheringRay& ray,
                    std::vector<NearLine>& found) {
  using F = Float<L>;
  find_beams(map, ray, found);
  if (found.empty()) return Float4();
  const MediumCoefficients c = medium_coefficients(ray.seen.medium, ray.seen.spectra);
  const Float4 sigma_t = c.sigma_t;
  const bool alike = ray.seen.has(kMediumGray);
  const FlightTransmittance flight_transmittance(context, flags, ray);
  Float4 sum;
  for (std::size_t first = 0; first < found.size(); first += L::width) {
    LaneArray<F> cosines(F(0.0f)), sines(F(1.0f)), squares(F(0.0f));
    const int count = static_cast<int>(std::min<std::size_t>(L::width, found.size() - first));
    for (int i = 0; i < count; ++i) {
      const NearLine& line = found[first + static_cast<std::size_t>(i)];
      cosines[i] = line.cosine, sines[i] = line.sine, squares[i] = line.squared;
    }
    // Phase functions depend on directions only by the angle.
    const F sine = sines.load();
    const F phase = phase_value<L>(context.scene, ray.seen.medium.phase, Vec3<L>{sine, F(0.0f), cosines.load()});
    const LaneArray<F> weights(phase * beam_kernel<L>(map.kernel(), squares.load()) / sine);
    for (int i = 0; i < count; ++i) {
      const NearLine& line = found[first + static_cast<std::size_t>(i)];
      const PhotonBeamMap::Record& beam = map.beam(line.index);
      // Ray and photon both compensate for lost wavelengths by a factor of 4, which must apply once.
      const bool both = ray.single_wavelength && (beam.medium_key & kPhotonSingleWavelength) != 0;
      const Float4 power = alike ? Float4(beam.power) : Float4(beam.power) * flight_transmittance(beam, line.along);
      sum = sum + power * transmittance(sigma_t, line.t) * (both ? 0.25f * weights[i] : weights[i]);
    }
  }
  return sum * c.sigma_s * (0.5f / map.radius());
}

}  // namespace sheaf
