// Finished renders that continue with more samples have the same bits as renders of all samples at once.
#include "core/io/error.h"
#include "kernels/render/continuation.h"
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/contains.h"
#include "tests/support/render_testing.h"
#include "tests/support/temporary_folder.h"

#include <cstring>

namespace sheaf::test_continuation {

using test::contains;

namespace {

/// A lit box with a glass sphere, and a filter that is wider than a pixel.
Description box(SamplerKind sampler) {
  Description d = empty_scene(37, 21);
  look_at(d, {0, 0.3f, -3}, {0, 0, 0}, {0, 1, 0}, 50);
  d.sampler.kind = sampler;
  d.film.filter.kind = PixelFilter::Kind::kGaussian;
  add_rectangle(d, Transform::translate({0, -1, 0}) * Transform::rotate({1, 0, 0}, -90) * Transform::scale({3, 3, 1}),
                add_diffuse(d, 0.7f));
  add_sphere(d, {0.2f, -0.6f, 0}, 0.4f, add_glass(d));
  emit(add_rectangle(d, Transform::translate({0, 1.5f, 0}) * Transform::rotate({1, 0, 0}, 90), add_diffuse(d, 0)), 4);
  return d;
}

RenderOptions options_of(std::uint32_t samples, int replicates = 0) {
  RenderOptions options;
  options.samples_per_pixel = samples;
  options.replicates = replicates;
  options.threads = 2;
  return options;
}

/// The state at the end of a render, by way of a file.
RenderState finished(const Scene& scene, RenderOptions options) {
  const TemporaryFolder folder;
  options.on_pause = [&](const RenderState& state) { write_checkpoint(folder / "state", {}, state); };
  CHECK_FALSE(render(scene, options).interrupted);
  return read_checkpoint(folder / "state", {});
}

bool same_images(const Image& a, const Image& b) {
  return a.channels == b.channels && a.data.size() == b.data.size() &&
         std::memcmp(a.data.data(), b.data.data(), a.data.size() * sizeof(float)) == 0;
}

/// RenderRequest::replicates of the settings.
int replicates_of(const RenderSettings& settings) {
  return settings.requests_replicates ? static_cast<int>(settings.replicates) : 0;
}

/// Continues from `before` to `after` samples, and compares with `after` samples at once in the same sets. Returns the
/// number of replicates.
int check_continued(const Scene& scene, std::uint32_t before, const RenderOptions& after) {
  RenderOptions first = after;
  first.samples_per_pixel = before;
  RenderState state = finished(scene, first);
  const Continuation continuation = continue_from(resolve_settings(scene, after), state);
  CHECK_MESSAGE(continuation.problem.empty(), continuation.problem);
  RenderOptions options = after;
  options.replicates = replicates_of(continuation.settings);
  const Image whole = render(scene, options).to_image();
  options.resume = &state;
  options.threads = 1;
  CHECK(same_images(render(scene, options).to_image(), whole));
  return options.replicates;
}

}  // namespace

TEST_CASE("a continued render has the same bytes as one at once, with every sampler") {
  for (const SamplerKind sampler : {SamplerKind::kSobol, SamplerKind::kZSobol, SamplerKind::kIndependent,
                                    SamplerKind::kStratified, SamplerKind::kMultijitter}) {
    CAPTURE(static_cast<int>(sampler));
    const auto scene = compile_scene(box(sampler));
    // 8 sets of 8 samples become 32 sets. The other samplers have sets of 32 samples by default.
    const int sets = check_continued(*scene, 64, options_of(256));
    CHECK(sets == (sampler == SamplerKind::kIndependent ? 32 : 0));
  }
}

TEST_CASE("a continued render has the default sample sets where they have the same size") {
  const auto scene = compile_scene(box(SamplerKind::kSobol));
  CHECK(check_continued(*scene, 64, options_of(128)) == 0);
  CHECK(check_continued(*scene, 128, options_of(512)) == 0);
  // Default sets of 1024 samples would be larger.
  CHECK(check_continued(*scene, 128, options_of(1024)) == 32);
  RenderOptions layers = options_of(128);
  layers.aovs = {aov_named("albedo"), aov_named("cryptomatte_object"), aov_named("variance")};
  check_continued(*scene, 64, layers);
  // A single set continues at the end of a pass.
  CHECK(check_continued(*scene, 256, options_of(300, 1)) == 1);
}

TEST_CASE("photon mapping and light tracing continue with the same bytes") {
  for (const bool progressive : {false, true})
    for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
      CAPTURE(progressive);
      Description d = box(SamplerKind::kSobol);
      d.integrator.kind = IntegratorKind::kPhotonMapper;
      d.integrator.photons.progressive = progressive;
      d.integrator.photons.global.count = 500;
      check_continued(*compile_scene(d, {false, color}), 32, options_of(64, 0));
    }
  // The number of photons is not a multiple of those of a task.
  Description light = box(SamplerKind::kSobol);
  light.integrator.kind = IntegratorKind::kLightTracer;
  check_continued(*compile_scene(light), 64, options_of(128));
}

TEST_CASE("continuations that would change bits are refused with the reason") {
  const auto problem = [](const Description& d, std::uint32_t before, const RenderOptions& after,
                          ColorMode color = ColorMode::kRgb) {
    const auto scene = compile_scene(d, {false, color});
    RenderOptions first = after;
    first.samples_per_pixel = before;
    RenderState state = finished(*scene, first);
    const Continuation continuation = continue_from(resolve_settings(*scene, after), state);
    // The renderer refuses such a state, too, unless it differs in precomputed data only.
    if (!contains(continuation.problem, "photons") && !contains(continuation.problem, "guiding")) {
      RenderOptions options = after;
      options.resume = &state;
      CHECK_THROWS_AS(render(*scene, options), Error);
    }
    return continuation.problem;
  };
  const Description sobol = box(SamplerKind::kSobol);
  CHECK(contains(problem(sobol, 64, options_of(100)), "choose a multiple of the set size"));
  CHECK(contains(problem(sobol, 64, options_of(256, 2)), "sets of 32 samples, but the new sets have 128 samples"));
  CHECK(contains(problem(sobol, 16, options_of(64)), "into sets of 32 samples (--replicates 1 keeps one set)"));
  CHECK(contains(problem(sobol, 100, options_of(300, 1)), "a multiple of 256"));
  CHECK(contains(problem(sobol, 64, options_of(32)), "a render of more samples"));
  CHECK(contains(problem(box(SamplerKind::kStratified), 16, options_of(64)), "over one grid"));
  RenderOptions half = options_of(128);
  half.aovs = {aov_named("half")};
  CHECK(contains(problem(sobol, 64, half), "layer half"));
  RenderOptions adaptive = options_of(128);
  adaptive.noise_target = 1e-4;
  CHECK(contains(problem(sobol, 64, adaptive), "adaptive sampling"));
  RenderOptions guided = options_of(128);
  guided.guiding = GuidingMode::kOn;
  CHECK(contains(problem(sobol, 64, guided), "path guiding"));
  Description photons = sobol;
  photons.integrator.kind = IntegratorKind::kPhotonMapper;
  photons.integrator.photons.global.count = 500;
  CHECK(contains(problem(photons, 16, options_of(32, 2), ColorMode::kSpectral), "sets of wavelengths"));
}

TEST_CASE("a render with a time limit continues with another one, and without one to the same number of samples") {
  const auto scene = compile_scene(box(SamplerKind::kSobol));
  RenderOptions limited = options_of(1 << 16);
  limited.time_limit = 1e-3;
  const RenderState first = finished(*scene, limited);
  CHECK(first.adaptive->summary().mean_samples < 64);
  limited.time_limit = 2;
  CHECK(continue_from(resolve_settings(*scene, limited), first).problem.empty());
  CHECK(contains(continue_from(resolve_settings(*scene, options_of(64)), first).problem,
                 "--time-limit in the checkpoint, not now: give it again, or --spp 65536"));

  // Without the limit
  RenderOptions whole = options_of(64);
  whole.time_limit = 1e6;
  const Image expected = render(*scene, whole).to_image();
  whole.time_limit = 1e-3;
  RenderState state = finished(*scene, whole);
  const Continuation continuation = continue_from(resolve_settings(*scene, options_of(64)), state);
  CHECK(continuation.problem.empty());
  RenderControl control;
  control.resume = &state;
  CHECK(same_images(render(*scene, continuation.settings, control).to_image(), expected));

  // Adding one
  state = finished(*scene, options_of(64));
  CHECK(contains(continue_from(resolve_settings(*scene, whole), state).problem,
                 "--time-limit now, not in the checkpoint"));
}

TEST_CASE("passes of a shorter render begin those of a longer one") {
  const SampleDivision four{128, 32, 0, 256, {0, 128}}, sixteen{512, 32, 0, 256, {0, 512}};
  CHECK(begins_with(sixteen, four, 128));
  CHECK(begins_with(four, four, 128));
  CHECK_FALSE(begins_with(four, sixteen, 512));
  const SampleDivision eight{512, 64, 0, 256, {0, 512}};
  CHECK_FALSE(begins_with(eight, four, 128));
  CHECK(begins_with(eight, four, 0));
  // A single set is not the first of several: renders without sets have no variances.
  const SampleDivision one{256, 256, 0, 256, {0, 256}}, longer{512, 512, 0, 256, {0, 512}};
  const SampleDivision two{512, 256, 0, 256, {0, 512}};
  CHECK(begins_with(longer, one, 256));
  CHECK_FALSE(begins_with(two, one, 256));
  // Passes, not only sets
  const SampleDivision single{300, 300, 0, 256, {0, 300}}, more{600, 600, 0, 256, {0, 600}};
  CHECK(begins_with(more, single, 256));
  CHECK_FALSE(begins_with(more, single, 300));
  const SampleDivision halves{512, 32, 256, 256, {0, 512}};
  CHECK_FALSE(begins_with(halves, four, 128));
}

}  // namespace sheaf::test_continuation
