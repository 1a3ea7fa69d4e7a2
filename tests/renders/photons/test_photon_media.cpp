// Photons in media, as points and as beams: energy, and images against path tracing.
#include "kernels/passes/passes.h"
#include "kernels/passes/photon_mapping.h"
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "scene/data/glasses.h"
#include "tests/support/capture.h"
#include "tests/support/near.h"
#include "tests/support/photon_testing.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>

namespace sheaf::test_photon_media {

namespace {

const double kLevel = kPhotonLevel;

/// A map of about 20,000 volume photons, stored as points.
VolumePhotonMap volume_map(const Scene& scene, std::uint32_t seed) {
  StageContext context(scene);
  context.sampler.seed = seed;
  Workers workers([&] { return Worker(256, WaveNeeds::of(context)); });
  PhotonTracing tracing{[] { return false; }, [](std::uint64_t) {}};
  return trace_volume_photons(context, workers, {20000, 0.1f, PhotonKind::kVolume, 0}, tracing).points;
}

}  // namespace

TEST_CASE(
    "volume photons: photons in a large medium store the power of the light times the mean number of scatterings") {
  for (const float albedo : {0.3f, 0.8f}) {
    CAPTURE(albedo);
    Description d = empty_scene(4, 4);
    d.integrator.rr_depth = 3;
    // Almost no light reaches the walls.
    fill(d, add_shape(d, CubeShape{}, Transform::scale({100, 100, 100})), add_medium(d, fog(1, albedo)));
    add_point_light(d, {0.2f, 0.3f, -0.5f}, 3);
    const auto scene = compile_scene(d);
    MeanVariance mean;
    for (std::uint32_t seed = 0; seed < 12; ++seed) {
      const VolumePhotonMap map = volume_map(*scene, seed);
      double sum = 0;
      for (std::uint32_t i = 0; i < map.size(); ++i) sum += static_cast<double>(map.photon(i).power.c1);
      mean.add(sum);
    }
    const double a = static_cast<double>(albedo), expected = 4 * 3.14159265358979 * 3 * a / (1 - a);
    INFO("power " << mean.mean() << ", expected " << expected);
    CHECK(mean.p_value(expected) >= kLevel);
  }
}

TEST_CASE("volume photons: the hero wavelength alone carries the same power as all together") {
  // Rays of a single wavelength use the hero wavelength only. Its mean over maps equals that of the others, with and
  // without dispersion.
  MeanVariance total[2], first[2];
  for (const bool disperses : {false, true}) {
    Description d = empty_scene(4, 4);
    d.integrator.rr_depth = 3;
    MediumDescription medium;
    medium.coefficients = ExtinctionAlbedoDescription{SpectrumDescription::rgb(1.5f, 0.8f, 0.3f),
                                                      SpectrumDescription::rgb(0.6f, 0.7f, 0.8f)};
    fill(d, add_shape(d, CubeShape{}, Transform::scale({300, 300, 300})), add_medium(d, medium));
    add_point_light(d, {0.2f, 0.3f, -0.5f}, 3);
    DielectricDescription flint;
    flint.int_dispersion = *find_dispersion("sf11");
    if (disperses) add_sphere(d, {250, 250, 250}, 1).material = add_material(d, flint);
    const auto scene = compile_scene(d, {.color = ColorMode::kSpectral});
    for (std::uint32_t set = 0; set < 24; ++set) {
      StageContext context(*scene);
      context.sampler.seed = set;
      context.wavelength_sample = (static_cast<float>(set) + 0.5f) / 24;
      Workers workers([&] { return Worker(256, WaveNeeds::of(context)); });
      PhotonTracing tracing{[] { return false; }, [](std::uint64_t) {}};
      const VolumePhotonMap map =
          trace_volume_photons(context, workers, {4000, 0.1f, PhotonKind::kVolume, 0}, tracing).points;
      double sum = 0, of_first = 0;
      for (std::uint32_t i = 0; i < map.size(); ++i) {
        const VolumePhotonMap::Record& photon = map.photon(i);
        CHECK((photon.medium_key & kPhotonSingleWavelength) == 0);
        sum += static_cast<double>(photon.power.c0 + photon.power.c1 + photon.power.c2 + photon.power.c3);
        of_first += 4 * static_cast<double>(photon.power.c0);
      }
      total[disperses ? 1 : 0].add(sum);
      first[disperses ? 1 : 0].add(of_first);
    }
  }
  // Maps are stratified over wavelengths, so that sums vary far less than single maps.
  CHECK(total[1].mean() == near(total[0].mean(), 0.03));
  for (int i = 0; i < 2; ++i) CHECK(first[i].mean() == near(total[i].mean(), 0.03));
}

TEST_CASE("photons from distant light reach all of an unbounded medium") {
  // The medium ends at 1.01 of the radius of the scene. The share that scatters first beyond the radius has a closed
  // form.
  constexpr double kSigma = 2, kPiD = 3.14159265358979;
  Description d = empty_scene(4, 4);
  d.camera.medium = add_medium(d, fog(static_cast<float>(kSigma), 1));
  d.integrator.max_depth = 2;
  for (const float z : {-1.0f, 1.0f}) add_sphere(d, {0, 0, z}, 0.001f, add_diffuse(d, 0));
  for (const bool parallel : {true, false}) {
    CAPTURE(parallel);
    d.lights.clear();
    if (parallel)
      d.lights.push_back({DirectionalLightDescription{{0, 0, 1}, SpectrumDescription::constant(1)}, {}});
    else
      add_constant_light(d, 1);
    const auto scene = compile_scene(d);
    const double inner = static_cast<double>(scene->view().radius);
    const double outer = static_cast<double>(scene->view().media.outer_radius);
    CHECK(outer == near(1.01 * inner));
    // Directional light: rays farther than the radius from the axis. Environment light: points in the outer shell.
    double expected = 0;
    constexpr int kSteps = 400;
    for (int i = 0; i < kSteps; ++i) {
      const double r = inner + (outer - inner) * (i + 0.5) / kSteps, dr = (outer - inner) / kSteps;
      if (parallel) {
        expected += 2 * kPiD * r * dr * -std::expm1(-kSigma * 2 * std::sqrt(outer * outer - r * r));
        continue;
      }
      double fluence = 0;
      for (int k = 0; k < kSteps; ++k) {
        const double mu = (k + 0.5) * 2 / kSteps - 1;
        const double path_length = r * mu + std::sqrt(outer * outer - r * r * (1 - mu * mu));
        fluence += 2 * kPiD * 2 / kSteps * std::exp(-kSigma * path_length);
      }
      expected += 4 * kPiD * r * r * dr * kSigma * fluence;
    }
    MeanVariance mean;
    for (std::uint32_t seed = 0; seed < 16; ++seed) {
      const VolumePhotonMap map = volume_map(*scene, seed);
      double sum = 0;
      for (std::uint32_t i = 0; i < map.size(); ++i) {
        const AccelPoint p = map.points().points()[i];
        const double x = static_cast<double>(p.x), y = static_cast<double>(p.y), z = static_cast<double>(p.z);
        const double distance = std::sqrt(x * x + y * y + (parallel ? 0 : z * z));
        if (distance > inner) sum += static_cast<double>(map.photon(i).power.c1);
      }
      mean.add(sum);
    }
    INFO("power " << mean.mean() << ", expected " << expected << ", standard error "
                  << std::sqrt(mean.variance() / 16));
    CHECK(mean.p_value(expected) >= kLevel);
  }
}

TEST_CASE("volume photons: an unbounded emissive medium gives a warning and a bounded one does not") {
  for (const bool ends : {false, true}) {
    Description d = room(false, 1);
    d.integrator.kind = IntegratorKind::kPhotonMapper;
    MediumDescription medium = fog(1, 0.7f);
    medium.emission = SpectrumDescription::constant(1);
    const MediumId id = add_medium(d, medium);
    if (ends)
      fill(d, add_shape(d, CubeShape{}, Transform::scale({0.1f, 0.1f, 0.1f})), id);
    else
      d.camera.medium = id;
    CHECK(compile_scene(d)->warnings().empty() == ends);
  }
}

TEST_CASE("photon beams: power times length is the power of the light over the absorption coefficient") {
  Description d = empty_scene(4, 4);
  d.integrator.rr_depth = 3;
  MediumDescription medium;
  medium.coefficients =
      ExtinctionAlbedoDescription{SpectrumDescription::rgb(1.5f, 0.8f, 1), SpectrumDescription::rgb(0.6f, 0.7f, 0.8f)};
  fill(d, add_shape(d, CubeShape{}, Transform::scale({100, 100, 100})), add_medium(d, medium));
  add_point_light(d, {0.2f, 0.3f, -0.5f}, 3);
  d.integrator.photons.medium_photons = MediumPhotons::kBeams;
  const auto scene = compile_scene(d);
  std::array<MeanVariance, 3> mean;
  for (std::uint32_t seed = 0; seed < 12; ++seed) {
    StageContext context(*scene);
    context.sampler.seed = seed;
    Workers workers([&] { return Worker(256, WaveNeeds::of(context)); });
    workers.local().photons.begin(0, 3000, PhotonKind::kVolume);
    context.start_at_lights(PassKind::kPhoton, workers.local().photons);
    run_pass<Wide>(context, workers.local().wave);
    CHECK(context.light_task().stored.empty());
    std::array<double, 3> sum{};
    for (const PhotonBeam& beam : context.light_task().beams) {
      // The remaining power, integrated along the beam.
      constexpr int kSteps = 64;
      const double step = static_cast<double>(beam.length) / kSteps;
      for (int i = 0; i < kSteps; ++i) {
        const std::array passed{std::exp(-1.5 * step * (i + 0.5)), std::exp(-0.8 * step * (i + 0.5)),
                                std::exp(-1.0 * step * (i + 0.5))};
        const double comes =
            (passed[0] * static_cast<double>(beam.pdf_ratio.c0) + passed[1] * static_cast<double>(beam.pdf_ratio.c1) +
             passed[2] * static_cast<double>(beam.pdf_ratio.c2)) /
            3;
        sum[0] += step * static_cast<double>(beam.power.c0) * passed[0] / comes;
        sum[1] += step * static_cast<double>(beam.power.c1) * passed[1] / comes;
        sum[2] += step * static_cast<double>(beam.power.c2) * passed[2] / comes;
      }
    }
    for (std::size_t c = 0; c < 3; ++c) mean[c].add(sum[c] / 3000);
  }
  const std::array absorption{1.5 * 0.4, 0.8 * 0.3, 1.0 * 0.2};
  for (std::size_t c = 0; c < 3; ++c) {
    const double expected = 4 * 3.14159265358979 * 3 / absorption[c];
    INFO("lane " << c << ": " << mean[c].mean() << ", expected " << expected);
    CHECK(mean[c].p_value(expected) >= kLevel);
  }
}

TEST_SUITE_BEGIN("slow");

TEST_CASE("volume photons: light scattered in media has the mean of path tracing for every surface estimate") {
  const TemporaryFolder folder;
  const auto file = write_vol(folder.path() / "ramp.vol", 8, 1, [](Vec3f p, int) { return 0.3f + p.z * p.x; });
  enum What { kFog, kForward, kGrid, kGlowing, kCount };
  for (int what = 0; what < kCount; ++what) {
    CAPTURE(what);
    Description d = room(what == kFog, 36);
    MediumDescription medium;
    medium.coefficients = ExtinctionAlbedoDescription{SpectrumDescription::rgb(0.7f, 0.3f, 0.1f),
                                                      SpectrumDescription::rgb(0.8f, 0.7f, 0.9f)};
    if (what == kForward) medium.phase = add_phase(d, 0.6f);
    if (what == kGrid || what == kGlowing)
      medium.density = vol(file, Transform::translate({-1, -1, 0.2f}) * Transform::scale({2, 2, 1.5f}));
    if (what == kGlowing) medium.emission = SpectrumDescription::constant(5);
    if (what == kFog || what == kForward) {
      d.camera.medium = add_medium(d, medium);
    } else {
      fill(d, add_shape(d, CubeShape{}, Transform::translate({0, 0, 0.95f}) * Transform::scale({1, 1, 0.75f})),
           add_medium(d, medium));
    }
    const Mean path = path_mean(d, medium.density ? 100 : 400);  // grids are slow and scatter little
    d.integrator.kind = IntegratorKind::kPhotonMapper;
    d.integrator.photons.global = {30'000, 0.05f, 0};
    if (what == kFog) d.integrator.photons.caustic = {30'000, 0.02f, 0};
    d.integrator.photons.volume = {30'000, 0.03f, 0};
    // Not every combination: the variants differ where media meet.
    const bool fog = what == kFog, glowing = what == kGlowing;
    for (const auto& [gathering, checked] :
         {std::pair{PhotonGathering::kAll, fog || what == kForward},
          std::pair{PhotonGathering::kIndirect, fog || glowing}, std::pair{PhotonGathering::kFinal, fog || glowing}}) {
      CAPTURE_BINDING(gathering);
      d.integrator.photons.gathering = gathering;
      if (checked) check_close(mean_of(d), path, gathering == PhotonGathering::kAll ? 0.02 : 0.01);
    }
    if (what != kGrid) continue;
    d.integrator.photons.progressive = true;
    d.integrator.photons.gathering = PhotonGathering::kIndirect;
    d.integrator.photons.global.count = d.integrator.photons.volume.count = 3'000;
    check_close(mean_of(d), path, 0.01);
  }
}

TEST_CASE("photon beams: light scattered in media has the mean of path tracing beside grids as well") {
  const TemporaryFolder folder;
  const auto file = write_vol(folder.path() / "ramp.vol", 8, 1, [](Vec3f p, int) { return 0.3f + p.z * p.x; });
  enum What { kClear, kColored, kGlowing, kBesideGrid, kCount };
  for (int what = 0; what < kCount; ++what) {
    CAPTURE(what);
    Description d = room(false, 36);
    d.film.width = d.film.height = 12;
    MediumDescription medium = fog(what == kClear ? 0.1f : 0.4f, 0.9f);
    if (what == kColored || what == kBesideGrid)
      medium.coefficients = ExtinctionAlbedoDescription{SpectrumDescription::rgb(1.2f, 0.5f, 0.1f),
                                                        SpectrumDescription::rgb(0.8f, 0.7f, 0.9f)};
    if (what == kColored) medium.phase = add_phase(d, 0.6f);
    if (what == kGlowing) medium.emission = SpectrumDescription::constant(2);
    const MediumId id = add_medium(d, medium);
    if (what == kClear || what == kColored) d.camera.medium = id;
    const auto box = [&](float x, MediumId of) {
      fill(d, add_shape(d, CubeShape{}, Transform::translate({x, 0, 0.95f}) * Transform::scale({0.5f, 1, 0.75f})), of);
    };
    if (what == kGlowing || what == kBesideGrid) box(0.6f, id);
    if (what == kBesideGrid) {
      medium.density = vol(file, Transform::translate({-1, -1, 0.2f}) * Transform::scale({1, 2, 1.5f}));
      box(-0.6f, add_medium(d, medium));
    }
    const Mean path = path_mean(d, 100);
    d.integrator.kind = IntegratorKind::kPhotonMapper;
    d.integrator.photons.global = d.integrator.photons.volume = {10'000, 0.05f, 0};
    d.integrator.photons.medium_photons = MediumPhotons::kBeams;
    d.integrator.photons.gathering = what == kClear ? PhotonGathering::kFinal : PhotonGathering::kIndirect;
    if (what == kClear || what == kGlowing) check_close(mean_of(d), path, 0.01);
    if (what == kGlowing) continue;
    // More passes with independent maps reduce the error more than more samples of one.
    d.sampler.sample_count = 16;
    d.integrator.photons.gathering = PhotonGathering::kIndirect;
    d.integrator.photons.progressive = true;
    d.integrator.photons.medium_photons = MediumPhotons::kAuto;
    d.integrator.photons.global.count = d.integrator.photons.volume.count = 2'000;
    check_close(mean_of(d), path, 0.01);
  }
}

TEST_CASE("photon beams: caustics and media in glass and dispersed light agree with points") {
  enum What { kCaustic, kInGlass, kDispersed, kCount };
  for (int what = 0; what < kCount; ++what) {
    CAPTURE(what);
    Description d = room(what != kInGlass, 16);
    d.film.width = d.film.height = 12;
    MediumDescription medium;
    medium.coefficients = ExtinctionAlbedoDescription{SpectrumDescription::rgb(1.2f, 0.5f, 0.1f),
                                                      SpectrumDescription::rgb(0.8f, 0.7f, 0.9f)};
    const MediumId id = add_medium(d, medium);
    if (what == kInGlass) {
      add_sphere(d, {0.3f, -0.4f, 0.8f}, 0.6f, add_glass(d)).interior = id;
    } else {
      d.camera.medium = id;
    }
    if (what == kDispersed) {
      DielectricDescription flint;
      flint.int_dispersion = *find_dispersion("sf11");
      add_sphere(d, {0.6f, 0.4f, 0.8f}, 0.4f, add_material(d, flint));
    }
    d.integrator.kind = IntegratorKind::kPhotonMapper;
    d.integrator.photons.global = {100, 0.01f, 0};
    d.integrator.photons.volume = {10'000, 0.05f, 0};
    const auto scene_of = [&](MediumPhotons kept) {
      d.integrator.photons.medium_photons = kept;
      return compile_scene(d, {.color = what == kDispersed ? ColorMode::kSpectral : ColorMode::kRgb});
    };
    const auto points = scene_of(MediumPhotons::kPoints), beams = scene_of(MediumPhotons::kBeams);
    std::array<MeanVariance, 3> difference, mean;
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
      RenderOptions options;
      options.seed = seed;
      const Image a = render(*points, options).to_image(), b = render(*beams, options).to_image();
      for (int c = 0; c < 3; ++c) {
        double sum = 0, sum_of_both = 0;
        for (int y = 0; y < a.height; ++y)
          for (int x = 0; x < a.width; ++x) {
            sum += static_cast<double>(b.at(x, y, c)) - static_cast<double>(a.at(x, y, c));
            sum_of_both += static_cast<double>(b.at(x, y, c)) + static_cast<double>(a.at(x, y, c));
          }
        difference[static_cast<std::size_t>(c)].add(sum);
        mean[static_cast<std::size_t>(c)].add(0.5 * sum_of_both);
      }
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const double bias = 0.01 * mean[c].mean(), found = difference[c].mean();
      INFO("channel " << c << ": mean " << mean[c].mean() << ", difference " << found << ", standard error "
                      << std::sqrt(difference[c].variance() / 8));
      if (std::fabs(found) > bias) CHECK(difference[c].p_value(found > 0 ? bias : -bias) >= kLevel);
    }
  }
}

TEST_CASE("photon beams: spectral mode agrees with path tracing directly and through a dispersive slab") {
  Description d = empty_scene(16, 16);
  look_at(d, {0, -1.9f, 1}, {0, 0, 1}, {0, 0, 1}, 60);
  d.integrator.max_depth = 6;
  d.integrator.rr_depth = 20;
  add_shape(d, CubeShape{}, Transform::translate({0, 0, 1}) * Transform::scale({2, 2, 1}), add_diffuse(d, 0))
      .flip_normals = true;
  // A light out of view.
  emit(add_sphere(d, {0, -1.1f, 1.85f}, 0.1f), 100);
  MediumDescription medium;
  medium.coefficients = ExtinctionAlbedoDescription{SpectrumDescription::rgb(1.2f, 0.5f, 0.1f),
                                                    SpectrumDescription::rgb(0.8f, 0.7f, 0.9f)};
  d.camera.medium = add_medium(d, medium);
  // Rays of a single wavelength meet photons of four.
  DielectricDescription flint;
  flint.int_dispersion = *find_dispersion("sf11");
  add_shape(d, CubeShape{}, Transform::translate({0.5f, -1.4f, 1}) * Transform::scale({0.5f, 0.1f, 0.9f}),
            add_material(d, flint));
  const auto mean_color = [&](std::uint32_t samples) {
    d.sampler.sample_count = samples;
    return spectral_mean_of(d);
  };
  const auto path = mean_color(256);
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  d.integrator.photons.progressive = true;
  d.integrator.photons.global = {1, 0.01f, 0};
  d.integrator.photons.volume = {500, 0.05f, 0};
  const auto found = mean_color(64);
  for (std::size_t i = 0; i < 3; ++i) {
    CAPTURE(i);
    check_close({found[i].mean(), found[i].variance() / 8}, {path[i].mean(), path[i].variance() / 8}, 0.01);
  }
}

TEST_SUITE_END();

}  // namespace sheaf::test_photon_media
