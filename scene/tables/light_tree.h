// A hierarchy over the lights of a scene, from which kernels pick one that matters at a point
// (kernels/lights/light_tree.h).
//
// After Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting" (HPG 2018), without
// the splitting: boxes, cones of directions and powers of lights, joined from the leaves to the root. Nodes have four
// children: half the turns of two, and each is chosen by what is known of the children themselves.
#pragma once

#include "core/large_table.h"
#include "core/vec.h"
#include "scene/tables/light_node.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sheaf {

/// Where a light is, in which directions it shines, and how much (Conty Estevez and Kulla 2018, section 4.1).
struct LightBounds {
  Vec3f lower{}, upper{};  ///< box around the light; world space, metres
  Vec3f axis{0, 0, 1};     ///< of the cone of normals; unit length
  float cos_theta_o = -1;  ///< half angle of that cone, in [0, pi]
  float cos_theta_e = 0;   ///< how far from a normal the light still shines: half angle in [0, pi/2]
  /// pi times the radiant intensity (W / sr) in the brightest direction, averaged over R, G and B: so a flat emitter's
  /// power in W, a quarter of that of a point light, and comparable among all kinds of light. 0: never chosen.
  float power = 0;
  bool two_sided = false;  ///< shines against its normals as well
};

/// A place in the tree: the index of a node, or, with this bit, four times that and which of its children, a leaf.
inline constexpr std::uint32_t kLightLeaf = 0x80000000u;
/// The depth of a tree: its leaves are told apart by that many turns, two bits each.
inline constexpr int kMaxLightTreeDepth = 16;

/// The upper levels of a tree, which many candidates of a vertex may share, and the nodes at their ends: node h of a
/// complete tree has the children 4 h + 1 to 4 h + 4.
inline constexpr int kLightTopLevels = 2, kLightTopTurns = 1 + kLightChildren;
inline constexpr int kLightTopNodes = kLightChildren * kLightTopTurns + 1;

/// The place of a child of node `index`, which is `node`.
inline std::uint32_t light_tree_child(const LightNodeRow& node, std::uint32_t index, std::uint32_t child) {
  const bool is_leaf = child >= node.node_count();
  return is_leaf ? kLightLeaf | (kLightChildren * index + child)
                 : (node.words[LightNodeRow::kLink] & kLightNodeIndex) + child;
}

/// What kernels see of a light tree.
struct LightTreeView {
  const LightNodeRow* nodes = nullptr;    ///< the first is the root
  const std::uint32_t* trails = nullptr;  ///< one per light: bits 2 k and 2 k + 1 are the turn at level k
  std::uint32_t node_count = 0;           ///< 0: there are no lights
  /// Places of the upper nodes; where there is none, since one above is a leaf, the place of that one.
  std::uint32_t top[kLightTopNodes] = {};
};

/// Owns a light tree.
struct LightTree {
  LargeTable<LightNodeRow> nodes;     ///< none without lights
  std::vector<std::uint32_t> trails;  ///< see LightTreeView
  int depth = 0;                      ///< longest way from the root to a leaf; at most kMaxLightTreeDepth

  LightTreeView view() const;
};

/// The tree over `lights`, in O(n log n) whatever their places. The same lights give the same tree always. Powers that
/// are not positive count as 0. Throws SceneError for a box, axis or cone that is not finite and for more than 2^28
/// lights.
LightTree build_light_tree(std::span<const LightBounds> lights);

}  // namespace sheaf
