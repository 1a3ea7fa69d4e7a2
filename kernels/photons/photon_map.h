// Photon maps: photons in blocks of 16 along a Hilbert curve, below a tree of bounding boxes, for lookups around a
// point.
//
// Node i of level 0 is block i; node i of level l + 1 encloses nodes 16 i to 16 i + 15 of level l, a group. So the tree
// needs no pointers, and the boxes of a group are tested in registers.
//
// The map is compact, because lookups of final gathering are far from each other and find little in the caches. Boxes
// are stored relative to the box of their group, in 8 bits and rounded outwards, as in compressed wide BVHs (Ylitie,
// Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017). Positions are
// stored relative to the box of the block, and powers relative to the largest component in the block, each in one word
// per photon. Positions are rounded to the nearest step, and powers so that their sums are unbiased.
// kernels/photons/photon_search.h searches maps.
#pragma once

#include "core/soa/large_table.h"
#include "kernels/photons/photon.h"
#include "scene/tables/scene_view.h"

#include <array>
#include <cstdint>
#include <vector>

namespace sheaf {

/// Photons per block, and nodes per group.
inline constexpr std::uint32_t kPhotonBlock = 16;
static_assert(kPhotonBlock % kWidth == 0);

/// Steps of boxes along the sides of a group's box.
inline constexpr float kBoxSteps = 255;

/// An unsigned integer in some bits of a 32-bit word.
struct PhotonField {
  int shift;
  std::uint32_t max;

  template <class U> SHEAF_INLINE U of(U word) const { return (word >> shift) & U(max); }
};

/// Coordinates of photons along the sides of the block's box.
inline constexpr PhotonField kPhotonPosition[3] = {{0, 2047}, {11, 2047}, {22, 1023}};
/// Component `k` of `powers` in a photon's power.
SHEAF_INLINE PhotonField photon_power(std::uint32_t powers, int k) {
  return powers == 3 ? PhotonField{10 * k, 1023} : PhotonField{8 * k, 255};
}

/// A block of photons: a cache line for each column.
struct alignas(64) PhotonBlock {
  std::uint32_t positions[kPhotonBlock];   ///< see kPhotonPosition
  std::uint32_t powers[kPhotonBlock];      ///< see photon_power()
  std::uint32_t directions[kPhotonBlock];  ///< octahedral; towards the previous vertex
  std::uint32_t surfaces[kPhotonBlock];    ///< see photon_surface()
};

/// The boxes of the nodes of a group.
struct alignas(kSimdAlignment) PhotonGroup {
  float low[3], step[3];                ///< lower corner of the group's box, and a step along its sides; world space, m
  std::uint32_t count;                  ///< number of nodes
  std::uint32_t one_sided;              ///< level 0, bit i: all photons of block i arrive on the side of its normal
  std::uint8_t boxes[6][kPhotonBlock];  ///< lower and upper corners of the nodes, in steps

  /// Lower corner of a node's box along an axis, m from `origin`.
  SHEAF_INLINE float low_of(std::uint32_t node, int axis, float origin) const {
    return fma(static_cast<float>(boxes[axis][node]), step[axis], low[axis] - origin);
  }
  /// One step of positions in a block along an axis, m.
  SHEAF_INLINE float position_step(std::uint32_t node, int axis) const {
    return static_cast<float>(boxes[axis + 3][node] - boxes[axis][node]) * step[axis] *
           (1.0f / static_cast<float>(kPhotonPosition[axis].max));
  }
};

/// The nodes of level 0.
struct PhotonBlockGroup : PhotonGroup {
  /// The normal of all photons of a block and the longest path, as photon_surface(), with kMixedNormals if normals
  /// differ or photons are missing.
  std::uint32_t surfaces[kPhotonBlock];
  std::uint16_t power_steps[kPhotonBlock];  ///< one step of the powers in a block, W: the high half of a float
  std::uint16_t powers[4][kPhotonBlock];    ///< sums over the photons of a block, in steps

  SHEAF_INLINE float power_step(std::uint32_t node) const {
    return bits_float(static_cast<std::uint32_t>(power_steps[node]) << 16);
  }
};
inline constexpr std::uint32_t kMixedNormals = kPhotonSingleWavelength;

/// Minimum cosine between directions and the normal of a one-sided block.
inline constexpr float kOneSidedCosine = 0.02f;

/// Upper bound on the number of levels, for 2^32 photons.
inline constexpr int kMaxPhotonLevels = 8;

/// A photon map as kernels read it.
struct PhotonMapView {
  const PhotonBlock* blocks = nullptr;
  const PhotonBlockGroup* block_groups = nullptr;                ///< level 0
  std::array<const PhotonGroup*, kMaxPhotonLevels> groups = {};  ///< by level, from level 1 on
  int levels = 0;                                                ///< the last one is a single group
  std::uint32_t size = 0;                                        ///< photons
  std::uint32_t powers = 4;                                      ///< components of powers, 3 or 4
  float radius = 0;                                              ///< meters
  PhotonKernel kernel = PhotonKernel::kDisc;
  int lookup_size = 0;  ///< see PhotonMappingSettings

  bool empty() const { return size == 0; }
  const PhotonBlockGroup& group_of(std::uint32_t block) const { return block_groups[block / kPhotonBlock]; }

  /// Photon i as stored, for tests. Its order is 0.
  Photon photon(std::uint32_t i) const;
};

/// Owns the blocks and the tree. Immutable.
class PhotonMap {
 public:
  PhotonMap() = default;
  /// Takes the photons of all tasks, in order. `emitted`: number of emitted photons; `radius`: in meters, positive;
  /// `four_lanes`: whether powers have a fourth lane. Built by all threads; the map does not depend on their number.
  PhotonMap(const std::vector<std::vector<Photon>>& tasks, std::uint64_t emitted, float radius, PhotonKernel kernel,
            int lookup_size = 0, bool four_lanes = true);

  PhotonMapView view() const;
  std::size_t size() const { return size_; }
  std::size_t bytes() const;

 private:
  std::uint32_t powers() const { return four_lanes_ ? 4 : 3; }

  std::size_t size_ = 0;
  UninitializedLargeTable<PhotonBlock> blocks_;
  UninitializedLargeTable<PhotonBlockGroup> block_groups_;
  std::vector<UninitializedLargeTable<PhotonGroup>> groups_;  ///< from level 1 on
  float radius_ = 0;
  PhotonKernel kernel_ = PhotonKernel::kDisc;
  int lookup_size_ = 0;
  bool four_lanes_ = true;
};

}  // namespace sheaf
