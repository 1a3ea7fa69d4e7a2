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

/// The bfloat16 number next to a finite one.
std::uint32_t nearest_bfloat(double x) {
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(std::clamp(x, -3e38, 3e38)));
  return (bits + 0x7fffu + (bits >> 16 & 1u)) >> 16;
}
/// `x`: not negative.
std::uint32_t bfloat_above(double x) {
  auto rounded = static_cast<float>(x);
  if (double(rounded) < x) rounded = std::nextafter(rounded, std::numeric_limits<float>::infinity());
  return (std::bit_cast<std::uint32_t>(rounded) + 0xffffu) >> 16;
}
double value_of(std::uint32_t bfloat) { return double(std::bit_cast<float>(bfloat << 16)); }

/// Writes one half of a word; the lower one first.
void set_half(Row& row, int word, std::size_t child, std::uint32_t bits) {
  std::uint32_t& both = row.words[static_cast<std::size_t>(word) + child / 2];
  both = child % 2 == 0 ? bits : both | bits << 16;
}

/// A number in [-1, 1], to a multiple of 2^-15. The upper half of a word takes over what the lower adds to it.
void set_fixed_point(Row& row, int word, std::size_t child, double x) {
  const double lower = child % 2 == 0 ? 0.0 : row.words[static_cast<std::size_t>(word) + child / 2] / 65536.0;
  const double rounded = std::clamp(std::nearbyint(x * 32768.0 - lower), -32768.0, 32767.0);
  set_half(row, word, child, static_cast<std::uint32_t>(static_cast<std::int32_t>(rounded)) & 0xffffu);
}

Vec3d center_of(const LightCluster& cluster) {
  Vec3d center{};
  for (std::size_t c = 0; c < 3; ++c) center[c] = 0.5 * cluster.lower[c] + 0.5 * cluster.upper[c];
  return center;
}

/// In the middle of the children's centres.
Vec3d middle_of(const LightCluster (&children)[kLightChildren]) {
  Vec3d low{LightCluster::kLargest, LightCluster::kLargest, LightCluster::kLargest}, middle{};
  Vec3d high{-low[0], -low[1], -low[2]};
  for (const LightCluster& child : children) {
    if (child.count == 0) continue;
    const Vec3d center = center_of(child);
    for (std::size_t c = 0; c < 3; ++c) {
      low[c] = std::min(low[c], center[c]);
      high[c] = std::max(high[c], center[c]);
      middle[c] = double(static_cast<float>(0.5 * low[c] + 0.5 * high[c]));
    }
  }
  return middle;
}

/// Of a sphere around a cluster, whose centre is near the cluster's own.
double radius_around(const LightCluster& cluster, const Vec3d& center) {
  double squared = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double reach = std::max(cluster.upper[c] - center[c], center[c] - cluster.lower[c]);
    squared += reach * reach;
  }
  constexpr double kOutwards = 1.0 + 0x1p-21;
  return std::min(std::sqrt(squared) * kOutwards, 3e38);
}

/// See LightChild; kernels find cosines from tilts of 16 bits.
double reach_of(const LightCluster& cluster) {
  constexpr double kCosineError = 1e-4;
  return 1.0 - std::cos(std::acos(cluster.cos_theta_e) + kLightConeSlack) + kCosineError;
}

std::uint32_t spread_of(const LightCluster& cluster) {
  constexpr std::uint32_t kNan = 0x7fc0, kSign = 0x8000;
  if (!(cluster.power > 0.0)) return kNan;
  const std::uint32_t spread = bfloat_above(cluster.cone.cos_theta > 0.0 ? cluster.cone.sin_theta : 1.0);
  return cluster.two_sided ? spread : spread | kSign;
}

}  // namespace

LightNodeRow pack_light_node(const LightCluster (&children)[kLightChildren], std::uint32_t first_node,
                             std::uint32_t node_count, const std::uint32_t (&lights)[kLightChildren]) {
  Row row;
  const Vec3d middle = middle_of(children);
  double power = 0;
  for (const LightCluster& child : children) power += child.power;
  for (std::size_t c = 0; c < 3; ++c)
    row.words[Row::kMiddle + c] = std::bit_cast<std::uint32_t>(static_cast<float>(middle[c]));
  for (std::size_t k = 0; k < kLightChildren; ++k) {
    const LightCluster& child = children[k];
    const bool has_lights = child.count > 0;
    const Vec3d wanted = has_lights ? center_of(child) : middle;
    const double cos_theta_o = std::max(child.cone.cos_theta, 0.0);
    Vec3d center{};
    for (int c = 0; c < 3; ++c) {
      const auto axis = static_cast<std::size_t>(c);
      // The words of children 2 and 3 come after all three of 0 and 1.
      const int skipped = k < 2 ? c : c + 2;
      const std::uint32_t offset = nearest_bfloat(wanted[axis] - middle[axis]);
      center[axis] = middle[axis] + value_of(offset);
      set_half(row, Row::kOffset + skipped, k, offset);
      set_fixed_point(row, Row::kTilt + skipped, k, -child.cone.axis[axis] * cos_theta_o);
    }
    set_half(row, Row::kRadius, k, has_lights ? bfloat_above(radius_around(child, center)) : 0u);
    set_half(row, Row::kSpread, k, spread_of(child));
    const double share = child.power > 0.0 ? child.power / power : 1.0;
    set_half(row, Row::kShare, k, nearest_bfloat(std::max(share, double(kLeastLightShare))));
    set_half(row, Row::kReach, k, bfloat_above(reach_of(child)));
    row.lights[k] = lights[k];
  }
  row.words[Row::kLink] = first_node | node_count << 28;
  return row;
}

}  // namespace sheaf
