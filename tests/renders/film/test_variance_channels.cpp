// The variance channels against the spread of means over renders with different seeds.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/statistics.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

namespace sheaf::test_variance_channels {

namespace {

constexpr int kSide = 16, kSeeds = 40;

/// A sphere on a floor below a colored lamp, in a dim environment.
Description noisy_scene() {
  Description d = empty_scene(kSide, kSide);
  d.sampler.kind = SamplerKind::kIndependent;
  d.integrator.max_depth = 3;
  look_at(d, {0, 1.2f, -3}, {0, 0.4f, 0}, {0, 1, 0}, 50);
  add_rectangle(d, Transform::rotate({1, 0, 0}, -90) * Transform::scale({4, 4, 1}),
                add_diffuse_rgb(d, 0.8f, 0.5f, 0.3f));
  add_sphere(d, {0, 0.5f, 0}, 0.5f, add_diffuse(d, 0.6f));
  add_area_light_rectangle(
      d, Transform::translate({0.5f, 2, 0}) * Transform::rotate({1, 0, 0}, 90) * Transform::scale({0.7f, 0.5f, 1}), 3);
  d.shapes.back().radiance = SpectrumDescription::rgb(3, 4, 2);
  add_constant_light(d, 0.2f);
  return d;
}

/// For every pixel, the mean of its variance channel minus the variance of its value over the seeds. Both estimate the
/// same without bias, so that the differences have mean zero for any distribution of samples.
MeanVariance differences(const Scene& scene, std::uint32_t samples, int channel, int replicates = 0) {
  std::vector<MeanVariance> values(kSide * kSide), told(kSide * kSide);
  RenderOptions options;
  options.samples_per_pixel = samples;
  options.replicates = replicates;
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
    options.seed = 100 * samples + seed;
    const Image image = render(scene, options).film.to_image();
    const int variance = image.find_channel("variance.R");
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const auto i = static_cast<std::size_t>(y * kSide + x);
        values[i].add(image.at(x, y, channel));
        told[i].add(image.at(x, y, variance + channel));
      }
  }
  MeanVariance all;
  for (std::size_t i = 0; i < values.size(); ++i) all.add(told[i].mean() - values[i].variance());
  return all;
}

}  // namespace

TEST_CASE("variance channels: the estimate of few samples matches the spread of their mean over seeds") {
  constexpr int kTests = 3 * 3;
  PixelFilter with_lobes;
  with_lobes.kind = PixelFilter::Kind::kMitchell;
  struct Variant {
    const char* name;
    ColorMode color;
    PixelFilter filter;
    std::uint32_t samples[3];
  };
  const Variant variants[] = {{"rgb", ColorMode::kRgb, {}, {2, 3, 4}},
                              {"spectral", ColorMode::kSpectral, {}, {2, 3, 4}},
                              {"filter with negative lobes", ColorMode::kRgb, with_lobes, {2, 3, 4}}};
  for (const Variant& variant : variants) {
    CAPTURE(std::string(variant.name));
    Description d = noisy_scene();
    d.film.filter = variant.filter;
    d.film.filter_mode = FilterMode::kImportance;
    CompileOptions options;
    options.color = variant.color;
    const auto scene = compile_scene(d, options);
    for (int i = 0; i < 3; ++i) {
      CAPTURE(variant.samples[i]);
      const MeanVariance found = differences(*scene, variant.samples[i], i);
      INFO("mean difference " << found.mean() << ", deviation of a pixel's " << std::sqrt(found.variance()));
      CHECK(found.p_value(0) > significance_of_each(kTests));
    }
  }
}

TEST_CASE("variance channels: replicates give the variance of any sampler under any filter") {
  struct Variant {
    const char* name;
    SamplerKind sampler;
    PixelFilter::Kind filter;
    std::uint32_t samples;
    int replicates;
  };
  using Kind = PixelFilter::Kind;
  const Variant variants[] = {{"sobol, box", SamplerKind::kSobol, Kind::kBox, 16, 2},
                              {"sobol, gaussian", SamplerKind::kSobol, Kind::kGaussian, 16, 4},
                              {"sobol, mitchell", SamplerKind::kSobol, Kind::kMitchell, 15, 4},
                              {"stratified, gaussian", SamplerKind::kStratified, Kind::kGaussian, 16, 4},
                              {"multijitter, box", SamplerKind::kMultijitter, Kind::kBox, 16, 4},
                              {"independent, gaussian", SamplerKind::kIndependent, Kind::kGaussian, 16, 0}};
  for (const Variant& variant : variants) {
    CAPTURE(std::string(variant.name));
    Description d = noisy_scene();
    d.sampler.kind = variant.sampler;
    d.film.filter.kind = variant.filter;
    const auto scene = compile_scene(d);
    const MeanVariance found = differences(*scene, variant.samples, 1, variant.replicates);
    INFO("mean difference " << found.mean() << ", deviation of a pixel's " << std::sqrt(found.variance()));
    CHECK(found.p_value(0) > significance_of_each(static_cast<int>(std::size(variants))));
  }
}

TEST_CASE("variance channels: correlated samples without replicates have no variance channels") {
  Description d = noisy_scene();
  RenderOptions options;
  options.samples_per_pixel = 4;
  const auto has_variance = [&] {
    return render(*compile_scene(d), options).film.to_image().find_channel("variance.R") >= 0;
  };
  CHECK(has_variance());
  d.sampler.kind = SamplerKind::kSobol;
  CHECK_FALSE(has_variance());
  options.replicates = 2;
  CHECK(has_variance());
}

}  // namespace sheaf::test_variance_channels
