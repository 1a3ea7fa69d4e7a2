// Guided renders: the mean of unguided ones, less noise where light is hard to find, and bits that do not depend on
// threads, waves or crop.
#include "core/io/error.h"
#include "kernels/training/train_guiding.h"
#include "kernels/wave/wave.h"
#include "scene/data/glasses.h"
#include "tests/support/capture.h"
#include "tests/support/media_testing.h"
#include "tests/support/render_testing.h"
#include "tests/support/temporary_folder.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace sheaf::test_guiding {

namespace {

/// All comparisons of means of this file together fail with probability kSignificance if guiding is unbiased.
const double kLevel = significance_of_each(60);

/// Two rooms joined by a gap, one with a lamp, seen from the other. Every pixel sees one point. `fraction` scales the
/// reflectance of the walls.
Description two_rooms(int samples, float fraction = 1) {
  Description d = one_point_scene(samples);
  d.film.width = d.film.height = 16;
  d.integrator.max_depth = 6;
  look_at_point(d, {-0.6f, 0.1f, 0.2f}, {-0.9f, 0.2f, -1}, {0, 1, 0});
  const MaterialId wall = add_two_sided(d, add_diffuse_rgb(d, 0.7f * fraction, 0.6f * fraction, 0.5f * fraction));
  add_shape(d, CubeShape{}, Transform::scale({2, 1, 1}), wall);
  add_rectangle(
      d, Transform::translate({0, 0, -0.2f}) * Transform::rotate({0, 1, 0}, 90) * Transform::scale({0.8f, 1, 1}), wall);
  emit(add_rectangle(d,
                     Transform::translate({1.5f, 0.99f, 0}) * Transform::rotate({1, 0, 0}, 90) *
                         Transform::scale({0.3f, 0.3f, 1}),
                     add_diffuse(d, 0)),
       20);
  return d;
}

struct Guided {
  MeanVariance off, on;  ///< of the green channel
};

Guided both_directions(const Description& d, ColorMode color = ColorMode::kRgb) {
  Guided means;
  const auto scene = compile_scene(d, {false, color});
  for (const bool guiding : {false, true}) {
    RenderOptions options;
    options.guiding = guiding ? GuidingMode::kOn : GuidingMode::kOff;
    options.seed = guiding ? 6 : 5;
    const RenderResult result = render(*scene, options);
    CHECK(result.report.guiding.passes == (guiding ? 3 : 0));
    const Image image = result.film.to_image();
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) (guiding ? means.on : means.off).add(image.at(x, y, 1));
  }
  return means;
}

void check_means(const Description& d, ColorMode color = ColorMode::kRgb) {
  const Guided means = both_directions(d, color);
  check_same_mean(means.off, means.on, kLevel, 16 * 16);
}

MaterialId add_rough_glass(Description& d) {
  DielectricDescription glass;
  glass.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.4f, 0.4f};
  return add_material(d, glass);
}

}  // namespace

TEST_CASE("guiding: guided paths have the mean of unguided ones and less noise") {
  for (const LightStrategy strategy : {LightStrategy::kMis, LightStrategy::kLightOnly}) {
    Description d = two_rooms(64);
    d.integrator.strategy = strategy;
    const Guided means = both_directions(d);
    check_same_mean(means.off, means.on, kLevel, 16 * 16);
    CHECK(means.on.variance() < 0.6 * means.off.variance());
  }
}

TEST_CASE("guiding: the mean is kept without light sampling and with several candidates in both color modes") {
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
    Description d = two_rooms(64);
    d.integrator.candidates = 4;
    add_point_light(d, {1.5f, -0.9f, 0.5f}, 1);
    check_means(d, color);
    d.integrator.strategy = LightStrategy::kBsdfOnly;
    d.lights.clear();
    add_constant_light(d, 1);
    d.shapes[0].geometry = RectangleShape{};
    d.shapes[0].to_world =
        Transform::translate({0, -1, 0}) * Transform::rotate({1, 0, 0}, -90) * Transform::scale({2, 2, 1});
    look_at_point(d, {-0.6f, 0.1f, 0.2f}, {-0.5f, -1, 0}, {0, 1, 0});
    check_means(d, color);
  }
}

TEST_CASE("guiding: light sampling and guided sampling are combined by MIS") {
  // An emissive wall that both strategies find with similar probability.
  Description d = one_point_scene(64);
  d.film.width = d.film.height = 16;
  look_at_point(d, {0, 2, 0.5f}, {0, 0, 0}, {0, 0, 1});
  add_rectangle(d, Transform::rotate({1, 0, 0}, -90) * Transform::scale({4, 4, 1}), add_diffuse(d, 0.8f));
  add_area_light_rectangle(
      d, Transform::translate({1, 1, 0}) * Transform::rotate({0, 1, 0}, -90) * Transform::scale({2, 1, 1}), 1);
  for (const int candidates : {1, 4}) {
    d.integrator.candidates = candidates;
    check_means(d);
  }
  d.camera.medium = add_medium(d, fog(0.2f, 0.9f));
  check_means(d);
}

TEST_CASE("guiding: the mean is kept with blends and coats and glass and two-sided surfaces and roulette") {
  Description d = two_rooms(64);
  d.integrator.max_depth = -1;
  d.integrator.rr_depth = 3;
  PlasticDescription plastic;
  const MaterialId shiny = add_material(d, plastic), rough = add_rough_glass(d);
  const MaterialId blend = add_material(d, BlendDescription{0.4f, {add_diffuse(d, 0.6f), add_mirror(d, 0.8f)}});
  add_sphere(d, {-1.2f, -0.5f, -0.4f}, 0.4f, blend);
  add_sphere(d, {-1.5f, 0.5f, -0.5f}, 0.3f, rough);
  add_sphere(d, {-0.4f, -0.6f, 0.4f}, 0.3f, shiny);
  check_means(d);
  // The camera looks at the blend itself, then at the plastic.
  look_at_point(d, {-0.6f, 0.1f, 0.2f}, {-1.2f, -0.5f, -0.4f}, {0, 1, 0});
  check_means(d);
  look_at_point(d, {-0.6f, 0.1f, 0.2f}, {-0.4f, -0.6f, 0.4f}, {0, 1, 0});
  check_means(d);
}

TEST_CASE("guiding: Russian roulette by expected contribution keeps paths that reach the light") {
  // Roulette by throughput would end most paths in the dark room, because dark walls reduce it below one half at once.
  Description d = two_rooms(64, 0.4f);
  d.integrator.max_depth = -1;
  for (const auto& [rr_depth, most] : {std::pair{2, 0.2}, {5, 0.5}}) {
    d.integrator.rr_depth = rr_depth;
    const Guided means = both_directions(d);
    check_same_mean(means.off, means.on, kLevel, 16 * 16);
    CHECK(means.on.variance() < most * means.off.variance());
  }
}

TEST_CASE("guiding: lossless surfaces keep the energy of every lobe") {
  // In a constant environment all directions have the same radiance: a white plastic has radiance 1, as has a diffuse
  // base under a mirror.
  const auto furnace = [](MaterialId (*material)(Description&), ColorMode color) {
    Description d = one_point_scene(64);
    d.film.width = d.film.height = 16;
    d.integrator.max_depth = 2;
    d.integrator.strategy = LightStrategy::kBsdfOnly;
    look_at_point(d, {0, -2, 1.2f}, {0, 0, 0});
    add_rectangle(d, Transform::scale({3, 3, 1}), material(d));
    add_constant_light(d, 1);
    return both_directions(d, color);
  };
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
    const Guided plastic = furnace(
        [](Description& d) {
          PlasticDescription white;
          white.int_ior = 2.2f;
          white.diffuse_reflectance = SpectrumDescription::constant(1);
          return add_material(d, white);
        },
        color);
    check_same_mean(plastic.off, plastic.on, kLevel, 16 * 16);
    const Guided blend = furnace(
        [](Description& d) {
          return add_material(d, BlendDescription{0.5f, {add_diffuse(d, 1), add_mirror(d, 1)}});
        },
        color);
    check_mean(blend.on, 1, kLevel, 1e-3);
  }
}

TEST_CASE("guiding: glossy and layered and dispersive surfaces that fill the image keep their mean") {
  const std::vector<std::pair<const char*, MaterialId (*)(Description&)>> materials = {
      {"plastic",
       [](Description& d) {
         PlasticDescription plastic;
         plastic.int_ior = 1.9f;
         return add_material(d, plastic);
       }},
      {"rough plastic",
       [](Description& d) {
         PlasticDescription plastic;
         plastic.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.2f, 0.2f};
         return add_material(d, plastic);
       }},
      {"rough conductor",
       [](Description& d) {
         ConductorDescription metal;
         metal.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.2f, 0.2f};
         return add_material(d, metal);
       }},
      {"rough glass", add_rough_glass},
      {"blend with dispersive glass",
       [](Description& d) {
         DielectricDescription glass;
         glass.int_dispersion = *find_dispersion("sf11");
         glass.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.4f, 0.4f};
         return add_material(d, BlendDescription{0.6f, {add_diffuse(d, 0.6f), add_material(d, glass)}});
       }},
  };
  for (const auto& [name, material] : materials)
    for (const LightStrategy strategy : {LightStrategy::kMis, LightStrategy::kBsdfOnly}) {
      CAPTURE_BINDING(name);
      CAPTURE(static_cast<int>(strategy));
      Description d = one_point_scene(64);
      d.film.width = d.film.height = 16;
      d.integrator.max_depth = 3;
      d.integrator.strategy = strategy;
      look_at_point(d, {0, -2, 1.2f}, {0, 0, 0});
      add_rectangle(d, Transform::scale({3, 3, 1}), material(d));
      // Lights about as wide as the lobes: one in the mirror direction, one to the side, one below.
      add_area_light_rectangle(
          d, Transform::translate({0, 2, 1.2f}) * Transform::rotate({1, 0, 0}, 90) * Transform::scale({1, 0.8f, 1}), 2);
      add_area_light_sphere(d, {-1.5f, 0, 1}, 0.6f, 2);
      add_area_light_sphere(d, {0, 1, -1.5f}, 0.7f, 1);
      check_means(d, ColorMode::kSpectral);
    }
}

namespace {

/// Records the rays that look for the nearest hit.
class NearestRays : public RayRecorder {
 public:
  explicit NearestRays(std::vector<std::array<float, 6>>& rays) : rays_(rays) {}
  void record(const RayPacket& packet, int count, Query query) override {
    for (int i = 0; i < count && query == Query::kNearest; ++i)
      rays_.push_back({packet.origin_x[i], packet.origin_y[i], packet.origin_z[i], packet.direction_x[i],
                       packet.direction_y[i], packet.direction_z[i]});
  }

 private:
  std::vector<std::array<float, 6>>& rays_;
};

}  // namespace

TEST_CASE("guiding: training paths and image paths use different random numbers") {
  // Otherwise the samples of the image would not be independent of the guide.
  for (const SamplerKind kind : {SamplerKind::kSobol, SamplerKind::kIndependent}) {
    Description d = two_rooms(16);
    d.sampler.kind = kind;
    look_at(d, {-0.6f, 0.1f, 0.8f}, {-0.9f, 0, -1}, {0, 1, 0}, 70);
    std::vector<std::array<float, 6>> rays;
    NearestRays recorder(rays);
    RenderOptions options;
    options.guiding = GuidingMode::kOn;
    options.threads = 1;
    options.make_recorder = [&] { return &recorder; };
    CHECK(render(*compile_scene(d), options).report.guiding.passes > 0);
    CHECK(rays.size() > 16u * 16 * 18);
    std::sort(rays.begin(), rays.end());
    CHECK(std::adjacent_find(rays.begin(), rays.end()) == rays.end());
  }
}

TEST_CASE("guiding: the mean is kept in media") {
  const TemporaryFolder folder;
  for (const bool grid : {false, true}) {
    CAPTURE(grid);
    Description d = two_rooms(64);
    MediumDescription medium = fog(1, 0.9f);
    medium.phase = add_phase(d, 0.5f);
    if (grid)
      medium.density = vol(write_vol(folder / "v.vol", 4, 1, [](Vec3f p, int) { return 0.3f + p.y; }),
                           Transform::translate({-2, -1, -1}) * Transform::scale({4, 2, 2}));
    d.camera.medium = add_medium(d, medium);
    check_means(d);
    check_means(d, ColorMode::kSpectral);
  }
}

TEST_CASE("guiding: the bits do not depend on threads or wave size or crop") {
  Description d = two_rooms(32);
  d.film.width = 40, d.film.height = 30;
  look_at(d, {-0.6f, 0.1f, 0.8f}, {-0.9f, 0, -1}, {0, 1, 0}, 70);
  MediumDescription medium = fog(0.3f, 0.9f);
  d.camera.medium = add_medium(d, medium);
  const auto scene = compile_scene(d);
  RenderOptions options;
  options.guiding = GuidingMode::kOn;
  options.threads = 1;
  options.wave_size = 256;
  const Image whole = render(*scene, options).film.to_image();
  for (const auto& [threads, wave_size] : {std::pair{2, 1024}, {7, 1600}, {2, 65}, {1, 1}}) {
    CAPTURE_BINDING(threads);
    CAPTURE_BINDING(wave_size);
    options.threads = threads, options.wave_size = wave_size;
    const Image same = render(*scene, options).film.to_image();
    CHECK(std::memcmp(same.data.data(), whole.data.data(), whole.data.size() * sizeof(float)) == 0);
  }
  options.crop = PixelRect{7, 5, 31, 22};
  const Image part = render(*scene, options).film.to_image();
  bool equal = true;
  for (int y = 0; y < part.height; ++y)
    for (int x = 0; x < part.width; ++x)
      for (int c = 0; c < 3; ++c)
        equal = equal && part.at(x, y, c) == whole.at(x + 7, y + 5, c) && part.at(x, y, c) > 0;
  CHECK(equal);
  options.crop.reset();
  options.guiding = GuidingMode::kOff;
  const Image unguided = render(*scene, options).film.to_image();
  CHECK(std::memcmp(unguided.data.data(), whole.data.data(), whole.data.size() * sizeof(float)) != 0);
}

TEST_CASE("guiding: training takes three samples per pixel and at most 3/16 of the render") {
  for (const int width : {128, 200, 480, 1920})
    for (const std::uint32_t samples : {8u, 9u, 16u, 31u, 64u, 100u, 1000u})
      for (const GuidingMode mode : {GuidingMode::kAuto, GuidingMode::kOn}) {
        const int height = width * 9 / 16 + (width == 128 ? 60 : 0);
        const double pixels = double(width) * height;
        const std::vector<TrainingPass> passes = training_passes(width, height, samples, mode);
        CAPTURE(width);
        CAPTURE(samples);
        CAPTURE(mode == GuidingMode::kOn);
        REQUIRE(passes.empty() == (mode == GuidingMode::kAuto && samples < 16));
        if (passes.empty()) continue;
        const double requested = std::max(3.0, mode == GuidingMode::kOn ? samples / 16.0 : 0.0) * pixels;
        const double most = std::min({std::max(requested, 32768.0), 524288.0, samples * pixels * 3 / 16});
        const double taken = double(training_samples(width, height, passes));
        // Rows and columns are rounded up; the last pass may be left out if less than half of its samples remain
        CHECK(taken <= 1.03 * most);
        CHECK(taken > 0.6 * most);
      }
}

TEST_CASE("guiding: integrators without guided paths are a usage error") {
  RenderOptions options;
  options.guiding = GuidingMode::kOn;
  for (const IntegratorKind kind : {IntegratorKind::kPhotonMapper, IntegratorKind::kLightTracer,
                                    IntegratorKind::kNormals, IntegratorKind::kVisibility}) {
    Description d = two_rooms(1);
    d.integrator.kind = kind;
    try {
      render(*compile_scene(d), options);
      FAIL("no error");
    } catch (const Error& error) {
      CHECK(error.exit_code() == ExitCode::kUsage);
      CHECK(std::string(error.what()).find("guiding needs an integrator") != std::string::npos);
    }
  }
  Description d = two_rooms(1);
  d.integrator.ends_at_diffuse = true;
  CHECK_THROWS_AS(render(*compile_scene(d), options), Error);
}

}  // namespace sheaf::test_guiding
