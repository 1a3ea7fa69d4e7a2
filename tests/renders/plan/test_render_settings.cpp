// The settings of a render: what resolve_settings() derives from those of the scene and a request, and derived
// settings.
#include "core/io/error.h"
#include "kernels/passes/trace_photons.h"
#include "kernels/render/render_settings.h"
#include "tests/support/contains.h"

#include <doctest/doctest.h>

namespace sheaf::test_render_settings {

using test::contains;

namespace {

SceneSettings scene_settings() {
  SceneSettings scene;
  scene.film.width = 200;
  scene.film.height = 100;
  scene.film.filter = {PixelFilter::Kind::kGaussian, 2.0f, 0.5f};
  scene.sampler.sample_count = 64;
  scene.sampler.seed = 5;
  return scene;
}

RenderSettings resolved(const SceneSettings& scene, const RenderRequest& request = {}) {
  return resolve_settings(scene, ColorMode::kRgb, request);
}

std::string error_of(const SceneSettings& scene, const RenderRequest& request) {
  try {
    resolved(scene, request);
  } catch (const Error& error) {
    CHECK(error.exit_code() == ExitCode::kUsage);
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("render settings: requests replace the settings of the scene, which are the default") {
  SceneSettings scene = scene_settings();
  scene.film.crop = PixelRect{10, 10, 20, 20};
  RenderSettings settings = resolved(scene);
  CHECK(settings.spp == 64);
  CHECK(settings.sampler.seed == 5);
  CHECK(settings.crop == PixelRect{10, 10, 20, 20});
  CHECK(settings.reach == 2);
  CHECK(settings.sampled == PixelRect{8, 8, 22, 22});
  CHECK(settings.replicates == 2);
  CHECK_FALSE(settings.requests_replicates);
  CHECK_FALSE(settings.is_part);
  CHECK(settings.range == SampleRange{0, 64});
  RenderRequest request;
  request.samples_per_pixel = 96;
  request.seed = 7;
  request.crop = PixelRect{0, 0, 200, 1};
  request.replicates = 4;
  request.samples = SampleRange{24, 48};
  settings = resolved(scene, request);
  CHECK(settings.spp == 96);
  CHECK(settings.sampler.sample_count == 96);
  CHECK(settings.sampler.seed == 7);
  CHECK(settings.crop == PixelRect{0, 0, 200, 1});
  CHECK(settings.sampled == PixelRect{0, 0, 200, 3});
  CHECK(settings.replicate_samples == 24);
  CHECK(settings.is_part);
  CHECK(settings.range == SampleRange{24, 48});
}

TEST_CASE("render settings: samples of photon mapping count gather rays, and passes come before the sampler") {
  SceneSettings scene = scene_settings();
  scene.integrator.kind = IntegratorKind::kPhotonMapper;
  scene.integrator.photons.gathering = PhotonGathering::kFinal;
  scene.integrator.photons.gather_rays = 3;
  RenderSettings settings = resolved(scene);
  CHECK(settings.rays == 3);
  CHECK(settings.spp == 192);
  CHECK(settings.camera_samples() == 64);
  scene.integrator.photons = {};
  scene.integrator.photons.progressive = true;
  scene.integrator.photons.max_passes = 12;
  settings = resolved(scene);
  CHECK(settings.spp == 12);
  CHECK(settings.max_pass_samples == 1);
  RenderRequest request;
  request.samples_per_pixel = 20;
  CHECK(resolved(scene, request).spp == 20);
  request.samples_per_pixel = kMaxPhotonSets + 1;
  CHECK(contains(error_of(scene, request), "a pass for each sample per pixel"));
}

TEST_CASE("render settings: training passes and the trial of light candidates are planned") {
  SceneSettings scene = scene_settings();
  CHECK(resolved(scene).training.empty());
  RenderRequest request;
  request.guiding = GuidingMode::kAuto;
  CHECK(resolved(scene, request).training == training_passes(200, 100, 64, GuidingMode::kAuto));
  CHECK(resolved(scene, request).compares_candidates);
  scene.integrator.candidates = 2;
  CHECK_FALSE(resolved(scene, request).training.empty());
  CHECK_FALSE(resolved(scene, request).compares_candidates);
  scene.integrator.candidates.reset();
  scene.integrator.max_depth = 2;  // no indirect light
  CHECK(resolved(scene, request).training.empty());
  CHECK_FALSE(resolved(scene, request).compares_candidates);
}

TEST_CASE("render settings: other numbers of replicates are derived with the other settings unchanged") {
  RenderRequest request;
  request.samples = SampleRange{32, 32};
  const RenderSettings settings = resolved(scene_settings(), request), four = with_replicates(settings, 4);
  CHECK(settings.replicate_samples == 32);
  CHECK(four.replicate_samples == 16);
  CHECK(four.requests_replicates);
  CHECK(four.range == settings.range);
  CHECK(four.crop == settings.crop);
  CHECK_THROWS_AS(with_replicates(settings, 3), Error);  // sets of 22 samples
}

TEST_CASE("render settings: samples are divided among parts by whole sets") {
  const RenderSettings settings = resolved(scene_settings());  // 2 sets of 32 samples
  for (const std::uint32_t parts : {1u, 2u, 3u, 7u, 64u}) {
    const RenderSettings divided = with_replicates(settings, replicates_for_parts(settings, parts));
    const std::vector<SampleRange> ranges = divide_samples(divided, parts);
    REQUIRE(ranges.size() == parts);
    std::uint32_t first = 0;
    for (const SampleRange& range : ranges) {
      CHECK(range.first == first);
      CHECK(range.count > 0);
      CHECK(range.first % divided.replicate_samples == 0);
      first = range.end();
    }
    CHECK(first == 64);
  }
  RenderRequest request;
  request.replicates = 2;
  CHECK(replicates_for_parts(resolved(scene_settings(), request), 3) == 2);
  CHECK_THROWS_AS(divide_samples(resolved(scene_settings(), request), 3), Error);
  // A single set is split anywhere
  request.replicates = 1;
  CHECK(divide_samples(resolved(scene_settings(), request), 3)[1] == SampleRange{21, 21});
}

TEST_CASE("render settings: requests that are not possible are refused") {
  const auto error = [](auto change) {
    RenderRequest request;
    change(request);
    return error_of(scene_settings(), request);
  };
  CHECK(contains(error([](RenderRequest& r) {
                   r.crop = PixelRect{0, 0, 201, 1};
                 }),
                 "the crop window 0,0,201,1 is empty or reaches beyond the frame of 200 x 100 pixels"));
  CHECK(contains(error([](RenderRequest& r) { r.crop = PixelRect{5, 5, 5, 9}; }), "is empty"));
  CHECK(contains(error([](RenderRequest& r) { r.samples_per_pixel = 0; }), "at least 1"));
  CHECK(contains(error([](RenderRequest& r) { r.samples_per_pixel = 1u << 25; }), "must not exceed"));
  CHECK(contains(error([](RenderRequest& r) { r.samples = SampleRange{60, 5}; }), "out of range"));
  CHECK(contains(error([](RenderRequest& r) { r.samples = SampleRange{0, 8}; }), "split one of the 2 sample sets"));
  CHECK(contains(error([](RenderRequest& r) { r.spectral_bins = 4; }), "need spectral mode"));
}

}  // namespace sheaf::test_render_settings
