// The number of light candidates that a render chooses: the estimates of the trial, the choice, and the renders that
// follow from it.
#include "core/sampling/rng.h"
#include "kernels/guiding/guide_field.h"
#include "kernels/passes/passes.h"
#include "kernels/passes/worker.h"
#include "kernels/training/candidate_choice.h"
#include "kernels/training/train_guiding.h"
#include "tests/support/media_testing.h"
#include "tests/support/near.h"
#include "tests/support/render_testing.h"

#include <cmath>
#include <cstring>

namespace sheaf::test_candidate_choice {

namespace {

constexpr int kSide = 24;
constexpr std::uint32_t kSamples = 1024;

/// A room with a glossy floor under a large lamp and many small ones, which a screen hides in part.
Description lamps(int side) {
  Description d = empty_scene(side, side);
  d.sampler.kind = SamplerKind::kIndependent;
  d.sampler.sample_count = 16;
  d.integrator.max_depth = 4;
  d.integrator.hide_emitters = true;  // whose squared radiance would hide that of surfaces
  d.integrator.light_selector = LightSelector::kUniform;
  look_at(d, {0, 0, 0.95f}, {0, -0.3f, -1}, {0, 1, 0}, 80);
  add_shape(d, CubeShape{}, Transform::scale({1, 1, 1}), add_two_sided(d, add_diffuse(d, 0.5f)));
  ConductorDescription metal;
  metal.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.3f, 0.3f};
  add_rectangle(d, Transform::translate({0, -0.98f, 0}) * Transform::rotate({1, 0, 0}, -90), add_material(d, metal));
  add_rectangle(
      d, Transform::translate({0, 0.2f, 0}) * Transform::rotate({1, 0, 0}, 90) * Transform::scale({0.4f, 0.4f, 1}),
      add_two_sided(d, add_diffuse(d, 0.5f)));
  const auto lamp = [&](Vec3f at, float size, float radiance) {
    emit(add_rectangle(d,
                       Transform::translate(at) * Transform::rotate({1, 0, 0}, 90) * Transform::scale({size, size, 1}),
                       add_diffuse(d, 0)),
         radiance);
  };
  lamp({0, 0.99f, 0}, 0.5f, 1);
  for (int i = 0; i < 8; ++i) {
    const float angle = 0.785f * static_cast<float>(i);
    lamp({0.8f * std::cos(angle), 0.9f, 0.8f * std::sin(angle)}, 0.03f, i % 4 == 0 ? 60.0f : 4.0f);
  }
  return d;
}

/// A floor under point lights, where several candidates pay and guiding does not.
Description point_lights() {
  Description d = empty_scene(160, 160);
  d.sampler.sample_count = 16;
  d.integrator.max_depth = 4;
  d.integrator.light_selector = LightSelector::kUniform;
  look_at(d, {0, 1, 1.5f}, {0, 0, 0}, {0, 1, 0}, 40);
  add_rectangle(d, Transform::rotate({1, 0, 0}, -90) * Transform::scale({4, 4, 1}), add_diffuse(d, 0.5f));
  for (int i = 0; i < 8; ++i) {
    const float angle = 0.785f * static_cast<float>(i);
    add_point_light(d, {0.7f * std::cos(angle), 0.7f, 0.7f * std::sin(angle)}, i % 4 == 0 ? 3.0f : 0.2f);
  }
  return d;
}

/// The same room as lamps() with a sky, and with a medium in which shadow rays are attenuated.
Description sky_and_fog() {
  Description d = lamps(kSide);
  d.integrator.light_selector = LightSelector::kBvh;
  add_constant_light(d, 0.7f);
  d.camera.medium = add_medium(d, fog(0.5f, 0.8f));
  return d;
}

/// A floor under unequal point lights in a medium that only absorbs, and a half-open pane above the floor: shadow rays
/// are attenuated, and lights at a point have no MIS weights.
Description dim_lights() {
  Description d = empty_scene(kSide, kSide);
  d.sampler.kind = SamplerKind::kIndependent;
  d.integrator.max_depth = 3;
  d.integrator.light_selector = LightSelector::kUniform;
  look_at(d, {0, 0.3f, 1.2f}, {0, 0, 0}, {0, 1, 0}, 60);
  add_rectangle(d, Transform::rotate({1, 0, 0}, -90) * Transform::scale({4, 4, 1}), add_diffuse(d, 0.5f));
  MaskDescription half;
  half.nested = add_two_sided(d, add_diffuse(d, 0.5f));
  half.opacity = 0.4f;
  add_rectangle(d,
                Transform::translate({0, 0.5f, 0}) * Transform::rotate({1, 0, 0}, 90) * Transform::scale({0.6f, 4, 1}),
                add_material(d, half));
  for (int i = 0; i < 4; ++i)
    add_point_light(d, {0.5f * static_cast<float>(i) - 0.7f, 0.8f, 0.2f * static_cast<float>(i)}, i == 1 ? 8.0f : 1.0f);
  d.camera.medium = add_medium(d, fog(0.8f, 0));
  return d;
}

/// Results of the samples of all pixels, in order.
struct Samples {
  std::vector<float> radiance;
  std::vector<Spectrum4> squared_radiance;
  TrainingSamples::Vertices vertices;
  std::uint64_t shadow_rays = 0;
};

/// Takes samples with `candidates` candidates; 0: with a trial.
Samples sample(const Scene& scene, int candidates, std::uint32_t seed) {
  const SampledFrame frame{kSide};
  const std::vector<PixelSamples> pixels = samples_of({0, 0, kSide, kSide}, frame, 0, kSamples);
  CameraTask task;
  task.begin(pixels, frame, kBeautyChannels);
  TrainingSamples training;
  training.begin(task.total());
  StageContext context(scene, task);
  context.sampler = make_sampler(SamplerKind::kIndependent, seed, kSamples);
  const GuideField field;
  context.sample_from(field.view());
  context.record_in(training);
  context.candidates = candidates;
  if (candidates == 0) context.start_candidate_comparison();
  Wave wave(512, candidates == 0 ? WaveNeeds::with_candidate_moments(context) : WaveNeeds::of(context));
  run_pass<Wide>(context, wave);
  return {training.radiance(), training.squared_radiance(), training.vertices(), wave.stats.rays.shadow};
}

/// A pass whose pixels have variance 1 with 8 candidates, and `more[k]` in addition with kCandidateCounts[k].
ComparedPass pass_with(const std::array<float, 4>& more) {
  ComparedPass pass;
  pass.rays = 100'000;
  pass.light_vertices = 40'000;
  pass.shadow_rays = {30'000, 30'000, 30'000, 30'000};
  for (std::uint32_t i = 0; i < 4; ++i) {
    ComparedTask& task = pass.tasks.emplace_back();
    for (std::uint32_t k = 0; k < 4000; ++k) {
      const float x = 4 + 3.4641f * (random4<Scalar>(3, k, i, 0).x - 0.5f), square = x * x;
      task.radiance[k % 2].push_back(x);
      task.squared_radiance[k % 2].push_back({square + more[0], square + more[1], square + more[2], square + more[3]});
    }
  }
  return pass;
}

RenderResult rendered(const Scene& scene, int threads = 2, GuidingMode mode = GuidingMode::kAuto) {
  RenderOptions options;
  options.guiding = mode;
  options.threads = threads;
  return render(scene, options);
}

bool same_bits(const Film& a, const Film& b) {
  const Image x = a.to_image(), y = b.to_image();
  return x.data.size() == y.data.size() &&
         std::memcmp(x.data.data(), y.data.data(), x.data.size() * sizeof(float)) == 0;
}

}  // namespace

TEST_CASE("candidate choice: the trial estimates the squared radiance with each number of candidates") {
  constexpr int kTests = 3 * 4 * 2;
  enum class Kind { kLamps, kSkyAndFog, kDimLights };
  for (const Kind kind : {Kind::kLamps, Kind::kSkyAndFog, Kind::kDimLights}) {
    CAPTURE(static_cast<int>(kind));
    const auto scene = compile_scene(kind == Kind::kLamps       ? lamps(kSide)
                                     : kind == Kind::kSkyAndFog ? sky_and_fog()
                                                                : dim_lights());
    const Samples compared = sample(*scene, 0, 1);
    for (int k = 0; k < 4; ++k) {
      const int candidates = kCandidateCounts[k];
      CAPTURE(candidates);
      const Samples plain = sample(*scene, candidates, 2);
      // The samples of a pixel are independent, so the differences of the pixels' means have the mean 0.
      MeanVariance squares;
      for (std::size_t pixel = 0; pixel < kSide * kSide; ++pixel) {
        double difference = 0;
        for (std::size_t i = pixel * kSamples; i < (pixel + 1) * kSamples; ++i)
          difference += double{(&compared.squared_radiance[i].c0)[k]} - std::pow(double{plain.radiance[i]}, 2);
        squares.add(difference / kSamples);
      }
      // With fog, the MIS weights of fewer candidates are those without fog.
      if (kind != Kind::kSkyAndFog || candidates == kMaxComparedCandidates)
        CHECK(squares.p_value(0) > significance_of_each(kTests));
      // Rays from segments do not depend on the number of candidates.
      const std::uint64_t from_segments = compared.shadow_rays - compared.vertices.shadow_rays.back();
      const auto rays = static_cast<double>(compared.vertices.shadow_rays[static_cast<std::size_t>(k)] + from_segments);
      CHECK(rays == near(static_cast<double>(plain.shadow_rays), 0.01));
    }
    // With as many candidates as the trial has, it estimates nothing.
    int different = 0;
    for (std::size_t i = 0; i < compared.radiance.size(); ++i) {
      const float square = compared.radiance[i] * compared.radiance[i];
      different += std::abs(compared.squared_radiance[i].c3 - square) > 1e-4f * square ? 1 : 0;
    }
    CHECK(different == 0);
  }
}

TEST_CASE("candidate choice: the number with the lowest error x cost, if it gains enough") {
  const auto choice = [](const std::array<float, 4>& more, double cost) {
    return choose_candidates(pass_with(more), cost);
  };
  CHECK(choice({0, 0, 0, 0}, 0).count == 1);
  CHECK(choice({1, 0.4f, 0.1f, 0}, 0).count == 8);
  // A candidate costs 0.4 of `cost` rays per ray.
  const CandidateChoice best = choice({1, 0.4f, 0.1f, 0}, 0.1);
  CHECK(best.count == 4);
  CHECK(best.gains[2] == near(2 / 1.1 / 1.12, 0.02));
  CHECK(choice({1, 0.4f, 0.1f, 0}, 0.4).count == 2);
  CHECK(choice({1, 0.4f, 0.1f, 0}, 2).count == 1);
  CHECK(choice({0.04f, 0, 0, 0}, 0).count == 1);
  CHECK(choice({-0.5f, -0.3f, -0.1f, 0}, 0).count == 1);
  // More shadow rays cost time too.
  ComparedPass rays = pass_with({1, 0.4f, 0.1f, 0});
  rays.shadow_rays = {30'000, 40'000, 100'000, 100'000};
  rays.rays += 70'000;
  CHECK(choose_candidates(rays, 0).count == 2);
}

TEST_CASE("candidate choice: a few outliers and black passes do not decide") {
  ComparedPass pass = pass_with({1, 0.4f, 0.1f, 0});
  for (const std::size_t i : {0, 100, 200}) {
    pass.tasks[1].radiance[0][i] = 1e4f;
    pass.tasks[1].squared_radiance[0][i] = Spectrum4(1e8f);
    pass.tasks[1].squared_radiance[0][i].c0 = 1e6f;
  }
  CHECK(choose_candidates(pass, 0.1).count == 4);
  for (ComparedTask& task : pass.tasks)
    for (std::vector<float>& radiance : task.radiance) std::fill(radiance.begin(), radiance.end(), 0.0f);
  CHECK(choose_candidates(pass, 0.1).count == 1);
  CHECK(choose_candidates({}, 0.1).count == 1);
}

TEST_CASE("candidate choice: a render has the bits of one with that number, with any number of threads") {
  const auto scene = compile_scene(point_lights());
  const RenderResult automatic = rendered(*scene);
  const RenderReport::Candidates& chosen = automatic.report.candidates;
  REQUIRE(chosen.gains.size() == std::size(kCandidateCounts));
  CAPTURE(chosen.gains[3]);
  CHECK(chosen.count > 1);
  REQUIRE_FALSE(automatic.report.guiding.is_used);
  CHECK(same_bits(automatic.film, rendered(*scene, 1).film));
  Description fixed = point_lights();
  fixed.integrator.candidates = chosen.count;
  CHECK(same_bits(automatic.film, rendered(*compile_scene(fixed), 2, GuidingMode::kOff).film));
  // A guide learns from passes with that number, too.
  const RenderResult guided = rendered(*scene, 2, GuidingMode::kOn);
  CHECK_FALSE(guided.report.candidates.gains.empty());
  CHECK(same_bits(guided.film, rendered(*scene, 1, GuidingMode::kOn).film));
}

TEST_CASE("candidate choice: a trial with a rejected guide does not count, and one with a used guide does") {
  constexpr int kWidth = 64;
  Description d = point_lights();
  d.film.width = d.film.height = kWidth;
  const auto scene = compile_scene(d);
  const auto trained = [&](GuidingMode mode, const std::vector<TrainingPass>& passes) {
    CameraTask task;
    StageContext context(*scene, task);
    context.sampler = make_sampler(SamplerKind::kSobol, 3, 16);
    const GuideField field;
    context.sample_from(field.view());
    Workers workers([&] { return Worker(512, WaveNeeds::with_candidate_moments(context)); });
    GuideTraining training{[] { return false; }, [](std::uint64_t) {}};
    train_guide(context, workers, kWidth, kWidth, passes, mode, true, training);
    CHECK(training.report.is_used == (mode == GuidingMode::kOn));
    return training.candidates.gains;
  };
  const auto pass = [](std::uint32_t first_pair) { return TrainingPass{first_pair, 1, kComparedSamples, 2, 2}; };
  const auto rejected = trained(GuidingMode::kAuto, {pass(0), pass(1)});
  CHECK(rejected[3] > 1.05);
  // Only the first pass counts, which no guide has changed.
  CHECK(rejected == trained(GuidingMode::kAuto, {pass(0), pass(2)}));
  CHECK(rejected == trained(GuidingMode::kAuto, {pass(0), pass(1), pass(2)}));
  CHECK(rejected != trained(GuidingMode::kAuto, {pass(2), pass(1)}));
  // The last pass of the trial counts.
  const auto used = trained(GuidingMode::kOn, {pass(0), pass(1)});
  CHECK(used != rejected);
  CHECK(used != trained(GuidingMode::kOn, {pass(0), pass(2)}));
}

TEST_CASE("candidate choice: parts and continued renders have the same number") {
  const auto scene = compile_scene(lamps(160));
  RenderOptions options;
  options.guiding = GuidingMode::kAuto;
  const int count = render(*scene, options).report.candidates.count;
  options.samples = SampleRange{8, 8};
  CHECK(render(*scene, options).report.candidates.count == count);
  options.samples.reset();
  options.samples_per_pixel = 24;
  CHECK(render(*scene, options).report.candidates.count == count);
  options.crop = PixelRect{0, 0, 16, 16};
  CHECK(render(*scene, options).report.candidates.count == count);
}

TEST_CASE("candidate choice: a scene's number stays, and renders without a trial have one candidate") {
  Description fixed = lamps(160), brief = lamps(160), small = lamps(127);
  fixed.integrator.candidates = 2;
  brief.sampler.sample_count = 15;
  for (const Description* d : {&fixed, &brief, &small}) {
    const RenderResult result = rendered(*compile_scene(*d));
    const int count = d->integrator.candidates.value_or(1);
    CHECK(result.report.candidates.gains.empty());
    CHECK(result.report.candidates.count == count);
    Description same = *d;
    same.integrator.candidates = count;
    CHECK(same_bits(result.film, rendered(*compile_scene(same)).film));
  }
  const RenderResult off = rendered(*compile_scene(lamps(160)), 2, GuidingMode::kOff);
  CHECK(off.report.candidates.gains.empty());
  CHECK(off.report.candidates.count == 1);
}

}  // namespace sheaf::test_candidate_choice
