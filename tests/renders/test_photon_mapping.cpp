// Photon mapping: energy, and every combination of maps and final gathering against the path tracer, whose mean they
// share but for the blur of the radius.
#include "kernels/passes/passes.h"
#include "kernels/passes/photon_mapping.h"
#include "kernels/passes/render.h"
#include "scene/compile/compile.h"
#include "scene/data/glasses.h"
#include "tests/support/media_testing.h"
#include "tests/support/statistics.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>

namespace sheaf {

namespace {

const double kLevel = significance_of_each(100);

PhotonMap trace(const Scene& scene, std::uint32_t seed, std::uint64_t count, PhotonKind kind,
                std::vector<std::string>* warnings = nullptr) {
  StageContext context(scene);
  context.sampler.seed = seed;
  Workers workers([&] { return Worker(256, WaveNeeds::of(context)); });
  PhotonTracing tracing{[] { return false; }, [](std::uint64_t) {}};
  PhotonMap out = trace_photons(context, workers, {count, 0.1f, kind, 0}, tracing);
  if (warnings != nullptr) *warnings = tracing.warnings;
  return out;
}

double total_power(const PhotonMap& map) {
  double sum = 0;
  for (std::size_t i = 0; i < map.size(); ++i) sum += static_cast<double>(map.view().power[1][i]);
  return sum;
}

/// A room with a light below its ceiling, a ball of glass or of something diffuse on its floor, and a camera inside.
Description room(bool glass, std::uint32_t samples) {
  Description d = empty_scene(24, 24);
  d.sampler.sample_count = samples;
  look_at(d, {0, -1.9f, 1}, {0, 0, 0.7f}, {0, 0, 1}, 60);
  d.integrator.rr_depth = 20;
  d.integrator.max_depth = 8;
  ShapeDescription& walls = add_shape(d, CubeShape{}, Transform::translate({0, 0, 1}) * Transform::scale({2, 2, 1}),
                                      add_diffuse_rgb(d, 0.6f, 0.5f, 0.4f));
  walls.flip_normals = true;
  emit(add_rectangle(d,
                     Transform::translate({0.4f, 0.2f, 1.98f}) * Transform::rotate({1, 0, 0}, 180) *
                         Transform::scale({0.3f, 0.3f, 1}),
                     add_diffuse(d, 0)),
       10);
  add_sphere(d, {-0.2f, 0.3f, 0.55f}, 0.5f, glass ? add_glass(d) : add_diffuse(d, 0.7f));
  return d;
}

/// The mean of a picture.
struct Mean {
  double value, variance;  ///< of the mean
};
Mean mean_of(const Description& d, int repeats = 8) {
  const auto scene = compile_scene(d);
  MeanVariance mean;
  for (int i = 0; i < repeats; ++i) {
    RenderOptions options;
    options.seed = static_cast<std::uint32_t>(i + 1);
    const Image image = render(*scene, options).to_image();
    double sum = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) sum += static_cast<double>(image.at(x, y, 1));
    mean.add(sum / (image.width * image.height));
  }
  return {mean.mean(), mean.variance() / repeats};
}

/// The same by the path tracer, with many samples.
Mean path_mean(Description d, int samples = 400) {
  d.integrator.kind = IntegratorKind::kPath;
  d.sampler.sample_count = samples;
  return mean_of(d);
}

void check_close(const Mean& found, const Mean& expected, double bias) {
  const double error = std::sqrt(found.variance + expected.variance);
  INFO("mean " << found.value << ", path tracer " << expected.value << ", standard error " << error);
  const double distance = std::fabs(found.value - expected.value) - bias * expected.value;
  if (distance > 0) CHECK(student_t_p_value(distance / error, 14) >= kLevel);
}

}  // namespace

TEST_CASE("photon mapping: in a closed box photons leave the light's power over the share that is absorbed") {
  for (const float reflectance : {0.0f, 0.5f, 0.8f}) {
    CAPTURE(reflectance);
    Description d = empty_scene(4, 4);
    d.integrator.rr_depth = 3;
    ShapeDescription& box = add_shape(d, CubeShape{}, Transform(), add_diffuse(d, reflectance));
    box.flip_normals = true;
    add_point_light(d, {0.2f, 0.3f, -0.5f}, 3);
    const auto scene = compile_scene(d);
    MeanVariance mean;
    for (std::uint32_t seed = 0; seed < 12; ++seed) mean.add(total_power(trace(*scene, seed, 20000, PhotonKind::kAll)));
    const double expected = 4 * 3.14159265358979 * 3 / (1 - static_cast<double>(reflectance));
    INFO("power " << mean.mean() << ", expected " << expected);
    if (std::fabs(mean.mean() - expected) > 1e-4 * expected) CHECK(mean.p_value(expected) >= kLevel);
  }
}

TEST_CASE("photon mapping: the caustics map holds what specular surfaces alone have sent") {
  Description d = empty_scene(4, 4);
  // A mirror on the floor of a closed box sends a known share of the light to the walls.
  d.integrator.max_depth = -1;
  ShapeDescription& box = add_shape(d, CubeShape{}, Transform(), add_diffuse(d, 0.5f));
  box.flip_normals = true;
  add_rectangle(d, Transform::translate({0, 0, -0.9f}), add_mirror(d, 0.7f));
  add_point_light(d, {0, 0, 0.1f}, 1);
  const auto scene = compile_scene(d);
  MeanVariance mean;
  for (std::uint32_t seed = 0; seed < 12; ++seed)
    mean.add(total_power(trace(*scene, seed, 20000, PhotonKind::kCaustic)));
  // A square seen from one half side above its middle fills a sixth of the sphere.
  const double expected = 4 * 3.14159265358979 / 6 * 0.7;
  INFO("power " << mean.mean() << ", expected " << expected);
  CHECK(mean.p_value(expected) >= kLevel);
}

TEST_CASE(
    "photon mapping: a map that no light reaches is said to be empty, and the picture is what the camera sees of "
    "lights") {
  Description d = empty_scene(8, 8);
  add_sphere(d, {0, 0, 4}, 1, add_mirror(d, 0.5f));
  add_point_light(d, {0, 2, 0}, 5);
  std::vector<std::string> warnings;
  CHECK(trace(*compile_scene(d), 1, 1000, PhotonKind::kAll, &warnings).size() == 0);
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0].find("holds 0 of the 1000 photons") != std::string::npos);
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  d.integrator.photons.global.count = 1000;
  const RenderResult result = render(*compile_scene(d), {});
  CHECK(!result.interrupted);
  CHECK(result.warnings.size() == 1);
}

TEST_CASE("photon mapping: the same bits for all thread counts and wave sizes, and in a crop") {
  Description d = room(true, 2);
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  d.integrator.photons.global = {5000, 0.1f, 0};
  d.integrator.photons.caustic = {500, 0.05f, 0};
  d.integrator.photons.volume = {2000, 0.1f, 0};
  d.camera.medium = add_medium(d, fog(0.3f, 0.8f));
  struct Case {
    PhotonGathering gathering;
    bool progressive;
    ColorMode color;
  };
  for (const Case& c :
       {Case{PhotonGathering::kAll, false, ColorMode::kRgb}, Case{PhotonGathering::kFinal, false, ColorMode::kRgb},
        Case{PhotonGathering::kIndirect, true, ColorMode::kRgb},
        Case{PhotonGathering::kAll, true, ColorMode::kSpectral},
        Case{PhotonGathering::kIndirect, false, ColorMode::kSpectral}}) {
    d.integrator.photons.gathering = c.gathering;
    d.integrator.photons.progressive = c.progressive;
    const auto scene = compile_scene(d, {.color = c.color});
    const Image whole = render(*scene, {}).to_image();
    for (const int threads : {1, 2, 7})
      for (const int wave_size : {64, 1000}) {
        CAPTURE(threads);
        CAPTURE(wave_size);
        RenderOptions options;
        options.threads = threads;
        options.wave_size = wave_size;
        CHECK(render(*scene, options).to_image().data == whole.data);
      }
    RenderOptions options;
    options.crop = PixelRect{3, 5, 11, 9};
    const Image crop = render(*scene, options).to_image();
    bool same = true;
    for (int y = 0; y < crop.height; ++y)
      for (int x = 0; x < crop.width; ++x)
        for (int channel = 0; channel < static_cast<int>(crop.channels.size()); ++channel)
          same = same && crop.at(x, y, channel) == whole.at(x + 3, y + 5, channel);
    CHECK(same);
  }
}

TEST_CASE("photon mapping: passes have radii of their own, photons of their own, and wavelengths spread over all") {
  Description d = room(false, 4);
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  d.integrator.photons.global = {500, 0.3f, 0};
  d.integrator.photons.caustic = {0, 0.1f, 0};
  d.integrator.photons.alpha = 0.6f;
  d.integrator.photons.volume = {200, 0.2f, 0};
  d.camera.medium = add_medium(d, fog(0.3f, 0.8f));
  for (const bool progressive : {true, false}) {
    d.integrator.photons.progressive = progressive;
    const auto scene = compile_scene(d, {.color = ColorMode::kSpectral});
    StageContext context(*scene);
    context.sampler.seed = 5;
    Workers workers([&] { return Worker(256, WaveNeeds::of(context)); });
    PhotonTracing tracing{[] { return false; }, [](std::uint64_t) {}};
    PhotonMapping mapping(context, 64, 24);
    CHECK(mapping.wanted() == (progressive ? 64 * (500 + 200) : 32 * (16 + 7)));
    CHECK(mapping.samples_alike(10) == 1);
    double expected = 0.09;
    std::array<int, 16> strata{};
    std::set<float> first_places;
    for (std::uint32_t sample = 0; sample < 16; ++sample) {
      mapping.prepare(sample, workers, tracing, context);
      if (progressive && sample > 0) expected *= (sample + 0.6) / (sample + 1.0);
      const double radius = static_cast<double>(context.maps->global.radius);
      CHECK(radius * radius == doctest::Approx(expected).epsilon(1e-4));
      // Beams are blurred in one dimension, and progressive maps have them unless told otherwise.
      CHECK((context.maps->beams != nullptr) == progressive);
      CHECK((context.maps->volume->size() == 0) == progressive);
      if (progressive) {
        CHECK(context.maps->beams->size() > 0);
        CHECK(static_cast<double>(context.maps->beams->radius()) == doctest::Approx(0.2 * expected / 0.09));
      }
      first_places.insert(context.maps->global.x[0]);
      REQUIRE(context.wavelength_sample >= 0);
      REQUIRE(context.wavelength_sample < 1);
      ++strata[static_cast<std::size_t>(context.wavelength_sample * 16)];
    }
    CHECK(first_places.size() == 16);
    // Van der Corput's sequence, shifted: none is empty but for rounding at the borders.
    CHECK(std::count(strata.begin(), strata.end(), 0) <= 1);
    if (progressive) continue;
    // Sample 32 asks what sample 0 asked.
    for (std::uint32_t sample = 16; sample < 32; ++sample) mapping.prepare(sample, workers, tracing, context);
    mapping.prepare(32, workers, tracing, context);
    const float again = context.maps->global.x[0], wavelength = context.wavelength_sample;
    PhotonMapping other(context, 64, 24);
    other.prepare(0, workers, tracing, context);
    CHECK(context.maps->global.x[0] == again);
    CHECK(context.wavelength_sample == wavelength);
  }
}

TEST_CASE("volume photons: in a wide medium photons leave the light's power times the mean number of scatterings") {
  for (const float albedo : {0.3f, 0.8f}) {
    CAPTURE(albedo);
    Description d = empty_scene(4, 4);
    d.integrator.rr_depth = 3;
    // Hardly any light comes as far as the walls.
    fill(d, add_shape(d, CubeShape{}, Transform::scale({100, 100, 100})), add_medium(d, fog(1, albedo)));
    add_point_light(d, {0.2f, 0.3f, -0.5f}, 3);
    const auto scene = compile_scene(d);
    MeanVariance mean;
    for (std::uint32_t seed = 0; seed < 12; ++seed) {
      StageContext context(*scene);
      context.sampler.seed = seed;
      Workers workers([&] { return Worker(256, WaveNeeds::of(context)); });
      PhotonTracing tracing{[] { return false; }, [](std::uint64_t) {}};
      const VolumePhotonMap map =
          trace_volume_photons(context, workers, {20000, 0.1f, PhotonKind::kVolume, 0}, tracing).points;
      double sum = 0;
      for (std::uint32_t i = 0; i < map.size(); ++i) sum += static_cast<double>(map.photon(i).power.c1);
      mean.add(sum);
    }
    const double a = static_cast<double>(albedo), expected = 4 * 3.14159265358979 * 3 * a / (1 - a);
    INFO("power " << mean.mean() << ", expected " << expected);
    CHECK(mean.p_value(expected) >= kLevel);
  }
}

TEST_CASE("volume photons: where camera rays may lose wavelengths, photons have one, with the power of all") {
  // The total over all wavelengths is the same whichever way it is carried.
  MeanVariance total[2];
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
      double sum = 0;
      std::uint32_t single = 0;
      for (std::uint32_t i = 0; i < map.size(); ++i) {
        const VolumePhotonMap::Record& photon = map.photon(i);
        single += (photon.place & kPhotonSingleWavelength) != 0 ? 1u : 0u;
        sum += static_cast<double>(photon.power.c0 + photon.power.c1 + photon.power.c2 + photon.power.c3);
      }
      CHECK(single == (disperses ? map.size() : 0u));
      total[disperses ? 1 : 0].add(sum);
    }
  }
  // Sets are spread evenly over the wavelengths, so the sums are far closer than sets among each other.
  CHECK(total[1].mean() == doctest::Approx(total[0].mean()).epsilon(0.03));
}

TEST_CASE("volume photons: a medium that glows without an end is warned of, one that ends is not") {
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

TEST_CASE("photon beams: in a wide medium power times length is the light's power over what absorbs it") {
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
    context.photons = &workers.local().photons;
    run_photon_pass<Wide>(context, workers.local().wave);
    CHECK(context.photons->stored.empty());
    std::array<double, 3> sum{};
    for (const PhotonBeam& beam : context.photons->beams) {
      // What is left of the power, integrated over the beam.
      constexpr int kSteps = 64;
      const double step = static_cast<double>(beam.length) / kSteps;
      for (int i = 0; i < kSteps; ++i) {
        const std::array passed{std::exp(-1.5 * step * (i + 0.5)), std::exp(-0.8 * step * (i + 0.5)),
                                std::exp(-1.0 * step * (i + 0.5))};
        const double comes =
            (passed[0] * static_cast<double>(beam.odds.c0) + passed[1] * static_cast<double>(beam.odds.c1) +
             passed[2] * static_cast<double>(beam.odds.c2)) /
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

TEST_CASE("photon mapping: maps, final gathering and the caustics map have the path tracer's mean") {
  for (const bool glass : {false, true}) {
    CAPTURE(glass);
    Description d = room(glass, 36);
    const Mean path = path_mean(d);
    d.integrator.kind = IntegratorKind::kPhotonMapper;
    d.integrator.photons.global = {60'000, 0.05f, 0};
    for (const PhotonKernel kernel : {PhotonKernel::kCone, PhotonKernel::kEpanechnikov, PhotonKernel::kDisc}) {
      CAPTURE(static_cast<int>(kernel));
      d.integrator.photons.kernel = kernel;
      check_close(mean_of(d), path, 0.02);
    }
    d.integrator.photons.gathering = PhotonGathering::kIndirect;
    check_close(mean_of(d), path, 0.01);
    d.integrator.photons.caustic = {30'000, 0.02f, 0};
    check_close(mean_of(d), path, 0.01);
    d.integrator.photons.caustic = {};
    d.integrator.photons.gathering = PhotonGathering::kFinal;
    check_close(mean_of(d), path, 0.005);
    d.integrator.photons.caustic = {30'000, 0.02f, 0};
    check_close(mean_of(d), path, 0.005);
    d.integrator.photons.gather_rays = 4;
    d.sampler.sample_count = 9;
    check_close(mean_of(d), path, 0.005);
  }
}

TEST_CASE("photon mapping: depth is limited as it is for paths") {
  for (const int depth : {2, 3, 4}) {
    CAPTURE(depth);
    Description d = room(true, 36);
    d.integrator.max_depth = depth;
    const Mean path = path_mean(d);
    d.integrator.kind = IntegratorKind::kPhotonMapper;
    d.integrator.photons.global = {60'000, 0.05f, 0};
    check_close(mean_of(d), path, 0.02);
    d.integrator.photons.caustic = {30'000, 0.02f, 0};
    for (const PhotonGathering gathering : {PhotonGathering::kIndirect, PhotonGathering::kFinal}) {
      d.integrator.photons.gathering = gathering;
      check_close(mean_of(d), path, gathering == PhotonGathering::kFinal ? 0.005 : 0.01);
    }
  }
}

TEST_CASE("photon mapping: surfaces in fog, behind panes and with plastic's coat") {
  for (int what = 0; what < 3; ++what) {
    CAPTURE(what);
    Description d = room(true, 36);
    if (what == 0) {
      MediumDescription colored;
      colored.coefficients = ExtinctionAlbedoDescription{SpectrumDescription::rgb(0.7f, 0.1f, 0.3f),
                                                         SpectrumDescription::rgb(0.8f, 0.6f, 0.9f)};
      d.camera.medium = add_medium(d, colored);
    } else if (what == 1) {
      DielectricDescription pane;
      pane.thin = true;
      add_rectangle(d, Transform::translate({0.3f, 0, 1.2f}) * Transform::scale({0.5f, 0.5f, 1}),
                    add_material(d, pane));
      d.integrator.free_panes = true;
    } else {
      PlasticDescription plastic;
      add_sphere(d, {0.8f, 0.5f, 0.4f}, 0.4f, add_material(d, plastic));
    }
    const Mean path = path_mean(d);
    d.integrator.kind = IntegratorKind::kPhotonMapper;
    d.integrator.photons.global = {60'000, 0.05f, 0};
    check_close(mean_of(d), path, 0.02);
    d.integrator.photons.gathering = PhotonGathering::kFinal;
    check_close(mean_of(d), path, 0.005);
    d.integrator.photons.caustic = {30'000, 0.02f, 0};
    check_close(mean_of(d), path, 0.005);
  }
}

TEST_CASE("volume photons: what media scatter has the path tracer's mean, however surfaces are lit") {
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
    const Mean path = path_mean(d);
    d.integrator.kind = IntegratorKind::kPhotonMapper;
    d.integrator.photons.global = {30'000, 0.05f, 0};
    if (what == kFog) d.integrator.photons.caustic = {30'000, 0.02f, 0};
    d.integrator.photons.volume = {30'000, 0.03f, 0};
    // Not every medium in every way: these differ where they meet.
    const bool fog = what == kFog, glowing = what == kGlowing;
    for (const auto& [gathering, checked] :
         {std::pair{PhotonGathering::kAll, fog || what == kForward},
          std::pair{PhotonGathering::kIndirect, fog || glowing}, std::pair{PhotonGathering::kFinal, fog || glowing}}) {
      CAPTURE(static_cast<int>(gathering));
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

TEST_CASE("photon beams: what media scatter has the path tracer's mean, in homogeneous media and beside grids") {
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
    // Passes with maps of their own are worth more than many samples of one.
    d.sampler.sample_count = 16;
    d.integrator.photons.gathering = PhotonGathering::kIndirect;
    d.integrator.photons.progressive = true;
    d.integrator.photons.medium_photons = MediumPhotons::kAuto;
    d.integrator.photons.global.count = d.integrator.photons.volume.count = 2'000;
    check_close(mean_of(d), path, 0.01);
  }
}

TEST_CASE("photon beams: what glass has focused, media in glass and dispersed light are as points bring them") {
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

TEST_CASE("photon beams: in spectral mode, seen directly and through a slab that disperses, against the path tracer") {
  Description d = empty_scene(16, 16);
  look_at(d, {0, -1.9f, 1}, {0, 0, 1}, {0, 0, 1}, 60);
  d.integrator.max_depth = 6;
  d.integrator.rr_depth = 20;
  add_shape(d, CubeShape{}, Transform::translate({0, 0, 1}) * Transform::scale({2, 2, 1}), add_diffuse(d, 0))
      .flip_normals = true;
  // Out of view.
  emit(add_sphere(d, {0, -1.1f, 1.85f}, 0.1f), 100);
  MediumDescription medium;
  medium.coefficients = ExtinctionAlbedoDescription{SpectrumDescription::rgb(1.2f, 0.5f, 0.1f),
                                                    SpectrumDescription::rgb(0.8f, 0.7f, 0.9f)};
  d.camera.medium = add_medium(d, medium);
  // Rays of one wavelength meet photons of four.
  DielectricDescription flint;
  flint.int_dispersion = *find_dispersion("sf11");
  add_shape(d, CubeShape{}, Transform::translate({0.5f, -1.4f, 1}) * Transform::scale({0.5f, 0.1f, 0.9f}),
            add_material(d, flint));
  const auto mean_color = [&](int samples) {
    d.sampler.sample_count = samples;
    const auto scene = compile_scene(d, {.color = ColorMode::kSpectral});
    std::array<MeanVariance, 3> mean;
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
      RenderOptions options;
      options.seed = seed;
      const Image image = render(*scene, options).to_image();
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (int y = 0; y < image.height; ++y)
          for (int x = 0; x < image.width; ++x) sum += static_cast<double>(image.at(x, y, c));
        mean[static_cast<std::size_t>(c)].add(sum / (image.width * image.height));
      }
    }
    return mean;
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

TEST_CASE("progressive photon mapping: the mean comes to the path tracer's as radii shrink") {
  for (const bool glass : {false, true}) {
    CAPTURE(glass);
    Description d = room(glass, 1);
    const Mean path = path_mean(d);
    d.integrator.kind = IntegratorKind::kPhotonMapper;
    d.integrator.photons.progressive = true;
    d.integrator.photons.gathering = PhotonGathering::kIndirect;
    // So large that the corners lose light.
    d.integrator.photons.global = {4'000, 0.5f, 0};
    d.integrator.photons.alpha = 0.5f;
    const Mean first = mean_of(d, 40);
    d.sampler.sample_count = 64;
    const Mean many = mean_of(d);
    INFO("path tracer " << path.value << ", one pass " << first.value << ", 64 passes " << many.value);
    if (!glass) {
      CHECK(path.value - first.value > 0.02 * path.value + 4 * std::sqrt(first.variance + path.variance));
      CHECK(path.value - many.value < 0.5 * (path.value - first.value));
    }
    d.integrator.photons.global.radius = 0.08f;
    check_close(mean_of(d), path, 0.002);
    // As photons bring all light, and in final gathering.
    d.integrator.photons.global.radius = 0.04f;
    for (const PhotonGathering gathering : {PhotonGathering::kAll, PhotonGathering::kFinal}) {
      d.integrator.photons.gathering = gathering;
      check_close(mean_of(d), path, 0.005);
    }
  }
}

TEST_CASE("photon mapping: spectral maps agree with spectral paths, dispersion included") {
  const auto mean_color = [](const Description& d) {
    const auto scene = compile_scene(d, {.color = ColorMode::kSpectral});
    std::array<MeanVariance, 3> mean;
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
      RenderOptions options;
      options.seed = seed;
      const Image image = render(*scene, options).to_image();
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (int y = 0; y < image.height; ++y)
          for (int x = 0; x < image.width; ++x) sum += static_cast<double>(image.at(x, y, c));
        mean[static_cast<std::size_t>(c)].add(sum / (image.width * image.height));
      }
    }
    return mean;
  };
  for (const bool disperses : {false, true}) {
    CAPTURE(disperses);
    Description d = room(true, 400);
    if (disperses) {
      DielectricDescription flint;
      flint.int_dispersion = *find_dispersion("sf11");
      // A slab before the camera: paths and photons have both lost their other wavelengths where they meet.
      add_shape(d, CubeShape{}, Transform::translate({0, -1.4f, 1}) * Transform::scale({1, 0.1f, 0.9f}),
                add_material(d, flint));
      add_sphere(d, {0.6f, 0.4f, 0.4f}, 0.4f, add_material(d, flint));
    }
    const auto path = mean_color(d);
    d.integrator.kind = IntegratorKind::kPhotonMapper;
    d.integrator.photons.global = {200'000, 0.05f, 0};
    d.sampler.sample_count = 64;
    struct Case {
      PhotonGathering gathering;
      bool progressive;
      double bias;
    };
    for (const Case& c : {Case{PhotonGathering::kAll, false, 0.02}, Case{PhotonGathering::kFinal, false, 0.005},
                          Case{PhotonGathering::kIndirect, true, 0.008}}) {
      CAPTURE(static_cast<int>(c.gathering));
      d.integrator.photons.gathering = c.gathering;
      d.integrator.photons.progressive = c.progressive;
      d.integrator.photons.global.count = c.progressive ? 20'000 : 200'000;
      const auto found = mean_color(d);
      for (std::size_t i = 0; i < 3; ++i) {
        CAPTURE(i);
        check_close({found[i].mean(), found[i].variance() / 8}, {path[i].mean(), path[i].variance() / 8}, c.bias);
      }
    }
  }
}

TEST_SUITE_END();

}  // namespace sheaf
