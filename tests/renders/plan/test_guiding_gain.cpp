// The decision of GuidingMode::kAuto: the estimate of the gain, and the renders that follow from it.
#include "core/sampling/rng.h"
#include "kernels/training/guiding_gain.h"
#include "tests/support/capture.h"
#include "tests/support/near.h"
#include "tests/support/render_testing.h"

#include <cmath>
#include <cstring>

namespace sheaf::test_guiding_gain {

namespace {

/// A pass of four tasks whose brightness grows from task to task, with noise of relative size `noise`.
ComparedPass noisy_pass(std::uint32_t seed, float noise, std::uint64_t rays) {
  ComparedPass pass;
  pass.rays = rays;
  for (std::uint32_t i = 0; i < 4; ++i) {
    ComparedTask& task = pass.tasks.emplace_back();
    const auto brightness = static_cast<float>(1u << 2 * i);
    for (std::uint32_t k = 0; k < 4000 * kComparedSamples; ++k)
      task.radiance[k % 2].push_back(brightness * (1 + noise * (random4<Scalar>(seed, k, i, 0).x - 0.5f)));
  }
  return pass;
}

double ratio(const ComparedPass& unguided, const ComparedPass& guided) { return guiding_gain(unguided, guided).ratio; }

/// A room with a lamp under its ceiling, which light sampling finds, or with one that shines at the ceiling from behind
/// a screen, whose light comes by way of a small part of the ceiling.
Description room(bool is_hidden) {
  Description d = empty_scene(200, 200);
  d.sampler.sample_count = 16;
  d.integrator.candidates = 1;
  d.integrator.max_depth = 6;
  look_at(d, {0, 0, 0.95f}, {0, -0.3f, -1}, {0, 1, 0}, 80);
  const MaterialId wall = add_two_sided(d, add_diffuse(d, 0.6f));
  add_shape(d, CubeShape{}, Transform::scale({1, 1, 1}), wall);
  const float height = is_hidden ? 0.8f : 0.99f, angle = is_hidden ? -90.0f : 90.0f, size = is_hidden ? 0.1f : 0.5f;
  if (is_hidden)
    add_rectangle(
        d, Transform::translate({0, 0.79f, 0}) * Transform::rotate({1, 0, 0}, 90) * Transform::scale({0.15f, 0.15f, 1}),
        wall);
  emit(add_rectangle(d,
                     Transform::translate({0, height, 0}) * Transform::rotate({1, 0, 0}, angle) *
                         Transform::scale({size, size, 1}),
                     add_diffuse(d, 0)),
       20);
  return d;
}

RenderResult rendered(const Scene& scene, GuidingMode mode, int threads = 2) {
  RenderOptions options;
  options.guiding = mode;
  options.threads = threads;
  return render(scene, options);
}

bool same_bits(const RenderResult& a, const RenderResult& b) {
  const Image x = a.film.to_image(), y = b.film.to_image();
  return x.data.size() == y.data.size() &&
         std::memcmp(x.data.data(), y.data.data(), x.data.size() * sizeof(float)) == 0;
}

}  // namespace

TEST_CASE("guiding gain: it is the ratio of error times rays, and a guided ray costs 20 % more") {
  const ComparedPass noisy = noisy_pass(1, 1, 1000);
  CHECK(ratio(noisy, noisy) == near(1 / 1.2));
  // Half the noise is a quarter of the squared error.
  CHECK(ratio(noisy, noisy_pass(2, 0.5f, 1000)) == near(4 / 1.2, 0.1));
  CHECK(ratio(noisy, noisy_pass(2, 0.5f, 2000)) == near(2 / 1.2, 0.1));
  CHECK(ratio(noisy_pass(2, 0.5f, 2000), noisy) == near(0.5 / 1.2, 0.1));
  // A larger pass of as many rays per sample.
  ComparedPass twice = noisy_pass(2, 0.5f, 2000);
  for (ComparedTask& task : twice.tasks)
    for (std::vector<float>& radiance : task.radiance) {
      const std::vector<float> once = radiance;
      radiance.insert(radiance.end(), once.begin(), once.end());
    }
  CHECK(ratio(noisy, twice) == near(4 / 1.2, 0.1));
}

TEST_CASE("guiding gain: stratification within sets counts") {
  // Noise of alternating sign, whose sum over a set is 0, is no error, but unstratified noise of the same size is.
  ComparedPass stratified = noisy_pass(1, 0.1f, 1000);
  for (ComparedTask& task : stratified.tasks)
    for (std::vector<float>& radiance : task.radiance)
      for (std::size_t i = 0; i < radiance.size(); ++i) radiance[i] *= i % 2 == 0 ? 1.5f : 0.5f;
  CHECK(ratio(noisy_pass(2, 1, 1000), stratified) > 50);
}

TEST_CASE("guiding gain: dark parts of the image count as much as bright ones") {
  // A pass that is noisy only where the image is dark, where its squared error would be hidden by that of bright parts.
  const ComparedPass noisy = noisy_pass(1, 1, 1000), calm = noisy_pass(1, 0.1f, 1000);
  ComparedPass dark = calm, bright = calm;
  for (const std::size_t i : {0, 1}) dark.tasks[i] = noisy.tasks[i];
  for (const std::size_t i : {2, 3}) bright.tasks[i] = noisy.tasks[i];
  CHECK(ratio(noisy, calm) > 50);
  CHECK(ratio(noisy, bright) < 1.6);
  CHECK(ratio(dark, calm) > 2.5);
  CHECK(ratio(bright, calm) > ratio(dark, calm));
}

TEST_CASE("guiding gain: a few outliers and black passes do not decide") {
  const ComparedPass noisy = noisy_pass(1, 1, 1000);
  ComparedPass outliers = noisy;
  outliers.tasks[0].radiance[0][0] = outliers.tasks[3].radiance[1][10] = 1e6f;
  // They are left out of errors and brightness.
  CHECK(ratio(outliers, noisy) == near(1 / 1.2, 0.01));
  CHECK(ratio(noisy, outliers) == near(1 / 1.2, 0.01));
  ComparedPass black = noisy;
  for (ComparedTask& task : black.tasks)
    for (std::vector<float>& radiance : task.radiance) std::fill(radiance.begin(), radiance.end(), 0.0f);
  CHECK(ratio(black, black) == 1);
  CHECK(ratio({}, {}) == 1);
}

TEST_CASE("guiding gain: a gain in a few pixels is not believed, but a loss is") {
  const ComparedPass noisy = noisy_pass(1, 1, 1000);
  ComparedPass spotted = noisy;
  // 0.3 % of the pixels have most of the error
  for (ComparedTask& task : spotted.tasks)
    for (std::size_t i = 0; i < 6; ++i) task.radiance[0][kComparedSamples * 300 * i] *= 30;
  CHECK(ratio(spotted, noisy) == near(1 / 1.2, 0.05));
  CHECK(ratio(noisy, spotted) < 0.5);
}

TEST_CASE("guiding gain: the standard error tells how far estimates scatter") {
  MeanVariance logarithms, errors;
  for (std::uint32_t seed = 0; seed < 60; ++seed) {
    const GuidingGain gain = guiding_gain(noisy_pass(2 * seed, 1, 1000), noisy_pass(2 * seed + 1, 0.8f, 1000));
    logarithms.add(std::log(gain.ratio));
    errors.add(gain.standard_error);
  }
  CHECK(std::exp(logarithms.mean()) == near(1 / 0.64 / 1.2, 0.01));
  CHECK(errors.mean() == near(std::sqrt(logarithms.variance()), 0.3));
  CHECK(GuidingGain{1.3, 0.12}.is_significant());
  CHECK_FALSE(GuidingGain{1.3, 0.14}.is_significant());
  CHECK_FALSE(GuidingGain{1.2, 0.001}.is_significant());
  CHECK(GuidingGain{1.1, 1}.is_promising());
  CHECK_FALSE(GuidingGain{0.9, 0.001}.is_promising());
}

TEST_CASE("guiding gain: automatic guiding renders as the better of both modes, bit by bit") {
  for (const bool is_hidden : {false, true}) {
    CAPTURE(is_hidden);
    const auto scene = compile_scene(room(is_hidden));
    const RenderResult automatic = rendered(*scene, GuidingMode::kAuto);
    REQUIRE(automatic.report.guiding.gain.has_value());
    CAPTURE(*automatic.report.guiding.gain);
    CHECK(automatic.report.guiding.is_used == is_hidden);
    CHECK(automatic.report.guiding.passes == (is_hidden ? 5 : 2));
    const RenderResult on = rendered(*scene, GuidingMode::kOn), off = rendered(*scene, GuidingMode::kOff);
    CHECK_FALSE(on.report.guiding.gain.has_value());
    CHECK_FALSE(same_bits(on, off));
    CHECK(same_bits(automatic, is_hidden ? on : off));
    CHECK(same_bits(automatic, rendered(*scene, GuidingMode::kAuto, 1)));
  }
}

TEST_CASE("guiding gain: automatic guiding trains nothing where it cannot help") {
  Description direct = room(true), normals = room(true), brief = room(true), small = room(true);
  small.film.width = small.film.height = 127;
  direct.integrator.max_depth = 2;
  normals.integrator.kind = IntegratorKind::kNormals;
  brief.sampler.sample_count = 4;
  for (const Description* d : {&direct, &normals, &brief, &small}) {
    const auto scene = compile_scene(*d);
    const RenderResult automatic = rendered(*scene, GuidingMode::kAuto);
    CHECK(automatic.report.guiding.passes == 0);
    CHECK(same_bits(automatic, rendered(*scene, GuidingMode::kOff)));
  }
}

}  // namespace sheaf::test_guiding_gain
