// Photon mapping: energy, and every combination of maps and final gathering against the path tracer, whose mean they
// share but for the blur of the radius.
#include "kernels/passes/render.h"
#include "kernels/passes/trace_photons.h"
#include "scene/compile/compile.h"
#include "tests/support/media_testing.h"
#include "tests/support/statistics.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

namespace sheaf {

namespace {

const double kLevel = significance_of_each(100);

PhotonMap trace(const Scene& scene, std::uint32_t seed, const PhotonMapDescription& map, PhotonKind kind,
                std::vector<std::string>* warnings = nullptr) {
  StageContext context(scene);
  context.sampler.seed = seed;
  Workers workers([&] { return Worker(256, WaveNeeds::of(context)); });
  PhotonTracing tracing{[] { return false; }, [](std::uint64_t) {}};
  PhotonMap out = trace_photons(context, workers, map, kind, PhotonKernel::kDisc, tracing);
  if (warnings != nullptr) *warnings = tracing.warnings;
  return out;
}

double total_power(const PhotonMap& map) {
  double sum = 0;
  for (std::size_t i = 0; i < map.size(); ++i) sum += static_cast<double>(map.view().power[1][i]);
  return sum;
}

/// A room with a light below its ceiling, a ball of glass or of something diffuse on its floor, and a camera inside.
Description room(bool glass, std::uint32_t samples) {
  Description d = empty_scene(24, 24);
  d.sampler.sample_count = samples;
  look_at(d, {0, -1.9f, 1}, {0, 0, 0.7f}, {0, 0, 1}, 60);
  d.integrator.rr_depth = 20;
  d.integrator.max_depth = 8;
  ShapeDescription& walls = add_shape(d, CubeShape{}, Transform::translate({0, 0, 1}) * Transform::scale({2, 2, 1}),
                                      add_diffuse_rgb(d, 0.6f, 0.5f, 0.4f));
  walls.flip_normals = true;
  emit(add_rectangle(d,
                     Transform::translate({0.4f, 0.2f, 1.98f}) * Transform::rotate({1, 0, 0}, 180) *
                         Transform::scale({0.3f, 0.3f, 1}),
                     add_diffuse(d, 0)),
       10);
  add_sphere(d, {-0.2f, 0.3f, 0.55f}, 0.5f, glass ? add_glass(d) : add_diffuse(d, 0.7f));
  return d;
}

/// The mean of a picture.
struct Mean {
  double value, variance;  ///< of the mean
};
Mean mean_of(const Description& d, int repeats = 8) {
  const auto scene = compile_scene(d);
  MeanVariance mean;
  for (int i = 0; i < repeats; ++i) {
    RenderOptions options;
    options.seed = static_cast<std::uint32_t>(i + 1);
    const Image image = render(*scene, options).to_image();
    double sum = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) sum += static_cast<double>(image.at(x, y, 1));
    mean.add(sum / (image.width * image.height));
  }
  return {mean.mean(), mean.variance() / repeats};
}

/// The same by the path tracer, with many samples.
Mean path_mean(Description d) {
  d.integrator.kind = IntegratorKind::kPath;
  d.sampler.sample_count = 400;
  return mean_of(d);
}

void check_close(const Mean& found, const Mean& expected, double bias) {
  const double error = std::sqrt(found.variance + expected.variance);
  INFO("mean " << found.value << ", path tracer " << expected.value << ", standard error " << error);
  const double distance = std::fabs(found.value - expected.value) - bias * expected.value;
  if (distance > 0) CHECK(student_t_p_value(distance / error, 14) >= kLevel);
}

}  // namespace

TEST_CASE("photon mapping: in a closed box photons leave the light's power over the share that is absorbed") {
  for (const float reflectance : {0.0f, 0.5f, 0.8f}) {
    CAPTURE(reflectance);
    Description d = empty_scene(4, 4);
    d.integrator.rr_depth = 3;
    ShapeDescription& box = add_shape(d, CubeShape{}, Transform(), add_diffuse(d, reflectance));
    box.flip_normals = true;
    add_point_light(d, {0.2f, 0.3f, -0.5f}, 3);
    const auto scene = compile_scene(d);
    MeanVariance mean;
    for (std::uint32_t seed = 0; seed < 12; ++seed)
      mean.add(total_power(trace(*scene, seed, {20000, 0.1f, 0}, PhotonKind::kGlobal)));
    const double expected = 4 * 3.14159265358979 * 3 / (1 - static_cast<double>(reflectance));
    INFO("power " << mean.mean() << ", expected " << expected);
    if (std::fabs(mean.mean() - expected) > 1e-4 * expected) CHECK(mean.p_value(expected) >= kLevel);
  }
}

TEST_CASE("photon mapping: the caustics map holds what specular surfaces alone have sent") {
  Description d = empty_scene(4, 4);
  // A mirror on the floor of a closed box sends a known share of the light to the walls.
  d.integrator.max_depth = -1;
  ShapeDescription& box = add_shape(d, CubeShape{}, Transform(), add_diffuse(d, 0.5f));
  box.flip_normals = true;
  add_rectangle(d, Transform::translate({0, 0, -0.9f}), add_mirror(d, 0.7f));
  add_point_light(d, {0, 0, 0.1f}, 1);
  const auto scene = compile_scene(d);
  MeanVariance mean;
  for (std::uint32_t seed = 0; seed < 12; ++seed)
    mean.add(total_power(trace(*scene, seed, {20000, 0.1f, 0}, PhotonKind::kCaustic)));
  // A square seen from one half side above its middle fills a sixth of the sphere.
  const double expected = 4 * 3.14159265358979 / 6 * 0.7;
  INFO("power " << mean.mean() << ", expected " << expected);
  CHECK(mean.p_value(expected) >= kLevel);
}

TEST_CASE(
    "photon mapping: a map that no light reaches is said to be empty, and the picture is what the camera sees of "
    "lights") {
  Description d = empty_scene(8, 8);
  add_sphere(d, {0, 0, 4}, 1, add_mirror(d, 0.5f));
  add_point_light(d, {0, 2, 0}, 5);
  std::vector<std::string> warnings;
  CHECK(trace(*compile_scene(d), 1, {1000, 0.1f, 0}, PhotonKind::kGlobal, &warnings).size() == 0);
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0].find("holds 0 of the 1000 photons") != std::string::npos);
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  d.integrator.photons.global.count = 1000;
  const RenderResult result = render(*compile_scene(d), {});
  CHECK(!result.interrupted);
  CHECK(result.warnings.size() == 1);
}

TEST_CASE("photon mapping: the same bits for all thread counts and wave sizes, and in a crop") {
  Description d = room(true, 2);
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  d.integrator.photons.global = {5000, 0.1f, 0};
  d.integrator.photons.caustic = {500, 0.05f, 0};
  for (const bool final_gather : {false, true}) {
    d.integrator.photons.final_gather = final_gather;
    const auto scene = compile_scene(d);
    const Image whole = render(*scene, {}).to_image();
    for (const int threads : {1, 2, 7})
      for (const int wave_size : {64, 1000}) {
        CAPTURE(threads);
        CAPTURE(wave_size);
        RenderOptions options;
        options.threads = threads;
        options.wave_size = wave_size;
        CHECK(render(*scene, options).to_image().data == whole.data);
      }
    RenderOptions options;
    options.crop = PixelRect{3, 5, 11, 9};
    const Image crop = render(*scene, options).to_image();
    bool same = true;
    for (int y = 0; y < crop.height; ++y)
      for (int x = 0; x < crop.width; ++x)
        for (int c = 0; c < static_cast<int>(crop.channels.size()); ++c)
          same = same && crop.at(x, y, c) == whole.at(x + 3, y + 5, c);
    CHECK(same);
  }
}

TEST_SUITE_BEGIN("slow");

TEST_CASE("photon mapping: maps, final gathering and the caustics map have the path tracer's mean") {
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
    d.integrator.photons.final_gather = true;
    check_close(mean_of(d), path, 0.005);
    d.integrator.photons.caustic = {30'000, 0.02f, 0};
    check_close(mean_of(d), path, 0.005);
    d.integrator.photons.gather_rays = 4;
    d.sampler.sample_count = 9;
    check_close(mean_of(d), path, 0.005);
  }
}

TEST_CASE("photon mapping: depth is limited as it is for paths") {
  for (const int depth : {2, 3, 4}) {
    CAPTURE(depth);
    Description d = room(true, 36);
    d.integrator.max_depth = depth;
    const Mean path = path_mean(d);
    d.integrator.kind = IntegratorKind::kPhotonMapper;
    d.integrator.photons.global = {60'000, 0.05f, 0};
    check_close(mean_of(d), path, 0.02);
    d.integrator.photons.final_gather = true;
    d.integrator.photons.caustic = {30'000, 0.02f, 0};
    check_close(mean_of(d), path, 0.005);
  }
}

TEST_CASE("photon mapping: surfaces in fog, behind panes and with plastic's coat") {
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
      d.integrator.free_panes = true;
    } else {
      PlasticDescription plastic;
      add_sphere(d, {0.8f, 0.5f, 0.4f}, 0.4f, add_material(d, plastic));
    }
    const Mean path = path_mean(d);
    d.integrator.kind = IntegratorKind::kPhotonMapper;
    d.integrator.photons.global = {60'000, 0.05f, 0};
    check_close(mean_of(d), path, 0.02);
    d.integrator.photons.final_gather = true;
    check_close(mean_of(d), path, 0.005);
    d.integrator.photons.caustic = {30'000, 0.02f, 0};
    check_close(mean_of(d), path, 0.005);
  }
}

TEST_SUITE_END();

}  // namespace sheaf
