// Renders with manifold next-event estimation, for comparison with BSDF sampling.
#pragma once

#include "scene/data/glasses.h"
#include "tests/support/render_testing.h"

#include <cmath>

namespace sheaf {

/// A white floor at z = 0, of which every pixel sees the point (0.3, 0, 0) from the side.
inline Description floor_scene(int samples, std::optional<MaterialId> (*material)(Description&) = nullptr) {
  Description d = one_point_scene(samples);
  d.film.width = d.film.height = 16;
  look_at_point(d, {2.5f, 0.2f, 0.5f}, {0.3f, 0, 0});
  add_rectangle(d, Transform::scale({4, 4, 1}), material != nullptr ? *material(d) : add_diffuse(d, 0.8f));
  return d;
}

/// A lamp that faces down at height `z`.
inline void add_lamp(Description& d, Vec3f center, float half_width, float radiance) {
  add_area_light_rectangle(
      d,
      Transform::translate(center) * Transform::rotate({1, 0, 0}, 180) * Transform::scale({half_width, half_width, 1}),
      radiance);
}

/// Statistics of the green channel, and those of the render.
struct Rendered {
  MeanVariance pixels;
  Stats::Chains chains;
};

inline Rendered render_with(const Description& d, CausticMode mode, ColorMode color = ColorMode::kRgb,
                            GuidingMode guiding = GuidingMode::kOff, std::uint32_t seed = 5) {
  RenderOptions options;
  options.caustics = mode;
  options.guiding = guiding;
  options.seed = mode == CausticMode::kSampled ? seed : seed + 1;
  const RenderResult result = render(*compile_scene(d, {false, color}), options);
  Rendered out;
  const Image image = result.film.to_image();
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) out.pixels.add(static_cast<double>(image.at(x, y, 1)));
  out.chains = result.report.stats.chains;
  return out;
}

/// Checks that both ways have the same mean. `max_variance`: of manifold connections over that of BSDF sampling.
/// `level`: significance level. Returns the statistics of manifold connections.
inline Rendered check_caustics_agree(const Description& d, double max_variance, double level,
                                     ColorMode color = ColorMode::kRgb, GuidingMode guiding = GuidingMode::kOff) {
  const Rendered sampled = render_with(d, CausticMode::kSampled, color, guiding);
  const Rendered connected = render_with(d, CausticMode::kManifold, color, guiding);
  check_same_mean(sampled.pixels, connected.pixels, level, 16 * 16);
  CHECK(connected.chains.solutions > 0);
  CHECK(connected.chains.capped == 0);
  CHECK(sampled.chains.attempts == 0);
  CHECK(connected.pixels.variance() < max_variance * sampled.pixels.variance());
  return connected;
}

inline MaterialId add_dispersive_glass(Description& d) {
  DielectricDescription glass;
  glass.int_dispersion = *find_dispersion("sf11");
  return add_material(d, glass);
}

}  // namespace sheaf
