// The plan of a render: rounds and tasks hand out every sample once, and a resumed plan hands out the others.
#include "core/io/error.h"
#include "kernels/render/render.h"
#include "kernels/render/sample_plan.h"
#include "scene/compile/compile.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <limits>
#include <map>
#include <utility>

namespace sheaf::test_sample_plan {

namespace {

constexpr int kFrameWidth = 70, kFrameHeight = 50;

std::unique_ptr<Scene> lit_scene(std::uint32_t samples, IntegratorKind kind = IntegratorKind::kPath) {
  Description d = empty_scene(kFrameWidth, kFrameHeight);
  d.sampler.sample_count = samples;
  d.sampler.kind = SamplerKind::kSobol;
  d.film.filter.kind = PixelFilter::Kind::kGaussian;
  d.integrator.kind = kind;
  add_point_light(d, {0, 1, 0}, 1);
  return compile_scene(d);
}

SamplePlan plan_of(const Scene& scene, const RenderOptions& options = {}) {
  return SamplePlan(scene, resolve_settings(scene, options), options.resume);
}

/// What tasks were asked to take.
struct Asked {
  std::uint64_t samples = 0, photons = 0;
  int training = 0, tasks = 0;
  /// For each pixel and replicate of adaptive sampling, or 0: the number of samples, which come in order.
  std::map<std::tuple<int, int, std::uint32_t>, std::uint32_t> per_pixel;
};

void finish_tile(SamplePlan& plan, std::size_t i, Asked& asked) {
  const TileTask task = plan.tile_task(i);
  const PixelRect& requested = task.tile.sampled;
  for (int y = requested.y0; y < requested.y1; ++y)
    for (int x = requested.x0; x < requested.x1; ++x) {
      std::uint32_t& next = asked.per_pixel[{x, y, plan.state().adaptive ? task.replicate : 0}];
      CHECK(task.first_sample == next);
      next += task.sample_count;
    }
  asked.samples += requested.area() * task.sample_count;
  FilmTile tile;
  plan.begin_tile(task, tile);
  plan.finish_tile(i, tile);
}

/// Finishes tasks, up to a number of them, without taking any samples.
void take(SamplePlan& plan, Asked& asked, int most = std::numeric_limits<int>::max()) {
  while (asked.tasks < most && plan.begin_round()) {
    if (plan.round() == RoundKind::kTraining) ++asked.training;
    for (std::size_t i = 0; i < plan.task_count() && asked.tasks < most; ++i) {
      if (plan.is_done(i)) continue;
      ++asked.tasks;
      if (plan.round() == RoundKind::kPhotons) {
        CHECK(plan.photon_task(i).first == asked.photons);
        asked.photons += static_cast<std::uint64_t>(plan.photon_task(i).count);
        plan.finish_photons(i, {});
      } else {
        finish_tile(plan, i, asked);
      }
    }
    const bool is_whole = plan.end_round();
    CHECK((is_whole || asked.tasks == most));
  }
}

bool all_pixels_have(const Asked& asked, std::uint32_t samples) {
  for (const auto& [pixel, count] : asked.per_pixel)
    if (count != samples) return false;
  return !asked.per_pixel.empty();
}

}  // namespace

TEST_CASE("sample plan: passes hand out all samples of all pixels in order") {
  const auto scene = lit_scene(300);
  RenderOptions options;
  options.replicates = 3;
  options.aovs = {aov_named("half")};
  SamplePlan plan = plan_of(*scene, options);
  CHECK(plan.samples_before() == 0);
  Asked asked;
  take(plan, asked);
  CHECK(all_pixels_have(asked, 300));
  CHECK(asked.per_pixel.size() == std::size_t{kFrameWidth * kFrameHeight});
  CHECK(asked.samples == plan.sample_total());
  CHECK(asked.photons == 0);
  CHECK(asked.training == 0);
  CHECK(plan.state().first_sample == 300);
  plan.end(false);
  CHECK_FALSE(plan.is_incomplete());
}

TEST_CASE("sample plan: adaptive sampling without a target takes all samples, and may end after the first round") {
  const auto scene = lit_scene(64);
  RenderOptions options;
  options.time_limit = 1;
  SamplePlan plan = plan_of(*scene, options);
  REQUIRE(plan.begin_round());
  CHECK_FALSE(plan.may_end_early());
  Asked asked;
  take(plan, asked, static_cast<int>(plan.task_count()) + 1);
  CHECK(plan.may_end_early());
  take(plan, asked);
  CHECK(all_pixels_have(asked, 64 / AdaptiveFilm::kSets));
  CHECK(asked.samples == plan.sample_total());
}

TEST_CASE("sample plan: light tracing hands out a photon per sample after the samples of the camera") {
  const auto scene = lit_scene(9, IntegratorKind::kLightTracer);
  SamplePlan plan = plan_of(*scene);
  Asked asked;
  take(plan, asked);
  CHECK(asked.photons == std::uint64_t{kFrameWidth * kFrameHeight * 9});
  CHECK(plan.state().photons == asked.photons);
  CHECK(asked.samples + asked.photons == plan.sample_total());
}

TEST_CASE("sample plan: training comes first, and only if samples remain") {
  const auto scene = lit_scene(32);
  RenderOptions options;
  options.guiding = GuidingMode::kOn;
  SamplePlan plan = plan_of(*scene, options);
  REQUIRE(plan.begin_round());
  CHECK(plan.round() == RoundKind::kTraining);
  Asked asked;
  take(plan, asked);
  CHECK(asked.training == 1);
  CHECK(all_pixels_have(asked, 32));
  RenderState end = plan.checkpoint({});
  options.resume = &end;
  CHECK_FALSE(plan_of(*scene, options).begin_round());
}

TEST_CASE("sample plan: a resumed plan hands out the tasks that were not done, from any round") {
  for (const IntegratorKind kind : {IntegratorKind::kPath, IntegratorKind::kLightTracer})
    for (const double noise_target : {0.0, 1e-9}) {
      if (kind == IntegratorKind::kLightTracer && noise_target > 0) continue;
      CAPTURE(static_cast<int>(kind));
      CAPTURE(noise_target);
      const auto scene = lit_scene(64, kind);
      // Each of the two passes has 20 tasks, a round of adaptive sampling 24, and one of photons 14.
      for (const int tasks : {1, 5, 23, 45}) {
        if (kind == IntegratorKind::kPath && noise_target == 0.0 && tasks > 40) continue;
        CAPTURE(tasks);
        RenderOptions options;
        options.noise_target = noise_target;
        SamplePlan plan = plan_of(*scene, options);
        Asked asked;
        take(plan, asked, tasks);
        plan.end(true);
        CHECK(plan.is_incomplete());
        RenderState state = plan.checkpoint({3, 4});
        options.resume = &state;
        SamplePlan rest = plan_of(*scene, options);
        CHECK(rest.dropped_before().rays == 3);
        CHECK(rest.dropped_before().samples == 4);
        // Photons of an unfinished round are handed out again.
        asked.photons = rest.state().photons;
        CHECK(rest.samples_before() == asked.samples + asked.photons);
        take(rest, asked);
        if (noise_target == 0.0) CHECK(all_pixels_have(asked, 64));
        CHECK(asked.samples + asked.photons == rest.sample_total());
      }
    }
}

TEST_CASE("sample plan: the state of another render is refused") {
  const auto scene = lit_scene(8);
  RenderState state = plan_of(*scene).checkpoint({});
  RenderOptions options;
  options.crop = PixelRect{0, 0, 8, 8};
  options.resume = &state;
  try {
    plan_of(*scene, options);
    FAIL("no error");
  } catch (const Error& error) { CHECK(error.exit_code() == ExitCode::kCheckpoint); }
}

}  // namespace sheaf::test_sample_plan
