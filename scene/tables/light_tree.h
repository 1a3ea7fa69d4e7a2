// A hierarchy over the lights of a scene, from which kernels pick one that matters at a point
// (kernels/lights/light_tree.h).
//
// After Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting" (HPG 2018), without
// the splitting: boxes, cones of directions and powers of lights, joined from the leaves to the root.
#pragma once

#include "core/large_table.h"
#include "core/record_table.h"
#include "core/vec.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sheaf {

/// Where a light is, in which directions it shines, and how much (Conty Estevez and Kulla 2018, section 4.1).
struct LightBounds {
  Vec3f lower{}, upper{};       ///< box around the light; world space, metres
  Vec3f axis{0, 0, 1};          ///< of the cone of normals; unit length
  float cos_theta_o = -1;       ///< half angle of that cone, in [0, pi]
  float cos_theta_e = 0;        ///< how far from a normal the light still shines: half angle in [0, pi/2]
  /// pi times the radiant intensity (W / sr) in the brightest direction, averaged over R, G and B: so a flat emitter's
  /// power in W, a quarter of that of a point light, and comparable among all kinds of light. 0: never chosen.
  float power = 0;
  bool two_sided = false;       ///< shines against its normals as well
};

/// What the kernels read of a node.
template <class L> struct LightNode {
  Vec3<L> center;               ///< of the sphere around the node's box
  typename L::Float radius{};   ///< of that sphere; contains all lights of the node whatever the rounding
  Vec3<L> tilt;                 ///< axis of the cone of normals times cos_theta_o; zero if that is negative
  typename L::Float spread{};   ///< sine of the half angle of that cone; 1 if it is more than pi / 2
  typename L::Float
      share{};  ///< power over the power of the node and its sibling; 0 if there is none, else >= kLeastShare
  typename L::Float cos_theta_e{};  ///< see LightBounds; wider by kLightConeSlack
  typename L::Uint link{};      ///< index of the first child, or kLightLeaf and the light; with kLightTwoSided

  static constexpr auto fields(auto& s) {
    return std::tie(s.center, s.radius, s.tilt, s.spread, s.share, s.cos_theta_e, s.link);
  }
};

/// A row of the table of nodes: one cache line. The two children of a node stand next to each other and are read
/// together, so a node refers to its first child.
struct alignas(64) LightNodeRow : LightNode<Scalar> {
  float power = 0;  ///< of all lights of the node; for people and tests, as the next two
  std::uint32_t light_count = 0;
  std::uint32_t unused[3] = {};
};
static_assert(sizeof(LightNodeRow) == 64);

/// Bits of LightNodeRow::link.
inline constexpr std::uint32_t kLightLeaf = 0x80000000u, kLightTwoSided = 0x40000000u, kLightIndex = 0x3fffffffu;
/// The depth of a tree: its leaves are told apart by that many turns, one bit each.
inline constexpr int kMaxLightTreeDepth = 32;
/// The smallest share of a light that has any power: far above what would underflow.
inline constexpr float kLeastShare = 1e-9f;
/// By how much cones of emission are widened, in radians: more than single precision errs in the cosines of
/// kernels/lights/light_tree.h, where these graze.
inline constexpr double kLightConeSlack = 2e-3;

/// The upper levels of a tree, which many candidates of a vertex may share, and the nodes at their ends: node h of a
/// complete tree has the children 2 h + 1 and 2 h + 2.
inline constexpr int kLightTopLevels = 5, kLightTopPairs = (1 << kLightTopLevels) - 1;
inline constexpr int kLightTopNodes = 2 * kLightTopPairs + 1;

/// What kernels see of a light tree.
struct LightTreeView {
  const LightNodeRow* nodes = nullptr;      ///< pairs of siblings; the first pair are the children of the root
  const std::uint32_t* trails = nullptr;    ///< one per light: bit k is the turn at level k, 1 for the second child
  std::uint32_t node_count = 0;             ///< 0: there are no lights
  /// Links of the upper nodes; where there is none, since one above is a leaf, the link of that one.
  std::uint32_t top[kLightTopNodes] = {};
};

/// Owns a light tree.
struct LightTree {
  LargeTable<LightNodeRow> nodes;     ///< empty without lights; 2 (n - 1) of them for n > 1 lights, 2 for one
  std::vector<std::uint32_t> trails;  ///< see LightTreeView
  int depth = 0;                      ///< longest way from the root to a leaf; at most kMaxLightTreeDepth

  LightTreeView view() const;
};

/// The tree over `lights`, in O(n log n) whatever their places. The same lights give the same tree always. Powers that
/// are not positive count as 0. Throws SceneError for a box, axis or cone that is not finite and for more than 2^30
/// lights.
LightTree build_light_tree(std::span<const LightBounds> lights);

}  // namespace sheaf
