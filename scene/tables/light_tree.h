// A light tree over the lights of a scene, from which kernels select a light by its importance at a point
// (kernels/lights/light_tree.h; PBR 12.6).
//
// Follows Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting" (HPG 2018),
// without the splitting: boxes, cones of directions and powers of lights are joined from the leaves to the root. Nodes
// have four children. This halves the depth of a binary tree, and each child is chosen by its own bounds.
#pragma once

#include "core/math/vec.h"
#include "core/soa/large_table.h"
#include "scene/tables/light_node.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sheaf {

/// Bounds of a light's position, emission directions and power (Conty Estevez and Kulla 2018, section 4.1).
struct LightBounds {
  Vec3f lower{}, upper{};  ///< box around the light; world space, meters
  Vec3f axis{0, 0, 1};     ///< of the cone of normals; unit length
  float cos_theta_o = -1;  ///< cosine of the half angle of that cone; angle in [0, pi]
  float cos_theta_e = 0;  ///< cosine of the maximum angle between a normal and an emitted direction; angle in [0, pi/2]
  /// pi times the radiant intensity (W / sr) in the brightest direction, averaged over R, G and B. This is the power in
  /// W of a flat emitter and a quarter of that of a point light, and is comparable between all kinds of lights. 0:
  /// never chosen.
  float power = 0;
  bool two_sided = false;  ///< also emits on the side opposite to the normals
};

/// A position in the tree: the index of a node, or, with this bit set, 4 * node + child for a leaf.
inline constexpr std::uint32_t kLightLeaf = 0x80000000u;
/// Maximum depth of the tree: a leaf is identified by that many branches of two bits each.
inline constexpr int kMaxLightTreeDepth = 16;

/// The upper levels of a tree, which the candidates of a vertex may share, and the nodes below them. Node h of the
/// complete tree has the children 4 h + 1 to 4 h + 4.
inline constexpr int kLightCutLevels = 2, kLightCutNodes = 1 + kLightChildren;
inline constexpr int kLightCutPositions = kLightChildren * kLightCutNodes + 1;

/// Position of a child of `node`, whose index is `index`.
inline std::uint32_t light_tree_child(const LightNodeRow& node, std::uint32_t index, std::uint32_t child) {
  const bool is_leaf = child >= node.node_count();
  return is_leaf ? kLightLeaf | (kLightChildren * index + child)
                 : (node.words[LightNodeRow::kLink] & kLightNodeIndex) + child;
}

/// The children of a node, unpacked.
class LightChildren {
 public:
  explicit LightChildren(const LightNodeRow& node);
  const LightChild<Scalar>& operator[](std::uint32_t k) const { return children_[k]; }

 private:
  LightChild<Scalar> children_[kLightChildren];
};

/// A group of lights that rays aim at; see kernels/guiding/glow_lobes.h.
struct GlowSource {
  Vec3f center{};    ///< of the bounding sphere; world space
  float radius = 0;  ///< m
  float power = 0;   ///< as a fraction of all lights in the tree
};
/// The sources: the nodes and leaves that this many levels of a tree end in.
inline constexpr int kGlowLevels = 2;
inline constexpr int kMaxGlowSources = kLightChildren * kLightChildren;

/// Light tree for kernels.
struct LightTreeView {
  const LightNodeRow* nodes = nullptr;    ///< the first is the root
  const std::uint32_t* trails = nullptr;  ///< one per light: bits 2 k and 2 k + 1 are the branch at level k
  std::uint32_t node_count = 0;           ///< 0: no lights
  /// Positions of the upper nodes. Below a leaf, the position of that leaf is repeated.
  std::uint32_t cut_nodes[kLightCutPositions] = {};
  GlowSource glow_sources[kMaxGlowSources] = {};  ///< those with power
  int glow_source_count = 0;
};

/// Owns a light tree.
struct LightTree {
  LargeTable<LightNodeRow> nodes;     ///< empty without lights
  std::vector<std::uint32_t> trails;  ///< see LightTreeView
  int depth = 0;                      ///< number of levels; at most kMaxLightTreeDepth

  LightTreeView view() const;
};

/// Builds the tree over `lights` in O(n log n) for any positions. The result is deterministic. Powers that are not
/// positive count as 0. Throws SceneError for a box, axis or cone that is not finite, and for more than 2^28 - 1
/// lights.
LightTree build_light_tree(std::span<const LightBounds> lights);

}  // namespace sheaf
