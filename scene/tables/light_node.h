// A node of a light tree with its four children, packed: choosing a light reads one row for each turn on its way down.
//
// Where and in which directions a child's lights shine is rounded outwards: a light that can shine on a point is never
// lost. Sampling and the probability of what was sampled read the same numbers, so that rounding costs no more than a
// choice that is a little less good.
#pragma once

#include "core/simd.h"
#include "core/vec.h"

#include <cstdint>

namespace sheaf {

struct LightCluster;

inline constexpr int kLightChildren = 4;

/// A node's link: so many bits of an index, and a number of children above.
inline constexpr int kLightNodeBits = 28;
inline constexpr std::uint32_t kLightNodeIndex = (1u << kLightNodeBits) - 1;

/// What kernels know of one child.
template <class L> struct LightChild {
  Vec3<L> center;              ///< of the sphere around the child's box; relative to what the node's middle is
  typename L::Float radius;    ///< of that sphere; contains all lights of the child whatever the rounding
  Vec3<L> tilt;                ///< axis of the cone of normals times minus cos_theta_o, times kLightFixedPoint
  typename L::Float spread;    ///< sine of the half angle of that cone, 1 if it is more than pi / 2; NaN without power
  typename L::Float reach;     ///< 1 - cos_theta_e, see LightBounds; wider by kLightConeSlack
  typename L::Float share;     ///< power over the node's; >= kMinLightShare
  typename L::Uint keep_sign;  ///< all bits but, where some light has two sides, the uppermost
};

/// The factor of numbers in [-1, 1] that are kept as half words.
inline constexpr float kLightFixedPoint = 0x1p31f;
/// By how much cones of emission are widened, in radians: more than single precision errs in the cosines of
/// kernels/lights/light_tree.h, where these graze.
inline constexpr double kLightConeSlack = 2e-3;
/// The smallest share of a light that has any power: far above what would underflow.
inline constexpr float kMinLightShare = 1e-9f;

/// A row of the table of nodes. Most words are two halves, for children 0 and 1, or, in the word after the last one for
/// these, for 2 and 3; the even child's is the lower half. Halves are bfloat16 numbers, or fixed-point numbers. The
/// upper half is to be read with the lower one as more of its digits.
struct alignas(64) LightNodeRow {
  enum Word {
    kMiddle = 0,            ///< x, y, z of a place in the middle of the children; single precision
    kOffset = kMiddle + 3,  ///< x, y, z from there to the children's centres; bfloat16
    kTilt = kOffset + 6,    ///< x, y, z; fixed-point
    kRadius = kTilt + 6,    ///< bfloat16
    kSpread = kRadius + 2,  ///< bfloat16; its sign is set unless some light has two sides
    kShare = kSpread + 2,   ///< bfloat16
    kReach = kShare + 2,    ///< bfloat16
    kLink = kReach + 2,     ///< kLightNodeIndex bits: the child 0 that is a node; above: how many are
    kWordCount
  };
  std::uint32_t words[kWordCount] = {};
  std::uint32_t lights[kLightChildren] = {};  ///< of children that are leaves; 0 where there is no light
  std::uint32_t unused[4] = {};

  /// Children that are nodes come first, and lie side by side.
  std::uint32_t node_count() const { return words[kLink] >> kLightNodeBits; }
};
static_assert(sizeof(LightNodeRow) == 128 && LightNodeRow::kWordCount % 4 == 0);

/// Packs four children, of which the last ones may be without lights. `first_node`: the index of the first child that
/// is a node, of `node_count`. `lights`: see LightNodeRow.
LightNodeRow pack_light_node(const LightCluster (&children)[kLightChildren], std::uint32_t first_node,
                             std::uint32_t node_count, const std::uint32_t (&lights)[kLightChildren]);

/// Child `k` of a node in registers, as its words.
template <class L, int k> SHEAF_INLINE LightChild<L> unpack_light_child(const typename L::Float* words) {
  using F = Float<L>;
  using U = Uint<L>;
  using Row = LightNodeRow;
  constexpr int kSecondPair = k / 2;
  constexpr bool kIsLower = k % 2 == 0;
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
          bfloat(Row::kShare + kSecondPair),
          float_bits(spread) | U(0x7fffffffu)};
}

}  // namespace sheaf
