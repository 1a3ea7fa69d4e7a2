// Photon mapping: energy, and every combination of maps and final gathering against path tracing, which has the same
// mean except for the blur of the radius. Photons in media are tested in test_photon_media.cpp.
#include "kernels/passes/passes.h"
#include "kernels/passes/photon_mapping.h"
#include "kernels/render/render.h"
#include "kernels/render/render_state.h"
#include "scene/compile/compile.h"
#include "scene/data/glasses.h"
#include "tests/support/capture.h"
#include "tests/support/near.h"
#include "tests/support/photon_testing.h"
#include "tests/support/same_bits.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <set>
#include <string>

namespace sheaf::test_photon_mapping {

namespace {

const double kLevel = kPhotonLevel;

PhotonMap trace(const Scene& scene, std::uint32_t seed, std::uint64_t count, PhotonKind kind,
                std::vector<std::string>* warnings = nullptr) {
  StageContext context(scene);
  context.sampler.seed = seed;
  Workers workers([&] { return Worker(256, WaveNeeds::of(context)); });
  PhotonTracing tracing{[] { return false; }, [](std::uint64_t) {}};
  const std::uint64_t emitted = photons_to_emit(context, workers, kind, count, 64 * count, tracing);
  PhotonMap out = trace_photons(context, workers, {emitted, 0.1f, kind, 0}, tracing);
  if (warnings != nullptr) *warnings = tracing.warnings;
  return out;
}

/// A number that differs between maps of different photons.
float place_in(const PhotonMapView& map) {
  const Vec3f p = map.photon(map.size / 2).p;
  return p.x + p.y + p.z;
}

double total_power(const PhotonMap& map) {
  double sum = 0;
  const PhotonMapView view = map.view();
  for (std::uint32_t i = 0; i < view.size; ++i) sum += static_cast<double>(view.photon(i).power.c1);
  return sum;
}

}  // namespace

TEST_CASE("photon mapping: photons in a closed box store the power of the light over the absorbed share") {
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

TEST_CASE("photon mapping: the caustic map contains light from specular surfaces only") {
  Description d = empty_scene(4, 4);
  // A mirror on the floor of a closed box reflects a known fraction of the light to the walls.
  d.integrator.max_depth = -1;
  ShapeDescription& box = add_shape(d, CubeShape{}, Transform(), add_diffuse(d, 0.5f));
  box.flip_normals = true;
  add_rectangle(d, Transform::translate({0, 0, -0.9f}), add_mirror(d, 0.7f));
  add_point_light(d, {0, 0, 0.1f}, 1);
  const auto scene = compile_scene(d);
  MeanVariance mean;
  for (std::uint32_t seed = 0; seed < 12; ++seed)
    mean.add(total_power(trace(*scene, seed, 20000, PhotonKind::kCaustic)));
  // Seen from half a side above its center, a square covers one sixth of the sphere.
  const double expected = 4 * 3.14159265358979 / 6 * 0.7;
  INFO("power " << mean.mean() << ", expected " << expected);
  CHECK(mean.p_value(expected) >= kLevel);
}

TEST_CASE("photon mapping: an empty map is reported and the image shows only visible lights") {
  Description d = empty_scene(8, 8);
  add_sphere(d, {0, 0, 4}, 1, add_mirror(d, 0.5f));
  add_point_light(d, {0, 2, 0}, 5);
  std::vector<std::string> warnings;
  CHECK(trace(*compile_scene(d), 1, 1000, PhotonKind::kAll, &warnings).size() == 0);
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0].find("holds about 0 of the 1000 requested photons") != std::string::npos);
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  d.integrator.photons.global.count = 1000;
  const RenderResult result = render(*compile_scene(d), {});
  CHECK(!result.interrupted);
  CHECK(result.warnings.size() == 1);
}

TEST_CASE("photon mapping: the bits do not depend on threads or wave size or crop") {
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
    check_same_bits(*compile_scene(d, {.color = c.color}), {64, 1000});
  }
}

TEST_CASE("photon mapping: the number of stored photons is close to the requested one") {
  Description d = room(true, 1);
  const auto scene = compile_scene(d);
  for (const std::uint64_t count : {500u, 20'000u}) {
    CAPTURE(count);
    for (const PhotonKind kind : {PhotonKind::kAll, PhotonKind::kCaustic}) {
      CAPTURE(static_cast<int>(kind));
      std::vector<std::string> warnings;
      const std::size_t stored = trace(*scene, 3, count, kind, &warnings).size();
      CHECK(warnings.empty());
      CHECK(static_cast<double>(stored) == near(static_cast<double>(count), 0.25));
    }
  }
}

TEST_CASE("photon mapping: small maps have the power of large ones") {
  // Stopping when enough photons are stored and dividing by the number emitted would be biased by 1 / 64.
  Description d = empty_scene(4, 4);
  d.integrator.max_depth = 2;
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  add_rectangle(d, Transform::scale({0.4f, 0.4f, 1}), add_diffuse(d, 0.5f));
  add_point_light(d, {0, 0, 1}, 1);
  d.integrator.photons.progressive = true;
  d.integrator.photons.global = {64, 0.1f, 0};
  const auto scene = compile_scene(d);
  StageContext context(*scene);
  context.sampler.seed = 7;
  Workers workers([&] { return Worker(256, WaveNeeds::of(context)); });
  PhotonTracing tracing{[] { return false; }, [](std::uint64_t) {}};
  constexpr std::uint32_t kPasses = 4000;
  PhotonMapping mapping(context, kPasses, 4);
  MeanVariance mean;
  for (std::uint32_t pass = 0; pass < kPasses; ++pass) {
    mapping.prepare(pass, workers, tracing, context);
    const PhotonMapView& map = context.photon_maps().global;
    double sum = 0;
    for (std::uint32_t i = 0; i < map.size; ++i) sum += static_cast<double>(map.photon(i).power.c1);
    mean.add(sum);
  }
  // Solid angle of the square seen from above its center.
  const double expected = 4 * std::atan(0.16 / std::sqrt(1.32));
  INFO("power " << mean.mean() << ", expected " << expected << ", standard error "
                << std::sqrt(mean.variance() / kPasses));
  CHECK(mean.p_value(expected) >= kLevel);
}

TEST_CASE("photon mapping: sparse maps do not depend on threads or wave size or pauses or parts") {
  const TemporaryFolder folder;
  const RecordedSettings settings{{"--spp", "6"}, {"scene.xml", "1 bytes"}};
  Description d = empty_scene(8, 8);
  look_at(d, {0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 40);
  d.sampler.sample_count = 6;
  d.sampler.kind = SamplerKind::kIndependent;
  add_rectangle(d, Transform::scale({0.5f, 0.5f, 1}), add_diffuse_rgb(d, 0.8f, 0.5f, 0.2f));
  add_point_light(d, {0, 0, 20}, 1000);
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  d.integrator.photons.global = {300, 0.3f, 0};
  for (const bool progressive : {false, true}) {
    CAPTURE(progressive);
    d.integrator.photons.progressive = progressive;
    const auto scene = compile_scene(d);
    const RenderResult result = render(*scene, {});
    CHECK(result.warnings.size() == 1);
    const Image whole = result.to_image();
    for (const auto& [threads, wave_size] : {std::pair{1, 256}, std::pair{2, 1024}, std::pair{8, 320}}) {
      CAPTURE_BINDING(threads);
      RenderOptions options;
      options.threads = threads;
      options.wave_size = wave_size;
      CHECK(render(*scene, options).to_image().data == whole.data);
      // The render is paused after about two samples and resumed.
      std::atomic<int> asked{0};
      std::atomic<bool> stop{false};
      options.stop = &stop;
      options.wants_pause = [&] { return asked.fetch_add(1) >= 1 && (stop = true); };
      options.on_pause = [&](const RenderState& state) { write_checkpoint(folder / "half", settings, state); };
      render(*scene, options);
      RenderState state = read_checkpoint(folder / "half", settings);
      RenderOptions rest;
      rest.threads = 3 - threads / 4;
      rest.resume = &state;
      CHECK(render(*scene, rest).to_image().data == whole.data);
    }
    // The samples are rendered in two parts.
    Image sum(8, 8, whole.channels);
    for (const SampleRange range : {SampleRange{0, 2}, SampleRange{2, 4}}) {
      RenderOptions options;
      options.samples = range;
      options.threads = static_cast<int>(range.count);
      const Image part = render(*scene, options).film.to_image();
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) sum.at(x, y, 0) += part.at(x, y, 0) * static_cast<float>(range.count) / 6;
    }
    float largest = 0;
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        CHECK(sum.at(x, y, 0) == near(whole.at(x, y, 0), 1e-5));
        largest = std::max(largest, whole.at(x, y, 0));
      }
    CHECK(largest > 0);
  }
}

TEST_CASE("photon mapping: each pass has its own radius and photons and wavelengths") {
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
    CHECK(mapping.photon_total() == (progressive ? 64 * (500 + 200) : 32 * (16 + 7)));
    CHECK(photon_map_sets(d.integrator.photons, ColorMode::kSpectral, 64) == (progressive ? 64 : 32));
    double expected = 0.09;
    std::array<int, 16> strata{};
    std::set<float> positions;
    for (std::uint32_t sample = 0; sample < 16; ++sample) {
      mapping.prepare(sample, workers, tracing, context);
      if (progressive && sample > 0) expected *= (sample + 0.6) / (sample + 1.0);
      const double radius = static_cast<double>(context.photon_maps().global.radius);
      CHECK(radius * radius == near(expected, 1e-4));
      // Beams are blurred in one dimension. Progressive maps use them by default.
      CHECK((context.photon_maps().volume->beams.size() > 0) == progressive);
      CHECK((context.photon_maps().volume->points.size() == 0) == progressive);
      if (progressive) {
        CHECK(static_cast<double>(context.photon_maps().volume->beams.radius()) == near(0.2 * expected / 0.09));
      }
      positions.insert(place_in(context.photon_maps().global));
      REQUIRE(context.wavelength_sample >= 0);
      REQUIRE(context.wavelength_sample < 1);
      ++strata[static_cast<std::size_t>(context.wavelength_sample * 16)];
    }
    CHECK(positions.size() == 16);
    // The shifted sequence of van der Corput leaves no stratum empty, except by rounding at its bounds.
    CHECK(std::count(strata.begin(), strata.end(), 0) <= 1);
    if (progressive) continue;
    // Sample 32 requests the same wavelengths as sample 0.
    for (std::uint32_t sample = 16; sample < 32; ++sample) mapping.prepare(sample, workers, tracing, context);
    mapping.prepare(32, workers, tracing, context);
    const float again = place_in(context.photon_maps().global), wavelength = context.wavelength_sample;
    PhotonMapping other(context, 64, 24);
    other.prepare(0, workers, tracing, context);
    CHECK(place_in(context.photon_maps().global) == again);
    CHECK(context.wavelength_sample == wavelength);
  }
}

TEST_SUITE_BEGIN("slow");

TEST_CASE("photon mapping: maps and final gathering and caustic maps have the mean of path tracing") {
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
    d.integrator.photons.caustic = {30'000, 0.02f, 0};
    check_close(mean_of(d), path, 0.02);
    d.integrator.photons.caustic = {};
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

TEST_CASE("photon mapping: depth is limited as for paths") {
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

TEST_CASE("photon mapping: surfaces in fog and behind thin dielectrics and plastics have the mean of path tracing") {
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
      d.integrator.thin_dielectrics_are_free = true;
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

TEST_CASE("progressive photon mapping: the mean converges to path tracing as radii shrink") {
  for (const bool glass : {false, true}) {
    CAPTURE(glass);
    Description d = room(glass, 1);
    const Mean path = path_mean(d);
    d.integrator.kind = IntegratorKind::kPhotonMapper;
    d.integrator.photons.progressive = true;
    d.integrator.photons.gathering = PhotonGathering::kIndirect;
    // The radius is so large that corners lose light.
    d.integrator.photons.global = {4'000, 0.5f, 0};
    d.integrator.photons.alpha = 0.5f;
    const Mean first = mean_of(d, 100);
    d.sampler.sample_count = 64;
    const Mean many = mean_of(d);
    INFO("path tracer " << path.value << ", one pass " << first.value << ", 64 passes " << many.value);
    if (!glass) {
      CHECK(path.value - first.value > 0.02 * path.value + 4 * std::sqrt(first.variance + path.variance));
      CHECK(path.value - many.value < 0.5 * (path.value - first.value));
    }
    d.integrator.photons.global.radius = 0.08f;
    check_close(mean_of(d), path, 0.002);
    // With all light from photons, and with final gathering.
    d.integrator.photons.global.radius = 0.04f;
    for (const PhotonGathering gathering : {PhotonGathering::kAll, PhotonGathering::kFinal}) {
      d.integrator.photons.gathering = gathering;
      check_close(mean_of(d), path, 0.005);
    }
  }
}

TEST_CASE("photon mapping: spectral maps agree with spectral paths with dispersion included") {
  for (const bool disperses : {false, true}) {
    CAPTURE(disperses);
    Description d = room(true, 400);
    if (disperses) {
      d.film.width = d.film.height = 24;  // few samples see light that is refracted twice
      DielectricDescription flint;
      flint.int_dispersion = *find_dispersion("sf11");
      // A slab in front of the camera, so that both paths and photons carry a single wavelength where they meet.
      add_shape(d, CubeShape{}, Transform::translate({0, -1.4f, 1}) * Transform::scale({1, 0.1f, 0.9f}),
                add_material(d, flint));
      add_sphere(d, {0.6f, 0.4f, 0.4f}, 0.4f, add_material(d, flint));
    }
    const auto path = spectral_mean_of(d);
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
      const auto found = spectral_mean_of(d);
      for (std::size_t i = 0; i < 3; ++i) {
        CAPTURE(i);
        check_close({found[i].mean(), found[i].variance() / 8}, {path[i].mean(), path[i].variance() / 8}, c.bias);
      }
    }
  }
}

TEST_SUITE_END();

}  // namespace sheaf::test_photon_mapping
