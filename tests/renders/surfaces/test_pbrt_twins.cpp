// Scenes in the formats of pbrt and Mitsuba that render to the same image, sample by sample.
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "scene/dialects/read_scene.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace sheaf::test_pbrt_twins {

namespace {

namespace fs = std::filesystem;

const fs::path kTwins = fs::path(SHEAF_SOURCE_DIR) / "tests" / "renders" / "pbrt_twins";

/// Rounding may change single paths: the fraction of pixels that may differ, and the relative difference of means.
constexpr double kDifferingFraction = 0.002, kMeanDifference = 1e-4;

struct Difference {
  double fraction = 0;  ///< of pixels that differ
  double mean = 0;      ///< largest relative difference of a channel's mean
  double light = 0;     ///< mean of all channels
};

Difference difference(const Image& a, const Image& b) {
  REQUIRE(a.width == b.width);
  REQUIRE(a.height == b.height);
  REQUIRE(a.x0 == b.x0);
  REQUIRE(a.y0 == b.y0);
  Difference d;
  double means[2][3] = {};
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      bool differs = false;
      for (int c = 0; c < 3; ++c) {
        const double first = static_cast<double>(a.at(x, y, c)), second = static_cast<double>(b.at(x, y, c));
        differs = differs || std::fabs(first - second) > 1e-4 * (std::fabs(first) + 0.01);
        means[0][c] += first;
        means[1][c] += second;
      }
      d.fraction += differs ? 1 : 0;
    }
  const auto pixels = static_cast<double>(a.pixel_count());
  d.fraction /= pixels;
  for (int c = 0; c < 3; ++c) {
    d.mean = std::max(d.mean, std::fabs(means[0][c] - means[1][c]) / std::max(means[1][c], 1e-9));
    d.light += means[1][c] / (3 * pixels);
  }
  return d;
}

/// Renders a scene without the clip planes of its camera.
Image render_image(Description d, ColorMode color) {
  d.camera.near_clip = 0, d.camera.far_clip = kInfinity;
  CompileOptions options;
  options.color = color;
  return render(*compile_scene(d, options), {}).film.to_image();
}

void check_twins(const std::string& name, ColorMode color = ColorMode::kRgb) {
  CAPTURE(name);
  const Difference d = difference(render_image(read_scene(kTwins / (name + ".pbrt")), color),
                                  render_image(read_scene(kTwins / (name + ".xml")), color));
  INFO("differing pixels " << d.fraction << ", means " << d.mean << ", light " << d.light);
  CHECK(d.light > 0.005);
  CHECK(d.fraction <= kDifferingFraction);
  CHECK(d.mean <= kMeanDifference);
}

}  // namespace

TEST_SUITE("pbrt twins") {
  TEST_CASE("pbrt scenes render like the same scenes in the format of Mitsuba") {
    std::size_t count = 0;
    for (const auto& entry : fs::directory_iterator(kTwins)) {
      if (entry.path().extension() != ".pbrt") continue;
      ++count;
      check_twins(entry.path().stem().string());
    }
    CHECK(count == 12);
  }

  TEST_CASE("pbrt scenes render equally in spectral mode") {
    check_twins("materials", ColorMode::kSpectral);
    check_twins("lights", ColorMode::kSpectral);
    check_twins("textures", ColorMode::kSpectral);
  }

  TEST_CASE("the comparison detects a mirrored image") {
    Description mirrored = read_scene(kTwins / "camera.pbrt");
    mirrored.camera.to_world = mirrored.camera.to_world * Transform::scale({-1, 1, 1});
    const Image twin = render_image(read_scene(kTwins / "camera.xml"), ColorMode::kRgb);
    CHECK(difference(render_image(mirrored, ColorMode::kRgb), twin).fraction > 0.3);
  }
}

}  // namespace sheaf::test_pbrt_twins
