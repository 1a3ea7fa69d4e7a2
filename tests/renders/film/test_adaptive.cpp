// Adaptive sampling: unbiased means, correct variances, the requested noise level, and reproducible bits.
#include "core/io/error.h"
#include "kernels/film/adaptive_film.h"
#include "kernels/film/noise.h"
#include "kernels/render/render.h"
#include "kernels/render/tiles.h"
#include "scene/compile/compile.h"
#include "tests/support/statistics.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <chrono>
#include <cmath>
#include <cstring>

namespace sheaf::test_adaptive {

namespace {

/// A floor below a lamp, and a sphere. With `by_chance`, only BSDF sampling finds the lamp.
Description lamp_scene(int width, int height, bool by_chance) {
  const float size = by_chance ? 0.3f : 0.5f;
  Description d = empty_scene(width, height);
  look_at(d, {0, 1.2f, -3}, {0, 0.3f, 0}, {0, 1, 0}, 50);
  d.sampler.kind = SamplerKind::kSobol;
  d.integrator.max_depth = 3;
  if (by_chance) {
    d.integrator.max_depth = 2;
    d.integrator.strategy = LightStrategy::kBsdfOnly;
  }
  add_rectangle(d, Transform::rotate({1, 0, 0}, -90) * Transform::scale({4, 4, 1}), add_diffuse(d, 0.6f));
  add_sphere(d, {0.3f, 0.5f, 0}, 0.5f, add_diffuse_rgb(d, 0.7f, 0.5f, 0.3f));
  emit(add_rectangle(
           d, Transform::translate({0, 2, 0}) * Transform::rotate({1, 0, 0}, 90) * Transform::scale({size, size, 1}),
           add_diffuse(d, 0)),
       20);
  return d;
}

RenderOptions adaptive_options(double noise, std::uint32_t samples) {
  RenderOptions options;
  options.noise_target = noise;
  options.samples_per_pixel = samples;
  return options;
}

double mean_of(const Image& image, const std::string& channel) {
  const auto c = static_cast<std::size_t>(image.find_channel(channel));
  double sum = 0;
  for (std::size_t i = 0; i < image.pixel_count(); ++i)
    sum += static_cast<double>(image.data[i * image.channels.size() + c]);
  return sum / static_cast<double>(image.pixel_count());
}

bool same_bits(const Image& a, const Image& b) {
  return a.channels == b.channels && a.data.size() == b.data.size() &&
         std::memcmp(a.data.data(), b.data.data(), a.data.size() * sizeof(float)) == 0;
}

}  // namespace

TEST_CASE("adaptive sampling: images are unbiased even if few pixels decide when to stop" *
          doctest::test_suite("slow")) {
  // Sixteen pixels with rare bright samples: a tile that stopped by its own noise estimate would be biased towards
  // dark.
  for (const auto filter : {PixelFilter::Kind::kBox, PixelFilter::Kind::kGaussian}) {
    CAPTURE(static_cast<int>(filter));
    Description d = lamp_scene(4, 4, true);
    d.film.filter.kind = filter;
    const auto scene = compile_scene(d);
    RenderOptions uniform;
    uniform.samples_per_pixel = 1 << 17;
    const double expected = mean_of(render(*scene, uniform).film.to_image(), "R");
    RenderOptions options = adaptive_options(0.25, 2048);
    options.threads = 1;
    MeanVariance means, samples;
    for (std::uint32_t seed = 0; seed < 1000; ++seed) {
      options.seed = 1000 + seed;
      const RenderResult result = render(*scene, options);
      means.add(mean_of(result.film.to_image(), "R"));
      samples.add(result.report.adaptive->mean_samples);
    }
    INFO("mean " << means.mean() << " of " << expected << ", deviation " << std::sqrt(means.variance()) << ", "
                 << samples.mean() << " samples, deviation " << std::sqrt(samples.variance()));
    CHECK(samples.mean() > 40);
    CHECK(samples.mean() < 1500);
    CHECK(samples.variance() > 100);  // sampling was adaptive
    CHECK(means.p_value(expected) > significance_of_each(2));
  }
}

TEST_CASE("adaptive sampling: the image equals that of four replicates if no tile stops early") {
  Description d = lamp_scene(70, 50, false);
  d.film.filter.kind = PixelFilter::Kind::kMitchell;
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
    CAPTURE(static_cast<int>(color));
    const auto scene = compile_scene(d, {false, color});
    RenderOptions options = adaptive_options(1e-9, 64);
    options.aovs = {aov_named("albedo"), aov_named("depth"),     aov_named("variance"),
                    aov_named("half"),   aov_named("object_id"), aov_named("cryptomatte_object")};
    options.light_groups = true;
    options.spectral_bins = color == ColorMode::kSpectral ? 3 : 0;
    const Image found = render(*scene, options).to_image();
    options.noise_target = 0;
    options.replicates = 4;
    const Image expected = render(*scene, options).to_image();
    REQUIRE(found.channels == expected.channels);
    // The variance of a pixel that four tiles contribute to is the sum of theirs.
    double worst = 0, worst_variance = 0;
    for (int y = 0; y < 50; ++y)
      for (int x = 0; x < 70; ++x)
        for (std::size_t c = 0; c < found.channels.size(); ++c) {
          const bool is_variance = found.channels[c].starts_with("variance.");
          const auto is_far = [](int at) { return at % kAdaptiveSide > 2 && at % kAdaptiveSide < kAdaptiveSide - 3; };
          const bool is_inner = is_far(x) && is_far(y);
          if (is_variance && !is_inner) continue;
          const double a = found.at(x, y, static_cast<int>(c)), b = expected.at(x, y, static_cast<int>(c));
          double& most = is_variance ? worst_variance : worst;
          most = std::max(most, std::fabs(a - b) / (std::fabs(b) + (is_variance ? 1e-6 : 1e-3)));
        }
    CHECK(worst < 1e-4);
    CHECK(worst_variance < 0.02);
  }
}

TEST_CASE("adaptive sampling: variances match the spread of means over seeds on both sides of tiles" *
          doctest::test_suite("slow")) {
  constexpr int kSide = 40, kSeeds = 60;
  Description d = lamp_scene(kSide, kSide, false);
  d.film.filter.kind = PixelFilter::Kind::kGaussian;
  d.integrator.max_depth = 2;
  const auto scene = compile_scene(d);
  std::vector<MeanVariance> values(kSide * kSide), told(kSide * kSide);
  RenderOptions options = adaptive_options(0.04, 256);
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
    options.seed = 7000 + seed;
    const Image image = render(*scene, options).film.to_image();
    const int variance = image.find_channel("variance.G");
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const auto i = static_cast<std::size_t>(y * kSide + x);
        values[i].add(image.at(x, y, kGreen));
        told[i].add(image.at(x, y, variance));
      }
  }
  // Pixels at the seams of tiles combine several variances. They are tested apart from the others.
  for (const bool between : {false, true}) {
    CAPTURE(between);
    // Differences are divided by their expected size, so that few bright pixels do not dominate.
    MeanVariance differences;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const auto i = static_cast<std::size_t>(y * kSide + x);
        const double sum = told[i].mean() + values[i].variance();
        const auto is_near = [](int at) { return at > 2 && (at + 2) % kAdaptiveSide < 4; };
        if ((is_near(x) || is_near(y)) == between && sum > 0)
          differences.add((told[i].mean() - values[i].variance()) / sum);
      }
    INFO("mean difference " << differences.mean());
    CHECK(std::fabs(differences.mean()) < 0.03);
  }
}

TEST_CASE("adaptive sampling: tiles stop at the noise target or at the maximum sample count" *
          doctest::test_suite("slow")) {
  constexpr int kColumns = 96, kRows = 64;
  Description d = lamp_scene(kColumns, kRows, false);
  d.integrator.max_depth = 2;
  d.film.filter.kind = PixelFilter::Kind::kGaussian;
  const auto scene = compile_scene(d);
  RenderOptions options;
  options.samples_per_pixel = 1 << 12;
  const Image truth = render(*scene, options).film.to_image();
  const double mean = mean_of(truth, "R");
  for (const double target : {0.01, 0.03}) {
    CAPTURE(target);
    const RenderResult result = render(*scene, adaptive_options(target, 4096));
    const Image image = result.film.to_image();
    CHECK(result.report.adaptive->reached == kColumns * kRows / (kAdaptiveSide * kAdaptiveSide));
    CHECK(result.report.adaptive->min_samples < result.report.adaptive->max_samples);
    std::vector<double> all;
    for (int ty = 0; ty < 2; ++ty)
      for (int tx = 0; tx < 3; ++tx) {
        std::vector<double> squares;
        for (int y = 32 * ty; y < 32 * ty + 32; ++y)
          for (int x = 32 * tx; x < 32 * tx + 32; ++x) {
            const double error = image.at(x, y, 0) - truth.at(x, y, 0);
            squares.push_back(relative_square(truth.at(x, y, 0), error * error, mean));
          }
        CAPTURE(tx);
        CAPTURE(ty);
        all.insert(all.end(), squares.begin(), squares.end());
        CHECK(std::sqrt(mean_but_worst(squares)) < 1.5 * target);
      }
    const double noise = std::sqrt(mean_but_worst(all));
    CAPTURE(noise);
    CHECK(noise < 1.1 * target);
    CHECK(noise > 0.8 * target);
  }
  const RenderResult most = render(*scene, adaptive_options(1e-6, 40));
  CHECK(most.report.adaptive->reached == 0);
  CHECK(most.report.adaptive->mean_samples == 40);
}

TEST_CASE("adaptive sampling: the bits do not depend on threads or wave size or checkpoints") {
  const TemporaryFolder folder;
  const auto file = folder / "render.checkpoint";
  Description d = lamp_scene(70, 50, false);
  d.film.filter.kind = PixelFilter::Kind::kGaussian;
  const auto scene = compile_scene(d);
  RenderOptions options = adaptive_options(0.015, 256);
  options.aovs = {aov_named("normal"), aov_named("half"), aov_named("object_id")};
  options.threads = 1;
  const RenderResult whole = render(*scene, options);
  CHECK(whole.report.adaptive->min_samples < whole.report.adaptive->max_samples);
  options.threads = 7;
  options.wave_size = 333;
  CHECK(same_bits(render(*scene, options).to_image(), whole.to_image()));
  bool interrupted = true;
  for (int part = 0; interrupted; ++part) {
    REQUIRE(part < 100);
    RenderOptions again = options;
    std::optional<RenderState> state;
    if (part > 0) state = read_checkpoint(file, {});
    again.resume = state ? &*state : nullptr;
    std::atomic<int> asked{0};
    std::atomic<bool> stop{false};
    again.stop = &stop;
    again.wants_pause = [&] {
      if (asked.fetch_add(1) < 23) return false;
      stop = true;
      return true;
    };
    again.on_pause = [&](const RenderState& so_far) { write_checkpoint(file, {}, so_far); };
    const RenderResult result = render(*scene, again);
    interrupted = result.interrupted;
    if (part == 0) CHECK(interrupted);
    if (!interrupted) CHECK(same_bits(result.to_image(), whole.to_image()));
  }
}

TEST_CASE("adaptive sampling: a time limit ends the render with an image") {
  Description d = lamp_scene(64, 64, false);
  const auto scene = compile_scene(d);
  RenderOptions options;
  options.time_limit = 0.3;
  options.samples_per_pixel = 1 << 20;
  const RenderResult result = render(*scene, options);
  CHECK_FALSE(result.interrupted);
  CHECK(result.report.render_seconds < 30);
  CHECK(result.report.adaptive->min_samples >= 8);
  CHECK(result.report.adaptive->max_samples < 1 << 20);
  CHECK(mean_of(result.film.to_image(), "A") > 0);
}

TEST_CASE("adaptive sampling: progress is bounded by the maximum until the noise is known, and then estimated by it") {
  const auto scene = compile_scene(lamp_scene(64, 64, false));
  RenderOptions options = adaptive_options(0.05, 1 << 20);
  options.threads = 1;
  std::vector<RenderProgress> calls;
  options.on_progress = [&](const RenderProgress& progress) { calls.push_back(progress); };
  const RenderResult result = render(*scene, options);
  CHECK(result.report.adaptive->reached == result.report.adaptive->tiles);
  REQUIRE_FALSE(calls.empty());
  CHECK(calls.front().is_bound);
  CHECK(calls.front().total == std::uint64_t{64 * 64} << 20);
  CHECK_FALSE(calls.back().is_bound);
  const auto samples = static_cast<double>(calls.back().done);
  for (const RenderProgress& call : calls) {
    const auto total = static_cast<double>(call.total);
    CAPTURE(static_cast<double>(call.done) / samples);
    CHECK(call.done <= call.total);
    CHECK((call.is_bound || (total > samples / 2 && total < samples * 2)));
  }
}

TEST_CASE("adaptive sampling: with a time limit, progress leaves at most the time until then") {
  const auto scene = compile_scene(lamp_scene(64, 64, false));
  RenderOptions options;
  options.time_limit = 0.5;
  options.samples_per_pixel = 1 << 20;
  options.threads = 1;
  double max_left = 0;  // elapsed time included
  RenderProgress last;
  const auto start = std::chrono::steady_clock::now();
  options.on_progress = [&](const RenderProgress& progress) {
    const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    max_left = std::max(max_left, elapsed + progress.seconds_left(elapsed));
    last = progress;
  };
  render(*scene, options);
  CHECK(max_left < options.time_limit + 0.5);  // the setup of the render takes a moment
  CHECK(last.fraction() > 0.9);
  CHECK_FALSE(last.is_bound);
  // A limit that ends before every pixel has samples
  options.time_limit = 1e-6;
  std::vector<RenderProgress> calls;
  options.on_progress = [&](const RenderProgress& progress) { calls.push_back(progress); };
  render(*scene, options);
  REQUIRE(calls.size() > 1);
  CHECK(calls.front().total == 64 * 64 * 8);
  CHECK(calls.back().done == calls.back().total);
}

TEST_CASE("adaptive sampling: unsupported combinations are rejected") {
  Description d = lamp_scene(8, 8, false);
  const auto fails = [&](const RenderOptions& options) {
    try {
      render(*compile_scene(d), options);
      return false;
    } catch (const Error& error) { return error.exit_code() == ExitCode::kUsage; }
  };
  CHECK(fails(adaptive_options(0.1, 3)));
  CHECK_FALSE(fails(adaptive_options(0.1, 4)));
  d.sampler.kind = SamplerKind::kStratified;
  CHECK(fails(adaptive_options(0.1, 64)));
  d.sampler.kind = SamplerKind::kIndependent;
  CHECK_FALSE(fails(adaptive_options(0.1, 64)));
  d.integrator.kind = IntegratorKind::kLightTracer;
  CHECK(fails(adaptive_options(0.1, 64)));
}

}  // namespace sheaf::test_adaptive
