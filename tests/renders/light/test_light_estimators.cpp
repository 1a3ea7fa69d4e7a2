// The mean of direct light does not depend on the light selector or the number of candidates: Student's t-tests of
// small images against a long render that selects lights uniformly.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/files/image_files.h"
#include "tests/support/statistics.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <functional>
#include <string>

namespace sheaf::test_light_estimators {

namespace {

constexpr int kSide = 24, kBlocks = 4;

/// A floor, a glossy sphere and a screen that shadows part of both, with two small lights besides the light under test.
Description stage_scene() {
  Description d = empty_scene(kSide, kSide);
  d.sampler.kind = SamplerKind::kIndependent;
  d.integrator.max_depth = 3;
  look_at(d, {0, 1.6f, -4}, {0, 0.4f, 0}, {0, 1, 0}, 45);
  add_rectangle(d, Transform::rotate({1, 0, 0}, -90) * Transform::scale({4, 4, 1}),
                add_diffuse_rgb(d, 0.6f, 0.5f, 0.4f));
  ConductorDescription metal;
  metal.ior = {SpectrumDescription::rgb(0.2f, 0.9f, 1.2f), SpectrumDescription::rgb(3.5f, 2.5f, 2)};
  metal.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.15f, 0.15f};
  add_sphere(d, {0.5f, 0.5f, 0}, 0.5f, add_material(d, metal));
  add_rectangle(
      d,
      Transform::translate({-0.9f, 0.7f, 0.2f}) * Transform::rotate({0, 1, 0}, 40) * Transform::scale({0.4f, 0.5f, 1}),
      add_two_sided(d, add_diffuse(d, 0.3f)));
  add_area_light_sphere(d, {-1.6f, 1.2f, -1.2f}, 0.12f, 6);
  add_point_light(d, {1.8f, 2, -0.5f}, 0.8f);
  return d;
}

Transform over_the_stage() { return Transform::translate({0.3f, 2.2f, 0.3f}) * Transform::rotate({1, 0, 0}, 90); }

MaterialId black(Description& d) { return add_diffuse(d, 0); }

TextureId add_squares(Description& d) {
  TextureDescription squares;
  squares.model = CheckerboardDescription{SpectrumDescription::rgb(3, 0.2f, 1), SpectrumDescription::rgb(0.5f, 6, 1)};
  d.textures.push_back(squares);
  return static_cast<TextureId>(d.textures.size() - 1);
}

void add_instanced_light(Description& d) {
  ShapeGroup group;
  ShapeDescription lamp;
  lamp.geometry = RectangleShape{};
  lamp.material = black(d);
  emit(lamp, 4);
  group.shapes.push_back(lamp);
  d.groups.push_back(group);
  for (const float x : {-1.0f, 1.2f}) {
    const Transform position =
        Transform::translate({x, 0, 0}) * over_the_stage() * Transform::scale({0.3f, -0.3f, -0.3f});
    InstanceDescription instance;
    for (std::size_t i = 0; i < 12; ++i) instance.to_world[i] = position.matrix().m[i / 4][i % 4];
    d.instances.push_back(instance);
  }
}

struct Emitter {
  const char* name;
  std::function<void(Description&, const std::filesystem::path&)> add;
};

const std::vector<Emitter>& emitters() {
  static const std::vector<Emitter> all = {
      {"rectangle",
       [](Description& d, const auto&) {
         add_area_light_rectangle(d, over_the_stage() * Transform::scale({0.5f, 0.4f, 1}), 5);
       }},
      {"large sphere",
       [](Description& d, const auto&) {
         add_area_light_sphere(d, {1.8f, 1.8f, 1}, 0.7f, 2);
       }},
      {"disk",
       [](Description& d, const auto&) {
         emit(add_shape(d, DiskShape{}, over_the_stage() * Transform::scale({0.5f, 0.3f, 1}), black(d)), 5);
       }},
      {"cylinder",
       [](Description& d, const auto&) {
         emit(add_shape(d, CylinderShape{}, over_the_stage() * Transform::scale({0.1f, 0.1f, 1}), black(d)), 5);
       }},
      {"textured rectangle",
       [](Description& d, const auto&) {
         add_area_light_rectangle(d, over_the_stage() * Transform::scale({0.5f, 0.4f, 1}), 1);
         const TextureId squares = add_squares(d);
         d.shapes.back().radiance = squares;
       }},
      {"instances", [](Description& d, const auto&) { add_instanced_light(d); }},
      {"point",
       [](Description& d, const auto&) {
         add_point_light(d, {-0.5f, 2, 0.5f}, 2);
       }},
      {"spot",
       [](Description& d, const auto&) {
         SpotLightDescription spot;
         spot.to_world = over_the_stage();
         spot.intensity = SpectrumDescription::constant(4);
         d.lights.push_back({spot, {}});
       }},
      {"projector",
       [](Description& d, const auto&) {
         ProjectorDescription projector;
         projector.to_world = over_the_stage();
         projector.irradiance = add_squares(d);
         d.lights.push_back({projector, {}});
       }},
      {"directional",
       [](Description& d, const auto&) {
         d.lights.push_back({DirectionalLightDescription{{0.5f, -1, 0.3f}, SpectrumDescription::constant(0.8f)}, {}});
       }},
      {"constant", [](Description& d, const auto&) { add_constant_light(d, 0.3f); }},
      {"environment map",
       [](Description& d, const std::filesystem::path& folder) {
         write_pnm(folder / "sky.ppm", 4, 3, 3, 255,
                   {10, 20, 60, 80, 20, 5,  30, 30, 30, 90, 90, 200, 255, 250, 200, 9,  9,  9,
                    40, 50, 60, 30, 90, 30, 5,  5,  5,  20, 10, 5,   9,   30,  30,  12, 12, 12});
         d.lights.push_back({EnvmapDescription{folder / "sky.ppm", 2, Transform::rotate({0, 1, 0}, 30), false}, {}});
       }},
  };
  return all;
}

/// Means over blocks of pixels and their variances, channel by channel.
struct BlockMeans {
  std::array<double, 3 * kBlocks * kBlocks> mean{}, variance{};
};

BlockMeans rendered(const Description& d, std::uint32_t seed, std::uint32_t samples) {
  RenderOptions options;
  options.seed = seed;
  options.samples_per_pixel = samples;
  const Image image = render(*compile_scene(d), options).film.to_image();
  constexpr int kSize = kSide / kBlocks;
  const int variance = image.find_channel("variance.R");
  BlockMeans out;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      for (int c = 0; c < 3; ++c) {
        const auto k = static_cast<std::size_t>((y / kSize * kBlocks + x / kSize) * 3 + c);
        out.mean[k] += image.at(x, y, c) / double(kSize * kSize);
        out.variance[k] += image.at(x, y, variance + c) / std::pow(double(kSize * kSize), 2);
      }
  return out;
}

/// The smallest p-value of all blocks and channels.
double least_p_value(const BlockMeans& a, const BlockMeans& b, double degrees) {
  double least = 1;
  for (std::size_t k = 0; k < a.mean.size(); ++k) {
    const double error = std::sqrt(a.variance[k] + b.variance[k]);
    if (error > 0) least = std::min(least, student_t_p_value((a.mean[k] - b.mean[k]) / error, degrees));
  }
  return least;
}

}  // namespace

TEST_SUITE("slow") {
  TEST_CASE("light estimators: every emitter has the same mean for every selector and number of candidates") {
    constexpr std::uint32_t kSamples = 128, kReferenceSamples = 4096;
    constexpr LightSelector kSelectors[] = {LightSelector::kUniform, LightSelector::kPower, LightSelector::kBvh};
    constexpr int kCandidateCounts[] = {1, 4, 32};
    const int tests = static_cast<int>(emitters().size()) * 9 * 3 * kBlocks * kBlocks;
    const TemporaryFolder folder;
    std::uint32_t seed = 1;
    for (const Emitter& emitter : emitters()) {
      CAPTURE(std::string(emitter.name));
      Description d = stage_scene();
      emitter.add(d, folder.path());
      d.integrator.light_selector = LightSelector::kUniform;
      const BlockMeans reference = rendered(d, 1000, kReferenceSamples);
      for (const LightSelector selector : kSelectors)
        for (const int candidates : kCandidateCounts) {
          CAPTURE(static_cast<int>(selector));
          CAPTURE(candidates);
          d.integrator.light_selector = selector;
          d.integrator.candidates = candidates;
          const double p = least_p_value(rendered(d, seed++, kSamples), reference, kSamples - 1);
          CHECK(p > significance_of_each(tests));
        }
    }
  }
}

}  // namespace sheaf::test_light_estimators
