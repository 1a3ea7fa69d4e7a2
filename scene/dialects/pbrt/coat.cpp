// The pbrt dialect: energy loss of layered materials in pbrt's random walk (Pharr et al. 2023, section 14.3), expressed
// as the base albedo with which Sheaf's closed-form clear coat reflects the same energy.
//
// pbrt fills the layer with an absorbing medium of extinction 1 unless the material has an 'albedo', so light is
// absorbed on each way through the layer. It ends each walk after `maxdepth` interfaces. Let t be the one-way
// transmittance, m the fraction that the coat returns to the base, including absorption, and K the number of
// reflections off a base of albedo a. Then
//   X = t^2 a (1 + a m + ... + (a m)^(K - 1))
// leaves the base for unit transmittance of the coat. Sheaf's closed form is X = b / (1 - b r), where r is m without
// absorption. The base albedo becomes b = X / (1 + X r).
#include "scene/dialects/pbrt/coat.h"

#include "core/math/fresnel.h"

#include <algorithm>
#include <cmath>

namespace sheaf::pbrt {

namespace {

/// Fractions of diffuse light from the base that the coat returns and transmits, with and without absorption.
struct CoatAlbedos {
  double returned = 0, returned_absorbed = 0, leaving = 0, leaving_absorbed = 0;

  void add_reflection(double weight, double cosine, double reflected, double thickness) {
    returned += weight;
    returned_absorbed += weight * std::exp(-thickness / cosine - thickness / reflected);
  }
  void add_transmission(double weight, double cosine, double thickness) {
    leaving += weight;
    leaving_absorbed += weight * std::exp(-thickness / cosine);
  }
};

/// Center of stratum `i` of `count` in [0, 1].
double middle(int i, int count) { return (i + 0.5) / count; }

CoatAlbedos smooth_albedos(double eta, double thickness) {
  constexpr int kDirections = 1024;
  CoatAlbedos albedos;
  for (int i = 0; i < kDirections; ++i) {
    const double cosine = middle(i, kDirections), reflectance = fresnel_reflectance(cosine, 1 / eta);
    const double weight = 2 * cosine / kDirections;
    albedos.add_reflection(weight * reflectance, cosine, cosine, thickness);
    albedos.add_transmission(weight * (1 - reflectance), cosine, thickness);
  }
  return albedos;
}

/// Single scattering by visible GGX microfacets, sampled as by Dupuy and Benyoub 2023.
CoatAlbedos rough_albedos(double alpha, double eta, double thickness) {
  // Many directions resolve the kink at the critical angle.
  constexpr int kDirections = 128, kDepths = 8, kAzimuths = 8;
  constexpr double kWeight = 1.0 / (kDirections * kDepths * kAzimuths);
  const auto shadowing = [&](double cosine) {
    return 2 * cosine / (cosine + std::sqrt(cosine * cosine + alpha * alpha * (1 - cosine * cosine)));
  };
  CoatAlbedos albedos;
  for (int i = 0; i < kDirections; ++i) {
    const double cosine = std::sqrt(middle(i, kDirections)), sine = std::sqrt(1 - cosine * cosine);
    const double stretched = std::hypot(alpha * sine, cosine), wx = alpha * sine / stretched, wz = cosine / stretched;
    for (int j = 0; j < kDepths; ++j)
      for (int k = 0; k < kAzimuths; ++k) {
        const double depth = middle(j, kDepths) * (1 + wz), r = std::sqrt(depth * (2 - depth));
        const double angle = 3.14159265358979 * middle(k, kAzimuths);  // the other half is symmetric
        const double x = alpha * (r * std::cos(angle) + wx), y = alpha * r * std::sin(angle), z = 1 - depth + wz;
        const double length = std::sqrt(x * x + y * y + z * z), c = (x * sine + z * cosine) / length, mz = z / length;
        if (!(c > 0)) continue;
        const double reflectance = fresnel_reflectance(std::min(c, 1.0), 1 / eta), reflected = 2 * c * mz - cosine;
        if (reflected > 0)
          albedos.add_reflection(kWeight * reflectance * shadowing(std::min(reflected, 1.0)), cosine, reflected,
                                 thickness);
        if (reflectance >= 1) continue;
        const double refracted = cosine * eta - mz * (c * eta - std::sqrt(1 - (1 - c * c) * eta * eta));
        if (refracted > 0)
          albedos.add_transmission(kWeight * (1 - reflectance) * shadowing(std::min(refracted, 1.0)), cosine,
                                   thickness);
      }
  }
  return albedos;
}

}  // namespace

LayeredBase::LayeredBase(double alpha, double eta, double thickness, int max_depth)
    : reflections_((max_depth + 1) / 2) {
  const CoatAlbedos albedos = alpha > 0 ? rough_albedos(alpha, eta, thickness) : smooth_albedos(eta, thickness);
  internal_reflectance_ = albedos.returned;
  round_trip_ = albedos.returned_absorbed;
  transmittance_ = albedos.leaving > 0 ? albedos.leaving_absorbed / albedos.leaving : 1;
}

float LayeredBase::albedo(float base) const {
  const double a = std::clamp(double{base}, 0.0, 1.0);
  double series = 0;
  for (int i = 0; i < reflections_; ++i) {
    series = 1 + a * round_trip_ * series;
    if (i > 1000) break;  // converged
  }
  const double x = transmittance_ * transmittance_ * a * series;
  return static_cast<float>(x / (1 + x * internal_reflectance_));
}

}  // namespace sheaf::pbrt
