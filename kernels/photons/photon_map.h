// Photon maps: photons in blocks of 16 along a Hilbert curve, below a tree of bounding boxes, for lookups around a
// point.
//
// Node i of level 0 is block i; node i of level l + 1 encloses nodes 16 i to 16 i + 15 of level l, a group. So the tree
// needs no pointers, and the boxes of a group are tested in registers.
//
// The map is compact, because lookups of final gathering are far from each other and find little in the caches. Boxes
// are stored relative to the box of their group, in 8 bits and rounded outwards, as in compressed wide BVHs (Ylitie,
// Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", 2017). Positions are
// stored relative to the box of the group, and powers relative to the largest component in the block, both in 16 bits
// and rounded to the nearest. kernels/photons/photon_search.h searches maps.
#pragma once

#include "core/soa/large_table.h"
#include "kernels/photons/photon.h"
#include "scene/tables/scene_view.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sheaf {

/// Photons per block, and nodes per group.
inline constexpr std::uint32_t kPhotonBlock = 16;
static_assert(kPhotonBlock % kWidth == 0);

/// Steps of boxes along the sides of a group's box, and of positions and powers. Boxes begin and end at steps of
/// positions.
inline constexpr float kBoxSteps = 255, kPhotonSteps = 65535;

/// The boxes of the nodes of a group.
struct alignas(kSimdAlignment) PhotonGroup {
  float low[3], step[3];                ///< lower corner of the group's box, and a step along its sides; world space, m
  std::uint32_t count;                  ///< number of nodes
  std::uint32_t one_sided;              ///< level 0, bit i: all photons of block i arrive on the side of its normal
  std::uint8_t boxes[6][kPhotonBlock];  ///< lower and upper corners of the nodes, in steps

  /// One step of positions along an axis, m.
  SHEAF_INLINE float position_step(int axis) const { return step[axis] * (kBoxSteps / kPhotonSteps); }
};

/// The nodes of level 0.
struct PhotonBlockGroup : PhotonGroup {
  /// The normal of all photons of a block and the longest path, as photon_surface(), with kMixedNormals if normals
  /// differ or photons are missing.
  std::uint32_t surfaces[kPhotonBlock];
  float power_steps[kPhotonBlock];  ///< one step of the powers in a block, W
  float powers[4][kPhotonBlock];    ///< sums over the photons of a block, W
};
inline constexpr std::uint32_t kMixedNormals = kPhotonSingleWavelength;

/// Minimum cosine between directions and the normal of a one-sided block.
inline constexpr float kOneSidedCosine = 0.02f;

/// The 16-bit columns of a block are x, y, z and three or four powers. The octahedral directions follow, towards the
/// previous vertex.
inline constexpr std::uint32_t kPhotonColumnBytes = kPhotonBlock * sizeof(std::uint16_t);
/// Offset of the directions, in bytes.
constexpr std::uint32_t photon_directions_offset(std::uint32_t powers) {
  return ((3 + powers) * kPhotonColumnBytes + 63u) / 64u * 64u;
}
constexpr std::uint32_t photon_block_bytes(std::uint32_t powers) {
  return photon_directions_offset(powers) + kPhotonBlock * static_cast<std::uint32_t>(sizeof(std::uint32_t));
}

/// Upper bound on the number of levels, for 2^32 photons.
inline constexpr int kMaxPhotonLevels = 8;

/// A photon map as kernels read it.
struct PhotonMapView {
  const std::byte* blocks = nullptr;                             ///< aligned to kSimdAlignment
  const PhotonBlockGroup* block_groups = nullptr;                ///< level 0
  std::array<const PhotonGroup*, kMaxPhotonLevels> groups = {};  ///< by level, from level 1 on
  const std::uint32_t* surfaces = nullptr;                       ///< see photon_surface(); aligned to kSimdAlignment
  int levels = 0;                                                ///< the last one is a single group
  std::uint32_t size = 0;                                        ///< photons
  std::uint32_t powers = 4;                                      ///< columns of powers
  float radius = 0;                                              ///< meters
  PhotonKernel kernel = PhotonKernel::kDisc;
  int lookup_size = 0;  ///< see PhotonMappingSettings

  bool empty() const { return size == 0; }
  const std::byte* block(std::uint32_t i) const { return blocks + std::size_t{i} * photon_block_bytes(powers); }
  /// Column k of a block: x, y, z, powers.
  const std::uint16_t* column(std::uint32_t i, std::uint32_t k) const {
    return reinterpret_cast<const std::uint16_t*>(block(i) + k * kPhotonColumnBytes);
  }
  const std::uint32_t* directions(std::uint32_t i) const {
    return reinterpret_cast<const std::uint32_t*>(block(i) + photon_directions_offset(powers));
  }
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
  UninitializedLargeTable<std::byte> blocks_;
  UninitializedLargeTable<std::uint32_t> surfaces_;
  UninitializedLargeTable<PhotonBlockGroup> block_groups_;
  std::vector<UninitializedLargeTable<PhotonGroup>> groups_;  ///< from level 1 on
  float radius_ = 0;
  PhotonKernel kernel_ = PhotonKernel::kDisc;
  int lookup_size_ = 0;
  bool four_lanes_ = true;
};

}  // namespace sheaf
