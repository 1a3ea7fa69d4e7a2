// Construction of photon maps: sorts the photons, fills the blocks, and builds the tree above them, in parallel.
#include "kernels/photons/photon_map.h"

#include "core/sampling/octahedral.h"
#include "core/simd/prefetch.h"
#include "kernels/photons/photon_order.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Size of the cells of the curve, in lookup radii. Photons closer than that need no order.
constexpr float kCellOfRadius = 0.125f;

constexpr std::size_t divide_up(std::size_t a, std::size_t b) { return (a + b - 1) / b; }

template <class F> void in_parallel(std::size_t count, F&& f) {
  constexpr std::size_t kGrain = 32;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i) f(i);
                    });
}

/// A bounding box; empty at first.
struct Box {
  float low[3] = {kInfinity, kInfinity, kInfinity}, high[3] = {-kInfinity, -kInfinity, -kInfinity};

  void add(const Box& box) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = min(low[axis], box.low[axis]);
      high[axis] = max(high[axis], box.high[axis]);
    }
  }
  void add(Vec3f p) { add(Box{{p.x, p.y, p.z}, {p.x, p.y, p.z}}); }
};

/// Sets the boxes of a group.
void set_boxes(PhotonGroup& group, const Box* nodes, std::size_t count) {
  Box all;
  for (std::size_t i = 0; i < count; ++i) all.add(nodes[i]);
  group.count = static_cast<std::uint32_t>(count);
  for (int axis = 0; axis < 3; ++axis) {
    // Rounding must not exclude the upper side
    const float low = group.low[axis] = all.low[axis];
    float& step = group.step[axis] = all.high[axis] / kBoxSteps - low / kBoxSteps;
    while (fma(kBoxSteps, step, low) < all.high[axis]) step = std::nextafter(step, kInfinity);
    const auto steps_to = [&](float x) { return step > 0.0f ? clamp((x - low) / step, 0.0f, kBoxSteps) : 0.0f; };
    for (std::size_t i = 0; i < kPhotonBlock; ++i) {
      float lower = 0, upper = 0;
      if (i < count) {
        lower = std::floor(steps_to(nodes[i].low[axis])), upper = std::ceil(steps_to(nodes[i].high[axis]));
        if (fma(lower, step, low) > nodes[i].low[axis]) lower = max(lower - 1, 0.0f);
        if (fma(upper, step, low) < nodes[i].high[axis]) upper = min(upper + 1, kBoxSteps);
      }
      group.boxes[axis][i] = static_cast<std::uint8_t>(lower);
      group.boxes[axis + 3][i] = static_cast<std::uint8_t>(upper);
    }
  }
}

/// The box of a group.
Box box_of(const PhotonGroup& group) {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis] = group.low[axis];
    box.high[axis] = fma(kBoxSteps, group.step[axis], group.low[axis]);
  }
  return box;
}

/// The photons of a block, anywhere in memory.
struct BlockPhotons {
  const Photon* photons[kPhotonBlock];
  std::uint32_t count;

  Box box() const {
    Box box;
    for (std::uint32_t i = 0; i < count; ++i) box.add(photons[i]->p);
    return box;
  }
};

/// Whether all photons arrive on the side of this normal. `surface`: see photon_surface().
bool is_one_sided(const BlockPhotons& block, std::uint32_t surface) {
  const Vec3f n = decode_octahedral<Scalar>(surface);
  for (std::uint32_t i = 0; i < block.count; ++i)
    if (!(dot(decode_octahedral<Scalar>(block.photons[i]->direction), n) > kOneSidedCosine)) return false;
  return true;
}

/// The high half of the nearest float that is not less than `step` and has no low half.
std::uint16_t power_step_above(float step) { return static_cast<std::uint16_t>((float_bits(step) + 0xffffu) >> 16); }

/// Sets the surface of block `node` in its group, and the step of its powers.
void describe_block(const BlockPhotons& block, float scale, std::uint32_t node, std::uint32_t powers,
                    PhotonBlockGroup& group) {
  const std::uint32_t normal = photon_normal(block.photons[0]->surface);
  std::uint32_t edges = 0, mixed = block.count < kPhotonBlock ? kMixedNormals : 0u;
  float largest = 0;
  for (std::uint32_t i = 0; i < block.count; ++i) {
    const Photon& photon = *block.photons[i];
    edges = std::max(edges, photon.surface & kMaxPhotonEdges);
    if (photon_normal(photon.surface) != normal) mixed = kMixedNormals;
    const float all[4] = {photon.power.c0, photon.power.c1, photon.power.c2, photon.power.c3};
    for (std::uint32_t k = 0; k < powers; ++k) largest = max(largest, all[k] * scale);
  }
  // Lookups ignore the sign of the normal. Choose the one that faces the photons.
  const std::uint32_t flipped = photon_normal(encode_octahedral<Scalar>(-decode_octahedral<Scalar>(normal)));
  const bool faces = is_one_sided(block, normal);
  if (faces || is_one_sided(block, flipped)) group.one_sided |= 1u << node;
  const bool flips = !faces && (group.one_sided >> node & 1u) != 0;
  group.surfaces[node] = (flips && mixed == 0 ? flipped : normal) | mixed | edges;
  group.power_steps[node] = power_step_above(largest / static_cast<float>(photon_power(powers, 0).max));
}

/// `x` in steps, rounded to the nearest.
std::uint32_t in_steps(float x, float step, std::uint32_t max) {
  const float steps = step > 0.0f ? x / step + 0.5f : 0.0f;
  return static_cast<std::uint32_t>(clamp(steps, 0.0f, static_cast<float>(max)));
}

/// Rounds the powers of a block to steps, one after the other. They are differences of their cumulative sums, rounded
/// down from an offset. If that is uniform in [0, 1), each sum is unbiased, and wrong by less than one step (systematic
/// sampling).
class PowerRounding {
 public:
  PowerRounding(float step, std::uint32_t max, double offset) : step_(step), max_(max), sum_(offset) {}

  std::uint32_t in_steps(float power) {
    if (!(step_ > 0.0) || !(power > 0.0f)) return 0;
    const double before = std::floor(sum_);
    sum_ += std::min(max_, static_cast<double>(power) / step_);
    return static_cast<std::uint32_t>(std::min(max_, std::floor(sum_) - before));
  }

 private:
  double step_, max_, sum_;
};

/// Offsets of the blocks, see PowerRounding: equidistributed along the curve.
double rounding_offset(std::size_t block) {
  constexpr double kGoldenRatio = 0.61803398874989485;
  const double x = kGoldenRatio * static_cast<double>(block);
  return x - std::floor(x);
}

/// Writes block `node` of a group, and the sums of its powers. Photons beyond its end have no power. `offset`: see
/// PowerRounding.
void fill_block(const BlockPhotons& photons, PhotonBlockGroup& group, std::uint32_t node, float scale,
                std::uint32_t powers, double offset, PhotonBlock& block) {
  for (std::uint32_t i = 0; i < kPhotonBlock; ++i) {
    const Photon& photon = *photons.photons[i < photons.count ? i : 0];
    block.directions[i] = photon.direction;
    block.surfaces[i] = photon.surface;
    block.positions[i] = block.powers[i] = 0;
    const float p[3] = {photon.p.x, photon.p.y, photon.p.z};
    for (int axis = 0; axis < 3; ++axis) {
      const PhotonField field = kPhotonPosition[axis];
      const float above = -group.low_of(node, axis, p[axis]);
      block.positions[i] |= in_steps(above, group.position_step(node, axis), field.max) << field.shift;
    }
  }
  for (int k = 0; k < static_cast<int>(powers); ++k) {
    const PhotonField field = photon_power(powers, k);
    PowerRounding rounding(group.power_step(node), field.max, offset);
    std::uint32_t sum = 0;
    for (std::uint32_t i = 0; i < photons.count; ++i) {
      const Spectrum4& power = photons.photons[i]->power;
      const float components[4] = {power.c0, power.c1, power.c2, power.c3};
      const std::uint32_t steps = rounding.in_steps(components[k] * scale);
      block.powers[i] |= steps << field.shift;
      sum += steps;
    }
    group.powers[k][node] = static_cast<std::uint16_t>(sum);
  }
}

}  // namespace

PhotonMap::PhotonMap(const std::vector<std::vector<Photon>>& tasks, std::uint64_t emitted, float radius,
                     PhotonKernel kernel, int lookup_size, bool four_lanes)
    : radius_(radius), kernel_(kernel), lookup_size_(lookup_size), four_lanes_(four_lanes) {
  const PhotonOrder order(tasks, kCellOfRadius * radius);
  size_ = order.size();
  if (size_ == 0) return;
  const float scale = 1.0f / static_cast<float>(emitted);
  const std::size_t blocks = divide_up(size_, kPhotonBlock);
  std::size_t nodes = divide_up(blocks, kPhotonBlock);
  blocks_.resize(blocks);
  block_groups_.resize(nodes);
  in_parallel(nodes, [&](std::size_t i) {
    // Find the photons
    const std::size_t first = i * kPhotonBlock, count = std::min<std::size_t>(kPhotonBlock, blocks - first);
    BlockPhotons photons[kPhotonBlock];
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t begin = (first + k) * kPhotonBlock;
      photons[k].count = static_cast<std::uint32_t>(std::min<std::size_t>(kPhotonBlock, size_ - begin));
      for (std::uint32_t j = 0; j < photons[k].count; ++j) {
        photons[k].photons[j] = &order[begin + j];
        prefetch(photons[k].photons[j]), prefetch(&photons[k].photons[j]->order);
      }
    }
    // Make the group and its blocks
    PhotonBlockGroup& group = block_groups_[i];
    group = {};
    Box boxes[kPhotonBlock];
    for (std::size_t k = 0; k < count; ++k) boxes[k] = photons[k].box();
    set_boxes(group, boxes, count);
    for (std::uint32_t k = 0; k < count; ++k) {
      describe_block(photons[k], scale, k, powers(), group);
      fill_block(photons[k], group, k, scale, powers(), rounding_offset(first + k), blocks_[first + k]);
    }
  });
  // Build the levels above
  const auto box_below = [&](std::size_t i) {
    return groups_.empty() ? box_of(block_groups_[i]) : box_of(groups_.back()[i]);
  };
  while (nodes > 1) {
    UninitializedLargeTable<PhotonGroup> level(divide_up(nodes, kPhotonBlock));
    in_parallel(level.size(), [&](std::size_t i) {
      const std::size_t first = i * kPhotonBlock, count = std::min<std::size_t>(kPhotonBlock, nodes - first);
      Box boxes[kPhotonBlock];
      for (std::size_t k = 0; k < count; ++k) boxes[k] = box_below(first + k);
      level[i] = {};
      set_boxes(level[i], boxes, count);
    });
    nodes = level.size();
    groups_.push_back(std::move(level));
  }
}

std::size_t PhotonMap::bytes() const {
  std::size_t groups = 0;
  for (const UninitializedLargeTable<PhotonGroup>& level : groups_) groups += level.size();
  return blocks_.size() * sizeof(PhotonBlock) + block_groups_.size() * sizeof(PhotonBlockGroup) +
         groups * sizeof(PhotonGroup);
}

PhotonMapView PhotonMap::view() const {
  PhotonMapView v;
  v.blocks = blocks_.data();
  v.block_groups = block_groups_.data();
  for (std::size_t level = 0; level < groups_.size(); ++level) v.groups[level + 1] = groups_[level].data();
  v.levels = 1 + static_cast<int>(groups_.size());
  v.size = static_cast<std::uint32_t>(size_);
  v.powers = powers();
  v.radius = radius_;
  v.kernel = kernel_;
  v.lookup_size = lookup_size_;
  return v;
}

Photon PhotonMapView::photon(std::uint32_t i) const {
  const std::uint32_t at = i % kPhotonBlock, node = i / kPhotonBlock % kPhotonBlock;
  const PhotonBlock& block = blocks[i / kPhotonBlock];
  const PhotonBlockGroup& group = group_of(i / kPhotonBlock);
  const auto coordinate = [&](int axis) {
    const auto steps = static_cast<float>(kPhotonPosition[axis].of(block.positions[at]));
    return fma(steps, group.position_step(node, axis), group.low_of(node, axis, 0.0f));
  };
  const auto power = [&](int k) {
    if (k >= static_cast<int>(powers)) return 0.0f;
    return static_cast<float>(photon_power(powers, k).of(block.powers[at])) * group.power_step(node);
  };
  Photon photon;
  photon.p = {coordinate(0), coordinate(1), coordinate(2)};
  photon.power = {power(0), power(1), power(2), power(3)};
  photon.direction = block.directions[at];
  photon.surface = block.surfaces[at];
  return photon;
}

}  // namespace sheaf
