// Sets of lights for tests of the light tree, and the probabilities with which it selects them.
#pragma once

#include "core/sampling/rng.h"
#include "core/sampling/warp.h"
#include "kernels/lights/light_tree.h"

#include <cmath>
#include <cstdint>
#include <vector>

namespace sheaf::light_tree_cases {

using LightSet = std::vector<LightBounds>;

/// The `i`-th random numbers of a stream, and a direction and a position from them.
inline Random4<Scalar> numbers(std::uint32_t stream, std::uint32_t i) { return random4<Scalar>(stream, i, 3, 0); }
inline Vec3f direction(std::uint32_t stream, std::uint32_t i) {
  const auto u = numbers(stream, i);
  return square_to_sphere<Scalar>(u.x, u.y);
}
inline Vec3f position(std::uint32_t stream, std::uint32_t i, float extent) {
  const auto u = numbers(stream, i);
  return Vec3f{2 * u.x - 1, 2 * u.y - 1, 2 * u.z - 1} * extent;
}

/// A point light.
inline LightBounds point_at(Vec3f p, float power = 1) { return {p, p, {0, 0, 1}, -1, 0, power, false}; }

/// LightSet of every kind within 10 units of the origin with powers over four decades: points, small one-sided and
/// two-sided emitters, spot lights, and curved emitters.
inline LightSet mixed_lights(std::uint32_t count, std::uint32_t seed = 1) {
  LightSet lights;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto u = numbers(seed + 100, i);
    LightBounds light = point_at(position(seed + 101, i, 10), std::pow(10.0f, 4 * u.x - 2));
    light.axis = direction(seed + 102, i);
    if (i % 5 != 0) {
      const Vec3f half{0.3f * u.y, 0.3f * u.z, 0.3f * u.w};
      light.lower = light.lower - half;
      light.upper = light.upper + half;
    }
    if (i % 5 == 1 || i % 5 == 2) light.cos_theta_o = 1;
    if (i % 5 == 2) light.two_sided = true;
    if (i % 5 == 3) {
      light.cos_theta_o = 2 * u.z - 1;
      light.cos_theta_e = 1;
    }
    if (i % 5 == 4) light.cos_theta_o = u.w;
    lights.push_back(light);
  }
  return lights;
}

inline LightTreeSample<Scalar> draw_light(const LightTree& tree, Vec3f p, Vec3f n, float u) {
  return sample_light_tree<Scalar>(tree.view(), p, n, true, u);
}

/// The probability of a light at a point with a normal.
inline double probability(const LightTree& tree, Vec3f p, Vec3f n, std::uint32_t light) {
  return light_tree_probability<Scalar>(tree.view(), p, n, true, light, true);
}
inline double sum_of_probabilities(const LightTree& tree, Vec3f p, Vec3f n) {
  double sum = 0;
  for (std::uint32_t i = 0; i < tree.trails.size(); ++i) sum += probability(tree, p, n, i);
  return sum;
}

}  // namespace sheaf::light_tree_cases
