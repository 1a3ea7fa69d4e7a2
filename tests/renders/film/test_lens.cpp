// Renders with the thin lens: edges are sharp everywhere in the focal plane, and elsewhere blurred by the circle of
// confusion.
#include "tests/support/render_testing.h"

#include <string>

namespace sheaf::test_lens {

namespace {

constexpr double kPiD = 3.14159265358979323846;
constexpr int kAcross = 16, kAlong = 96, kDistances = 4;
/// All comparisons of this file together fail with probability kSignificance if the lens is unbiased.
const double kLevel = significance_of_each(2 * 2 * kDistances * kAcross * 3);
/// Pixels from the left or from the top.
constexpr double kEdge = 3.3;
constexpr float kAperture = 0.4f, kFocus = 2;

/// A vertical (`upright`) or horizontal edge between black and white at `distance`.
Description edge_at(float distance, bool upright) {
  Description d = upright ? empty_scene(kAcross, kAlong) : empty_scene(kAlong, kAcross);
  d.camera.fov_axis = upright ? CameraDescription::FovAxis::kX : CameraDescription::FovAxis::kY;
  d.camera.aperture_radius = kAperture;
  d.camera.focus_distance = kFocus;
  d.sampler.kind = SamplerKind::kIndependent;
  d.sampler.sample_count = 64;
  d.sampler.seed = 3;
  d.integrator.max_depth = 1;
  constexpr float kSize = 100;
  const float edge = static_cast<float>(1 - kEdge * 2 / kAcross) * distance + kSize;
  add_area_light_rectangle(d,
                           Transform::translate({upright ? edge : 0, upright ? 0 : edge, distance}) *
                               Transform::rotate({0, 1, 0}, 180) * Transform::scale({kSize, kSize, 1}),
                           1);
  return d;
}

/// Area fraction of the unit disk beyond `x` along one axis.
double disk_fraction(double x) {
  const double t = std::clamp(x, -1.0, 1.0);
  return (std::acos(t) - t * std::sqrt(1 - t * t)) / kPiD;
}

/// Fraction of white that pixel `i` across the edge sees. Through point u of the lens, in radii along the image, the
/// edge appears shifted by kAperture u (1 / distance - 1 / kFocus) on the plane at distance 1.
double expected_white(int i, double distance) {
  const double blur = kAcross / 2.0 * kAperture * std::fabs(1 / distance - 1 / double(kFocus));
  constexpr int kSteps = 2000;
  double sum = 0;
  for (int k = 0; k < kSteps; ++k) {
    const double behind = i + (k + 0.5) / kSteps - kEdge;
    sum += blur > 1e-9 ? disk_fraction(behind / blur) : behind < 0 ? 1 : 0;
  }
  return sum / kSteps;
}

}  // namespace

TEST_CASE("lens: an edge is sharp in the focal plane and blurred by the lens disk before and behind it") {
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral})
    for (const bool upright : {true, false})
      for (const float distance : {0.5f, 1.0f, kFocus, 8.0f}) {
        CAPTURE(static_cast<int>(color));
        CAPTURE(upright);
        CAPTURE(distance);
        CompileOptions options;
        options.color = color;
        const Image image = render(*compile_scene(edge_at(distance, upright), options), {}).film.to_image();
        for (int i = 0; i < kAcross; ++i)
          for (int c = 0; c < 3; ++c) {
            CAPTURE(i);
            CAPTURE(c);
            MeanVariance line;
            for (int j = 0; j < kAlong; ++j) line.add(upright ? image.at(i, j, c) : image.at(j, i, c));
            check_mean(line, expected_white(i, distance), kLevel, 2e-3);
          }
      }
}

TEST_CASE("lens: a small defocused white light is a round white disk") {
  constexpr int kSide = 16;
  constexpr float kDistance = 0.5f;
  Description d = edge_at(kDistance, true);
  d.film.height = kSide;
  d.sampler.sample_count = 512;
  d.shapes.back().to_world =
      Transform::translate({0, 0, kDistance}) * Transform::rotate({0, 1, 0}, 180) * Transform::scale({0.03f, 0.03f, 1});
  const double level = significance_of_each(2 * 3 + 2 * kSide);
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
    CAPTURE(static_cast<int>(color));
    CompileOptions options;
    options.color = color;
    const Image image = render(*compile_scene(d, options), {}).film.to_image();
    for (int c = 0; c < 3; ++c) {
      CAPTURE(c);
      MeanVariance left, left_less_right;
      for (int y = 0; y < kSide / 2; ++y)
        for (int x = 0; x < kSide / 2; ++x) {
          left.add(image.at(x, y, c));
          left_less_right.add(image.at(x, y, c) - image.at(kSide - 1 - x, y, c));
        }
      CHECK(left.mean() > 0);
      CHECK(left_less_right.p_value(0) >= level);
    }
    if (color == ColorMode::kRgb) continue;
    for (int x = 3; x < kSide - 3; ++x)
      for (const int c : {0, 2}) {
        CAPTURE(x);
        CAPTURE(c);
        MeanVariance tint;
        for (int y = 3; y < kSide - 3; ++y) tint.add(image.at(x, y, c) - image.at(x, y, 1));
        CHECK(tint.p_value(0) >= level);
      }
  }
}

}  // namespace sheaf::test_lens
