// Spectral mode where two parts of a path meet: camera paths, vertices and photons that each carry four wavelengths or
// the hero wavelength only. Every pair and every estimator that joins them is compared with path tracing, and path
// tracing strategies with each other.
#include "scene/data/glasses.h"
#include "tests/support/photon_testing.h"

#include <string>

namespace sheaf::test_photon_wavelengths {

namespace {

/// Dispersive glass, rough unless `alpha` is 0.
MaterialId add_flint(Description& d, float alpha) {
  DielectricDescription flint;
  flint.int_dispersion = *find_dispersion("sf11");
  if (alpha > 0) flint.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, alpha, alpha};
  return add_material(d, flint);
}

MediumDescription colored_fog(float density) {
  MediumDescription medium;
  medium.coefficients =
      ExtinctionAlbedoDescription{SpectrumDescription::rgb(1.6f * density, 0.5f * density, 0.1f * density),
                                  SpectrumDescription::rgb(0.8f, 0.7f, 0.9f)};
  return medium;
}

enum class Between { kNothing, kRoughBall, kRoughSheet, kSmoothSlab };

/// A light above a floor behind a dispersive object in front of the camera.
Description lit_through(Between what, float fog) {
  Description d = empty_scene(4, 4);
  look_at(d, {0, 0, 3.2f}, {0, 0, 0}, {0, 1, 0}, 30);
  d.integrator.max_depth = 4;
  d.integrator.rr_depth = 20;
  if (what == Between::kRoughBall) add_sphere(d, {0, 0, 0}, 0.8f, add_flint(d, 0.3f));
  if (what == Between::kRoughSheet) add_rectangle(d, Transform::scale({1.2f, 1.2f, 1}), add_flint(d, 0.3f));
  if (what == Between::kSmoothSlab)
    add_shape(d, CubeShape{}, Transform::translate({0, 0, 1.5f}) * Transform::scale({1.2f, 1.2f, 0.1f}),
              add_flint(d, 0));
  add_rectangle(d, Transform::translate({0, 0, -1}) * Transform::scale({1.5f, 1.5f, 1}),
                add_diffuse_rgb(d, 0.8f, 0.5f, 0.3f));
  emit(add_sphere(d, {0.3f, 0.2f, -0.9f}, 0.2f, add_diffuse(d, 0)), 20);
  emit(add_sphere(d, {1.4f, 0, 1}, 0.2f, add_diffuse(d, 0)), 20);
  if (fog > 0) d.camera.medium = add_medium(d, colored_fog(fog));
  return d;
}

void check_spectral(const std::array<MeanVariance, 3>& found, const std::array<MeanVariance, 3>& path, double bias) {
  for (std::size_t i = 0; i < 3; ++i) {
    CAPTURE(i);
    check_close({found[i].mean(), found[i].variance() / 8}, {path[i].mean(), path[i].variance() / 8}, bias);
  }
}

std::array<MeanVariance, 3> spectral_path(Description d, int samples) {
  d.integrator.kind = IntegratorKind::kPath;
  d.sampler.sample_count = static_cast<std::uint32_t>(samples);
  return spectral_mean_of(d);
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("spectral photon maps: rough dispersive glass agrees with paths for every kind of gathering") {
  Description d = lit_through(Between::kRoughBall, 0);
  const auto path = spectral_path(d, 256);
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  d.sampler.sample_count = 32;
  d.integrator.photons.global = {20'000, 0.07f, 0};
  for (const PhotonGathering gathering : {PhotonGathering::kAll, PhotonGathering::kIndirect, PhotonGathering::kFinal}) {
    CAPTURE(static_cast<int>(gathering));
    d.integrator.photons.gathering = gathering;
    d.integrator.photons.caustic = {gathering == PhotonGathering::kAll ? 0u : 3'000u, 0.07f, 0};
    check_spectral(spectral_mean_of(d), path, 0.02);
  }
  // Each sample is a pass with maps of its own.
  d.integrator.photons.progressive = true;
  d.integrator.photons.global.count = 1000;
  d.integrator.photons.caustic = {};
  d.integrator.photons.gathering = PhotonGathering::kIndirect;
  check_spectral(spectral_mean_of(d), path, 0.02);
}

TEST_CASE("spectral photon maps: light dispersed twice by rough glass agrees with paths") {
  Description d = empty_scene(6, 6);
  look_at(d, {0, 0, 3.2f}, {0, 0, 0}, {0, 1, 0}, 30);
  d.integrator.max_depth = 3;
  add_sphere(d, {0, 0, 0}, 0.8f, add_flint(d, 0.3f));
  add_area_light_rectangle(d, Transform::translate({0, 0, -3}), 6);
  const auto path = spectral_path(d, 256);
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  d.integrator.photons.progressive = true;
  d.integrator.photons.gathering = PhotonGathering::kIndirect;
  d.integrator.photons.global = {1000, 0.1f, 0};
  d.sampler.sample_count = 32;
  check_spectral(spectral_mean_of(d), path, 0.03);
}

TEST_CASE("spectral photon maps: colored fog that scatters paths and photons agrees with paths") {
  for (const Between what : {Between::kNothing, Between::kRoughSheet, Between::kSmoothSlab}) {
    CAPTURE(static_cast<int>(what));
    Description d = lit_through(what, 1);
    const auto path = spectral_path(d, 256);
    d.integrator.kind = IntegratorKind::kPhotonMapper;
    d.sampler.sample_count = 64;
    d.integrator.photons.global = {30'000, 0.1f, 0};
    check_spectral(spectral_mean_of(d), path, 0.02);
  }
}

TEST_CASE("spectral volume photons: points and beams in colored fog seen through dispersive glass agree with paths") {
  for (const Between what : {Between::kNothing, Between::kRoughSheet, Between::kSmoothSlab})
    for (const MediumPhotons kept : {MediumPhotons::kPoints, MediumPhotons::kBeams}) {
      CAPTURE(static_cast<int>(what));
      CAPTURE(static_cast<int>(kept));
      Description d = lit_through(what, 1);
      const auto path = spectral_path(d, 256);
      d.integrator.kind = IntegratorKind::kPhotonMapper;
      d.integrator.photons.medium_photons = kept;
      d.integrator.photons.global = {10'000, 0.1f, 0};
      d.integrator.photons.volume = {kept == MediumPhotons::kBeams ? 1'000u : 20'000u, 0.06f, 0};
      d.sampler.sample_count = 32;
      check_spectral(spectral_mean_of(d), path, 0.02);
    }
}

TEST_SUITE_END();

TEST_CASE(
    "spectral light sampling: light sampling through rough dispersive glass in colored fog agrees with BSDF "
    "sampling") {
  Description d = lit_through(Between::kRoughSheet, 1);
  d.integrator.max_depth = 3;
  d.integrator.strategy = LightStrategy::kBsdfOnly;
  const auto path = spectral_path(d, 2000);
  for (const int candidates : {1, 4}) {
    CAPTURE(candidates);
    d.integrator.candidates = candidates;
    for (const LightStrategy strategy : {LightStrategy::kLightOnly, LightStrategy::kMis}) {
      CAPTURE(static_cast<int>(strategy));
      d.integrator.strategy = strategy;
      check_spectral(spectral_path(d, 500), path, 0);
    }
  }
}

TEST_CASE("spectral light tracing: colored fog and rough dispersive glass agree with paths") {
  Description d = lit_through(Between::kRoughSheet, 1);
  d.integrator.strategy = LightStrategy::kBsdfOnly;
  const auto path = spectral_path(d, 2000);
  d.integrator.strategy = LightStrategy::kMis;
  d.integrator.kind = IntegratorKind::kLightTracer;
  d.sampler.sample_count = 1000;
  check_spectral(spectral_mean_of(d), path, 0);
}

}  // namespace sheaf::test_photon_wavelengths
