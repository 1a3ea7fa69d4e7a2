#include "scene/tables/light_node.h"

#include "scene/tables/light_cluster.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>

namespace sheaf {

namespace {

using Row = LightNodeRow;

constexpr std::uint32_t kHalf = 0xffffu;

/// One half of a row's words. Even children use the lower halves, which must be written first.
struct Half {
  std::uint32_t& word;
  bool is_upper;

  Half(Row& row, int first, std::size_t child)
      : word(row.words[static_cast<std::size_t>(first) + child / 2]), is_upper(child % 2 != 0) {}

  void set(std::uint32_t bits) const { word = is_upper ? (word & kHalf) | bits << 16 : bits; }
  /// The number that kernels read if the half is `bits`, a bfloat16.
  float value(std::uint32_t bits) const { return std::bit_cast<float>(bits << 16 | (is_upper ? word & kHalf : 0u)); }
};

/// Writes the bfloat16 nearest to a finite number, and returns it.
double set_nearest(const Half& half, double x) {
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(std::clamp(x, -3e38, 3e38))) >> 16;
  std::uint32_t best = bits;
  // `bits` is rounded towards zero: it may be too small by one, or too large with the digits of the lower half.
  for (const std::uint32_t other : {bits + 1, bits - 1}) {
    if ((other ^ bits) >> 15 != 0 || !std::isfinite(half.value(other))) continue;
    if (std::fabs(double(half.value(other)) - x) < std::fabs(double(half.value(best)) - x)) best = other;
  }
  half.set(best);
  return double(half.value(best));
}

/// Bits of the smallest bfloat16 not below `x` >= 0. Avoids denormal numbers, which are slow to multiply.
std::uint32_t bits_above(const Half& half, double x) {
  if (half.is_upper) x = std::max(x, double(std::numeric_limits<float>::min()));
  std::uint32_t bits = std::bit_cast<std::uint32_t>(static_cast<float>(x)) >> 16;
  while (double(half.value(bits)) < x) ++bits;
  return bits;
}

/// Writes a number in [-1, 1] as a multiple of 2^-15. The upper half compensates for the digits that the lower half
/// adds.
void set_fixed_point(Row& row, int word, std::size_t child, double x) {
  const Half half(row, word, child);
  const double lower = half.is_upper ? half.word / 65536.0 : 0.0;
  const double rounded = std::clamp(std::nearbyint(x * 32768.0 - lower), -32768.0, 32767.0);
  half.set(static_cast<std::uint32_t>(static_cast<std::int32_t>(rounded)) & kHalf);
}

Triple center_of(const LightCluster& cluster) {
  Triple center{};
  for (std::size_t c = 0; c < 3; ++c) center[c] = 0.5 * cluster.lower[c] + 0.5 * cluster.upper[c];
  return center;
}

/// Midpoint of the bounds of the children's centers.
Triple middle_of(const LightCluster (&children)[kLightChildren]) {
  Triple low{LightCluster::kLargest, LightCluster::kLargest, LightCluster::kLargest}, middle{};
  Triple high{-low[0], -low[1], -low[2]};
  for (const LightCluster& child : children) {
    if (child.count == 0) continue;
    const Triple center = center_of(child);
    for (std::size_t c = 0; c < 3; ++c) {
      low[c] = std::min(low[c], center[c]);
      high[c] = std::max(high[c], center[c]);
      middle[c] = double(static_cast<float>(0.5 * low[c] + 0.5 * high[c]));
    }
  }
  return middle;
}

/// Radius of a sphere around a cluster, with a center close to the cluster's own.
double radius_around(const LightCluster& cluster, const Triple& center) {
  double squared = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double reach = std::max(cluster.upper[c] - center[c], center[c] - cluster.lower[c]);
    squared += reach * reach;
  }
  constexpr double kOutwards = 1.0 + 0x1p-21;
  return std::min(std::sqrt(squared) * kOutwards, 3e38);
}

/// See LightChild. Kernels compute cosines from 16-bit tilts, so an error bound is added.
double reach_of(const LightCluster& cluster) {
  constexpr double kCosineError = 1e-4;
  return 1.0 - std::cos(std::acos(cluster.cos_theta_e) + kLightConeSlack) + kCosineError;
}

void set_spread(const Half& half, const LightCluster& cluster) {
  constexpr std::uint32_t kNan = 0x7fc0, kSign = 0x8000;
  if (!(cluster.power > 0.0)) return half.set(kNan);
  const std::uint32_t spread = bits_above(half, cluster.cone.cos_theta > 0.0 ? cluster.cone.sin_theta : 1.0);
  half.set(cluster.two_sided ? spread : spread | kSign);
}

}  // namespace

LightNodeRow pack_light_node(const LightCluster (&children)[kLightChildren], std::uint32_t first_node,
                             std::uint32_t node_count, const std::uint32_t (&lights)[kLightChildren]) {
  Row row;
  const Triple middle = middle_of(children);
  double power = 0;
  for (const LightCluster& child : children) power += child.power;
  for (std::size_t c = 0; c < 3; ++c)
    row.words[Row::kMiddle + c] = std::bit_cast<std::uint32_t>(static_cast<float>(middle[c]));
  for (std::size_t k = 0; k < kLightChildren; ++k) {
    const LightCluster& child = children[k];
    const bool has_lights = child.count > 0;
    const Triple requested = has_lights ? center_of(child) : middle;
    const double cos_theta_o = std::max(child.cone.cos_theta, 0.0);
    Triple center{};
    for (int c = 0; c < 3; ++c) {
      const auto axis = static_cast<std::size_t>(c);
      // The words of children 2 and 3 come after all three of 0 and 1.
      const int skipped = k < 2 ? c : c + 2;
      center[axis] = middle[axis] + set_nearest({row, Row::kOffset + skipped, k}, requested[axis] - middle[axis]);
      set_fixed_point(row, Row::kTilt + skipped, k, -child.cone.axis[axis] * cos_theta_o);
    }
    const Half radius(row, Row::kRadius, k), reach(row, Row::kReach, k);
    radius.set(has_lights ? bits_above(radius, radius_around(child, center)) : 0u);
    reach.set(bits_above(reach, reach_of(child)));
    set_spread({row, Row::kSpread, k}, child);
    const double power_fraction = child.power > 0.0 ? child.power / power : 1.0;
    set_nearest({row, Row::kPowerFraction, k}, std::max(power_fraction, double(kMinPowerFraction)));
    row.lights[k] = lights[k];
  }
  row.words[Row::kLink] = first_node | node_count << kLightNodeBits;
  return row;
}

}  // namespace sheaf
