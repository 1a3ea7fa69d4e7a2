// Light tracing against path tracing for every camera, pixel filter and path depth, and at the edges of the frame.
#include "tests/renders/light/light_tracing_cases.h"
#include "tests/support/media_testing.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <vector>

namespace sheaf::test_light_tracing_cameras {

using namespace light_tracing_cases;

namespace {

/// Statistics over kRepeats renders of red in the outermost pixels: the sums over the left, right, top and bottom side
/// without corners, and the four corners.
std::array<MeanVariance, 8> edge_statistics(Description d, IntegratorKind kind) {
  d.integrator.kind = kind;
  const auto scene = compile_scene(d);
  std::array<MeanVariance, 8> means;
  for (std::uint32_t i = 0; i < kRepeats; ++i) {
    RenderOptions options;
    options.seed = 2 * i + (kind == IntegratorKind::kPath ? 0u : 1u);
    const Image image = render(*scene, options).to_image();
    const int last = image.width - 1;
    double sums[4] = {};
    for (int k = 1; k < last; ++k) {
      sums[0] += double{image.at(0, k, 0)}, sums[1] += double{image.at(last, k, 0)};
      sums[2] += double{image.at(k, 0, 0)}, sums[3] += double{image.at(k, last, 0)};
    }
    for (std::size_t k = 0; k < 4; ++k) {
      means[k].add(sums[k]);
      means[4 + k].add(double{image.at(k % 2 == 0 ? 0 : last, k / 2 == 0 ? 0 : last, 0)});
    }
  }
  return means;
}

}  // namespace

TEST_CASE("light tracing: pixels at the edge of the frame are unbiased even where geometry ends") {
  using Kind = PixelFilter::Kind;
  PixelFilter wide;
  wide.kind = Kind::kGaussian;
  PixelFilter mitchell, lanczos, box;
  mitchell.kind = Kind::kMitchell, lanczos.kind = Kind::kLanczos, box.radius = 1.3f;
  for (const PixelFilter& filter : {wide, mitchell, lanczos, box})
    for (const FilterMode mode : {FilterMode::kWeighted, FilterMode::kImportance})
      for (const bool border : {false, true}) {
        CAPTURE(static_cast<int>(filter.kind));
        CAPTURE(static_cast<int>(mode));
        CAPTURE(border);
        Description d = empty_scene(8, 8);
        d.sampler.sample_count = 256;
        d.film.filter = filter;
        d.film.filter_mode = mode;
        d.film.sample_border = border;
        d.integrator.max_depth = 2;
        look_at(d, {0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 40);
        add_point_light(d, {0.5f, 0.2f, 1.5f}, 5);
        // The square ends inside the outermost pixels on two sides of the frame and beyond them on the others.
        add_rectangle(d, Transform::translate({0.24f, 0.24f, 0}) * Transform::scale({0.9f, 0.9f, 1}),
                      add_diffuse_rgb(d, 0.8f, 0.6f, 0.4f));
        const auto path = edge_statistics(d, IntegratorKind::kPath),
                   light = edge_statistics(d, IntegratorKind::kLightTracer);
        for (std::size_t k = 0; k < path.size(); ++k) {
          CAPTURE(k);
          // Single precision, and tables of filters.
          check_means_agree(path[k], light[k], 1e-3 * std::fabs(path[k].mean()) + 1e-4);
        }
      }
}

TEST_CASE("light tracing: filters wrap around the sides of a panorama") {
  for (const FilterMode mode : {FilterMode::kWeighted, FilterMode::kImportance})
    for (const bool border : {false, true}) {
      CAPTURE(static_cast<int>(mode));
      CAPTURE(border);
      Description d = empty_scene(12, 6);
      d.sampler.sample_count = 256;
      d.film.filter.kind = PixelFilter::Kind::kGaussian;
      d.film.filter_mode = mode;
      d.film.sample_border = border;
      d.integrator.max_depth = 2;
      d.camera.projection = CameraDescription::Projection::kSpherical;
      // The seam of the panorama is in the dark half of a sphere around the camera.
      const TextureId board = add_checkerboard(d, {0.9f, 0.9f, 0.9f}, {0.1f, 0.1f, 0.1f});
      d.textures.back().to_uv = {1, 0, 0.06f, 0, 1, 0};
      add_shape(d, SphereShape{{0, 0, 0}, 2}, Transform::rotate({1, 0, 0}, -90),
                add_two_sided(d, add_material(d, DiffuseDescription{board})));
      add_point_light(d, {0.3f, 0.2f, -0.5f}, 5);
      const auto sides = [&](IntegratorKind kind) {
        d.integrator.kind = kind;
        const auto scene = compile_scene(d);
        std::array<MeanVariance, 4> means;
        for (std::uint32_t i = 0; i < kRepeats; ++i) {
          RenderOptions options;
          options.seed = 2 * i + (kind == IntegratorKind::kPath ? 0u : 1u);
          const Image image = render(*scene, options).to_image();
          // Rows around the horizon. Beyond the poles, camera rays see the pole itself.
          for (std::size_t k = 0; k < 4; ++k) {
            const int x = k < 2 ? static_cast<int>(k) : image.width - 4 + static_cast<int>(k);
            means[k].add(double{image.at(x, 2, 0)} + double{image.at(x, 3, 0)});
          }
        }
        return means;
      };
      const auto path = sides(IntegratorKind::kPath), light = sides(IntegratorKind::kLightTracer);
      for (std::size_t k = 0; k < path.size(); ++k) {
        CAPTURE(k);
        const double error = std::sqrt((path[k].variance() + light[k].variance()) / kRepeats);
        CHECK(error < 0.02 * path[k].mean());
        check_means_agree(path[k], light[k], 1e-3 * path[k].mean());
      }
    }
}

TEST_SUITE_BEGIN("slow");

TEST_CASE("light tracing: all camera types and clip planes and depths and filters have the mean of path tracing") {
  const std::vector<NamedChange> changes = {
      {"lens", [](Description& d) { d.camera.aperture_radius = 0.2f, d.camera.focus_distance = 3.5f; }},
      {"lens, inside fog",
       [](Description& d) {
         d.camera.aperture_radius = 0.2f, d.camera.focus_distance = 3.5f;
         d.camera.medium = add_medium(d, fog(0.1f, 0.8f));
       }},
      {"orthographic",
       [](Description& d) {
         d.camera.projection = CameraDescription::Projection::kOrthographic;
         d.camera.to_world = d.camera.to_world * Transform::scale({1.5f, 1.5f, 1});
       }},
      {"shifted, not square",
       [](Description& d) {
         d.film.width = 28;
         d.camera.principal_point_x = 0.2f, d.camera.principal_point_y = -0.1f;
       }},
      {"clip planes", [](Description& d) { d.camera.near_clip = 3.6f, d.camera.far_clip = 4.6f; }},
      {"direct light", [](Description& d) { d.integrator.max_depth = 2; }},
      {"two reflections", [](Description& d) { d.integrator.max_depth = 3; }},
      {"roulette", [](Description& d) { d.integrator.max_depth = -1, d.integrator.rr_depth = 1; }},
      {"box", [](Description& d) { d.film.filter = {}; }},
      {"Mitchell", [](Description& d) { d.film.filter.kind = PixelFilter::Kind::kMitchell; }},
      {"Lanczos", [](Description& d) { d.film.filter.kind = PixelFilter::Kind::kLanczos; }},
      {"hidden lights before and behind",
       [](Description& d) {
         d.integrator.hide_emitters = true;
         emit(add_sphere(d, {0, -3, 2}, 0.15f, add_diffuse(d, 0.5f)), 20);
       }},
  };
  for (const NamedChange& change : changes) {
    CAPTURE(change.name);
    Description d = room(256);
    add_named(d, emitters(), "rectangle");
    add_named(d, emitters(), "sphere");
    add_named(d, balls(), "rough conductor");
    add_sphere(d, {0.2f, -2.9f, 2.1f}, 0.05f, add_diffuse(d, 0.9f));  // too close to be in focus
    change.add(d);
    check_agree(d);
  }
}

TEST_SUITE_END();

}  // namespace sheaf::test_light_tracing_cameras
