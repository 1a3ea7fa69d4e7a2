// A packed light tree node with its four children. Choosing a light reads one row per level of the tree.
//
// Bounds of a child's position and directions are rounded outwards, so no light that can illuminate a point is ever
// missed. Sampling and pdf evaluation read the same numbers, so rounding only makes the choice slightly less accurate.
#pragma once

#include "core/math/vec.h"
#include "core/simd/simd.h"

#include <cstdint>

namespace sheaf {

struct LightCluster;

inline constexpr int kLightChildren = 4;

/// Bits for the index in a node's link; the number of child nodes is stored above them.
inline constexpr int kLightNodeBits = 28;
inline constexpr std::uint32_t kLightNodeIndex = (1u << kLightNodeBits) - 1;

/// One child as seen by kernels.
template <class L> struct LightChild {
  Vec3<L> center;  ///< center of the bounding sphere of the child's box, in the coordinates of the node's middle
  typename L::Float radius;          ///< radius of that sphere; contains all lights of the child in spite of rounding
  Vec3<L> tilt;                      ///< axis of the cone of normals times -cos_theta_o, times kLightFixedPoint
  typename L::Float spread;          ///< sine of the half angle of that cone, 1 beyond pi / 2; NaN if the power is 0
  typename L::Float reach;           ///< 1 - cos_theta_e, see LightBounds; widened by kLightConeSlack
  typename L::Float power_fraction;  ///< power over that of the node; >= kMinPowerFraction
  typename L::Uint keep_sign;        ///< all bits set; without the sign bit if a light is two-sided
};

/// Factor of the fixed-point numbers in [-1, 1].
inline constexpr float kLightFixedPoint = 0x1p31f;
/// Widening of the cones of emission, in radians. Exceeds the single-precision errors of the cosines in
/// kernels/lights/light_tree.h at grazing angles.
inline constexpr double kLightConeSlack = 2e-3;
/// Minimum power fraction of a light with power > 0; far above underflow.
inline constexpr float kMinPowerFraction = 1e-9f;

/// A row of the table of nodes. Most words hold two halves: for children 0 and 1, or, in the following words, for
/// children 2 and 3. The even child uses the lower half. Halves are bfloat16 or fixed-point numbers. The upper half is
/// read with the lower half as additional digits.
struct alignas(64) LightNodeRow {
  enum Word {
    kMiddle = 0,                   ///< x, y, z of a point in the middle of the children; single precision
    kOffset = kMiddle + 3,         ///< x, y, z from there to the children's centers; bfloat16
    kTilt = kOffset + 6,           ///< x, y, z; fixed-point
    kRadius = kTilt + 6,           ///< bfloat16
    kSpread = kRadius + 2,         ///< bfloat16; the sign is set unless a light is two-sided
    kPowerFraction = kSpread + 2,  ///< bfloat16
    kReach = kPowerFraction + 2,   ///< bfloat16
    kLink = kReach + 2,            ///< kLightNodeBits bits: index of the first child node; above: number of child nodes
    kWordCount
  };
  std::uint32_t words[kWordCount] = {};
  std::uint32_t lights[kLightChildren] = {};  ///< light indices of children that are leaves; 0 if empty
  std::uint32_t unused[4] = {};

  /// Number of children that are nodes. They come first and are consecutive in the table.
  std::uint32_t node_count() const { return words[kLink] >> kLightNodeBits; }
};
static_assert(sizeof(LightNodeRow) == 128 && LightNodeRow::kWordCount % 4 == 0);

/// Packs four children; trailing ones may be empty. `first_node` is the index of the first of `node_count` child nodes.
/// `lights`: see LightNodeRow.
LightNodeRow pack_light_node(const LightCluster (&children)[kLightChildren], std::uint32_t first_node,
                             std::uint32_t node_count, const std::uint32_t (&lights)[kLightChildren]);

/// Unpacks child `kChild` of a node from the node's words in registers.
template <class L, int kChild> SHEAF_INLINE LightChild<L> unpack_light_child(const typename L::Float* words) {
  using F = Float<L>;
  using U = Uint<L>;
  using Row = LightNodeRow;
  constexpr int kSecondPair = kChild / 2;
  constexpr bool kIsLower = kChild % 2 == 0;
  const auto bfloat = [words](int word) SHEAF_LAMBDA_INLINE {
    const U bits = float_bits(words[word]);
    return bits_float(kIsLower ? bits << 16 : bits);
  };
  const auto fixed_point = [words](int word) SHEAF_LAMBDA_INLINE {
    const U bits = float_bits(words[word]);
    return to_float(kIsLower ? bits << 16 : bits);
  };
  constexpr int kOffset = Row::kOffset + 3 * kSecondPair, kTilt = Row::kTilt + 3 * kSecondPair;
  const F spread = bfloat(Row::kSpread + kSecondPair);
  return {{words[Row::kMiddle] + bfloat(kOffset), words[Row::kMiddle + 1] + bfloat(kOffset + 1),
           words[Row::kMiddle + 2] + bfloat(kOffset + 2)},
          bfloat(Row::kRadius + kSecondPair),
          {fixed_point(kTilt), fixed_point(kTilt + 1), fixed_point(kTilt + 2)},
          abs(spread),
          bfloat(Row::kReach + kSecondPair),
          bfloat(Row::kPowerFraction + kSecondPair),
          float_bits(spread) | U(0x7fffffffu)};
}

}  // namespace sheaf
