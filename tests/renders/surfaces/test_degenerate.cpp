// Degenerate scenes: each gives an image or a message, and never a crash, a hang or a value that is not finite.
#include "kernels/render/render.h"
#include "kernels/wave/bucket_sort.h"
#include "scene/compile/compile.h"
#include "tests/support/near.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace sheaf::test_degenerate {

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

/// A lit floor and sphere, which make an image together with any additional object.
Description base_scene() {
  Description d = empty_scene(12, 10);
  look_at(d, {0, 2, 4}, {0, 0, 0}, {0, 1, 0}, 60);
  d.sampler.sample_count = 8;
  add_rectangle(d, Transform::rotate({1, 0, 0}, -90) * Transform::scale({3, 3, 1}), add_diffuse(d, 0.5f));
  add_constant_light(d, 1);
  return d;
}

struct Outcome {
  Image image;
  RenderReport report;
  std::vector<std::string> warnings;  ///< of the scene and of the render
};

/// Renders, and checks that every value of the image is finite and not negative.
Outcome render_all(const Description& d, const RenderOptions& options = {}) {
  const auto scene = compile_scene(d);
  RenderResult result = render(*scene, options);
  Outcome outcome{result.film.to_image(), result.report, scene->warnings()};
  outcome.warnings.insert(outcome.warnings.end(), result.warnings.begin(), result.warnings.end());
  bool good = true;
  for (const float value : outcome.image.data) good = good && std::isfinite(value) && value >= 0;
  CHECK(good);
  CHECK_FALSE(result.interrupted);
  return outcome;
}

std::vector<float> pixels(const Description& d) { return render_all(d).image.data; }

double mean(const Image& image, int channel) {
  double sum = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) sum += image.at(x, y, channel);
  return sum / static_cast<double>(image.pixel_count());
}

Mesh one_triangle(Vec3f a, Vec3f b, Vec3f c) {
  Mesh mesh;
  mesh.positions = {a, b, c};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

}  // namespace

TEST_CASE("an empty scene is black and transparent") {
  const Outcome outcome = render_all(empty_scene(5, 4));
  CHECK(outcome.image.width == 5);
  CHECK(mean(outcome.image, 0) == 0);
  CHECK(mean(outcome.image, 3) == 0);
  CHECK(outcome.report.stats.samples == 20);
}

TEST_CASE("an empty scene in an environment shows the environment") {
  Description d = empty_scene(5, 4);
  add_constant_light(d, 2);
  const Outcome outcome = render_all(d);
  CHECK(mean(outcome.image, 0) == near(2));
  CHECK(mean(outcome.image, 3) == 1);
}

TEST_CASE("a point light without surfaces gives a black image") {
  Description d = empty_scene(5, 4);
  add_point_light(d, {0, 0, 0}, 2);  // at the camera
  CHECK(mean(render_all(d).image, 0) == 0);
}

TEST_CASE("degenerate triangles and NaN vertices are dropped with a warning") {
  const std::vector<float> expected = pixels(base_scene());
  for (const bool emits : {false, true}) {
    CAPTURE(emits);
    for (const Mesh& mesh :
         {one_triangle({0, 1, 0}, {0, 1, 0}, {0, 1, 0}), one_triangle({0, 0, 0}, {1, 1, 0}, {2, 2, 0}),
          one_triangle({0, 1, 0}, {kNan, 1, 0}, {1, 0, 0}), one_triangle({0, kInf, 0}, {1, 1, 0}, {1, 0, 0}),
          one_triangle({0, 0, -kInf}, {kInf, 1, 0}, {kNan, 0, 0}),
          one_triangle({0, 0, 0}, {1e-30f, 0, 0}, {0, 1e-30f, 0}), Mesh{}}) {
      Description d = base_scene();
      add_shape(d, mesh, Transform(), add_diffuse(d, 0.2f));
      if (emits) emit(d.shapes.back(), 5);
      const Outcome outcome = render_all(d);
      CHECK_FALSE(outcome.warnings.empty());
      CHECK(outcome.image.data == expected);
    }
  }
}

TEST_CASE("invalid triangles do not affect the others of their mesh") {
  Mesh mesh = one_triangle({-1, 0.1f, -1}, {0, 0.1f, 1}, {1, 0.1f, -1});
  Description good = base_scene(), bad = good;
  add_shape(good, mesh, Transform(), add_diffuse(good, 0.9f));
  emit(good.shapes.back(), 1);
  mesh.positions.push_back({kNan, kNan, kNan});
  mesh.triangles.insert(mesh.triangles.begin(), {{0, 0, 1}, {3, 1, 2}});
  mesh.triangles.push_back({2, 2, 2});
  add_shape(bad, mesh, Transform(), add_diffuse(bad, 0.9f));
  emit(bad.shapes.back(), 1);
  CHECK(pixels(bad) == pixels(good));
}

TEST_CASE("NaN normals do not affect the image") {
  Description d = base_scene();
  Mesh mesh = one_triangle({-1, 0.1f, -1}, {0, 0.1f, 1}, {1, 0.1f, -1});
  for (const Vec3f normal : {Vec3f{kNan, 0, 0}, Vec3f{0, 0, 0}, Vec3f{kInf, 1, 0}}) mesh.normals.push_back(normal);
  add_shape(d, mesh, Transform(), add_glass(d));
  CHECK(render_all(d).report.stats.dropped.rays == 0);
}

TEST_CASE("lights without power are accepted") {
  Description d = base_scene();
  const std::vector<float> expected = pixels(d);
  SUBCASE("no radiance") {
    add_point_light(d, {0, 1, 0}, 0);
    emit(add_sphere(d, {0, -5, 0}, 0.1f), 0);
    CHECK(pixels(d) == expected);
  }
  SUBCASE("only such lights") {
    d.lights.clear();
    add_constant_light(d, 0);
    add_point_light(d, {0, 1, 0}, 0);
    CHECK(mean(render_all(d).image, 0) == 0);
  }
  SUBCASE("almost no radiance") {
    d.lights.clear();
    add_point_light(d, {0, 1, 0}, 1e-38f);
    emit(add_sphere(d, {0, 1, 0}, 1e-6f), 1e-30f);
    render_all(d);
  }
}

TEST_CASE("radiance may reach the largest floats") {
  for (const float radiance : {1e10f, 1e20f, 1e30f, 3e38f}) {
    CAPTURE(radiance);
    Description d = base_scene();
    d.integrator.max_depth = 4;
    add_area_light_sphere(d, {0, 2, 0}, 0.5f, radiance);
    emit(add_rectangle(d, Transform::translate({0, 0.5f, -2})), radiance);
    CHECK(mean(render_all(d).image, 0) > 0);
  }
}

TEST_CASE("shapes of extreme size and position are rendered") {
  for (const float size : {1e-38f, 1e-30f, 1e-20f, 1e-12f, 1e6f, 1e12f, 1e18f, 1e30f, 3e38f}) {
    CAPTURE(size);
    Description d = base_scene();
    const MaterialId material = add_diffuse(d, 0.5f);
    const auto add_extremes = [&](const Transform& t, bool emits) {
      const std::size_t first = d.shapes.size();
      add_shape(d, one_triangle({-1, 0, 0}, {1, 0, 0}, {0, 1, 0}), t, material);
      add_shape(d, CubeShape{}, t, add_glass(d));
      add_shape(d, SphereShape{}, t, material);
      add_shape(d, DiskShape{}, t, material);
      add_shape(d, CylinderShape{}, t, add_mirror(d));
      for (std::size_t i = first; emits && i < d.shapes.size(); ++i) emit(d.shapes[i], 1);
    };
    for (const bool emits : {false, true}) {
      try {
        add_extremes(Transform::scale({size, size, size}), emits);
        add_extremes(Transform::scale({size, 1, 1 / size}), emits);
        add_extremes(Transform::translate({0, -size, size}), emits);
      } catch (const Error&) {
        continue;  // singular transform
      }
      try {
        render_all(d);
      } catch (const SceneError& error) { CHECK(std::string(error.what()).size() > 10); }
    }
  }
}

TEST_CASE("a mesh of 1e30 units beside an ordinary scene is rendered") {
  Description d = base_scene();
  const std::vector<float> expected = pixels(d);
  add_shape(d, CubeShape{}, Transform::scale({1e30f, 1e30f, 1e30f}), add_diffuse(d, 0.5f));
  const Outcome outcome = render_all(d);
  CHECK_FALSE(outcome.warnings.empty());
  CHECK(outcome.image.data == expected);
}

TEST_CASE("cameras inside shapes and on surfaces give finite images") {
  const auto check_positions = [](const std::function<void(Description&)>& add) {
    for (const Vec3f at : {Vec3f{0, 0, 0}, Vec3f{0, 0, 1}, Vec3f{1, 0, 0}, Vec3f{0.5f, 0.5f, 0.5f}}) {
      Description d = empty_scene(8, 8);
      d.sampler.sample_count = 8;
      look_at(d, at, {at.x + 0.3f, at.y + 0.1f, at.z + 1});
      add_constant_light(d, 1);
      add(d);
      CHECK(render_all(d).report.stats.dropped.rays == 0);
    }
  };
  SUBCASE("glass") {
    check_positions([](Description& d) { add_sphere(d, {0, 0, 0}, 1, add_glass(d)); });
  }
  SUBCASE("diffuse") {
    check_positions([](Description& d) { add_sphere(d, {0, 0, 0}, 1, add_two_sided(d, add_diffuse(d, 0.5f))); });
  }
  SUBCASE("mirror") {
    check_positions([](Description& d) { add_sphere(d, {0, 0, 0}, 1, add_two_sided(d, add_mirror(d))); });
  }
  SUBCASE("light") {
    check_positions([](Description& d) { emit(add_sphere(d, {0, 0, 0}, 1), 1).flip_normals = true; });
  }
  SUBCASE("cube") {
    check_positions([](Description& d) { add_shape(d, CubeShape{}, Transform(), add_glass(d)); });
  }
  SUBCASE("triangle") {
    check_positions([](Description& d) { add_shape(d, one_triangle({-1, 0, 0}, {1, 0, 0}, {0, 0, 1}), Transform()); });
  }
}

TEST_CASE("images of one pixel are rendered") {
  Description d = base_scene();
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 9}, {9, 1}}) {
    d.film.width = width;
    d.film.height = height;
    for (const int wave_size : {0, 1, 2}) {
      RenderOptions options;
      options.samples_per_pixel = 1;
      options.wave_size = wave_size;
      const Outcome outcome = render_all(d, options);
      CHECK(outcome.report.stats.samples == static_cast<std::uint64_t>(width * height));
      CHECK(outcome.image.data.size() == static_cast<std::size_t>(width * height) * outcome.image.channels.size());
    }
  }
}

TEST_CASE("invalid options are errors") {
  const auto scene = compile_scene(base_scene());
  RenderOptions options;
  options.samples_per_pixel = 0;
  CHECK_THROWS_AS(render(*scene, options), Error);
  options = {};
  options.wave_size = kMaxWaveSize + 1;
  CHECK_THROWS_AS(render(*scene, options), Error);
  for (const PixelRect crop : {PixelRect{0, 0, 13, 10}, {-1, 0, 12, 10}, {4, 4, 4, 8}, {5, 5, 4, 4}}) {
    options = {};
    options.crop = crop;
    CHECK_THROWS_AS(render(*scene, options), Error);
  }
}

TEST_CASE("scenes may have more materials than sorting buckets") {
  constexpr int kSide = 24;  // 576 materials
  Description d = empty_scene(kSide, kSide);
  d.sampler.sample_count = 2;
  add_constant_light(d, 1);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const float albedo = static_cast<float>(y * kSide + x + 1) / (kSide * kSide + 1);
      const MaterialId material = (x + y) % 3 == 0 ? add_mirror(d, albedo) : add_diffuse(d, albedo);
      const Vec3f at{1 - (2 * static_cast<float>(x) + 1) / kSide, 1 - (2 * static_cast<float>(y) + 1) / kSide, 1};
      add_rectangle(d,
                    Transform::translate(at) * Transform::rotate({0, 1, 0}, 180) *
                        Transform::scale({1.0f / kSide, 1.0f / kSide, 1}),
                    material);
    }
  REQUIRE(static_cast<int>(d.materials.size()) > kMaxBuckets);
  d.integrator.strategy = LightStrategy::kBsdfOnly;  // noise-free: each sample is the albedo
  const Image image = render_all(d).image;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      REQUIRE(image.at(x, y, 0) == near(double(y * kSide + x + 1) / (kSide * kSide + 1), 1e-5));
}

TEST_CASE("paths trapped in glass end") {
  Description d = empty_scene(4, 4);
  d.sampler.sample_count = 2;
  add_sphere(d, {0, 0, 0}, 1, add_two_sided(d, add_mirror(d)));
  d.integrator.rr_depth = std::numeric_limits<int>::max();
  CHECK(mean(render_all(d).image, 0) == 0);
}

TEST_CASE("a stopped render reports the interruption") {
  const auto scene = compile_scene(base_scene());
  const std::atomic<bool> stop{true};
  RenderOptions options;
  options.stop = &stop;
  const RenderResult result = render(*scene, options);
  CHECK(result.interrupted);
  CHECK(result.report.stats.samples == 0);
}

}  // namespace sheaf::test_degenerate
