#include "scene/tables/light_tree.h"

#include "core/io/error.h"
#include "scene/tables/light_cluster.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>

namespace sheaf {

namespace {

constexpr int kBuckets = 12;
constexpr double kLargest = LightCluster::kLargest;

/// Cost of a cluster: power x area x orientation measure (Conty Estevez and Kulla 2018, section 4.4). The squared
/// diagonal adds to the area with a small weight, to distinguish clusters along a line.
double cluster_cost(const LightCluster& cluster) {
  constexpr double kDiagonalWeight = 1e-3, kMinPower = 1e-30;
  if (cluster.count == 0) return 0;
  const double x = cluster.upper[0] - cluster.lower[0], y = cluster.upper[1] - cluster.lower[1];
  const double z = cluster.upper[2] - cluster.lower[2];
  const double area = 2.0 * (x * y + y * z + z * x) + kDiagonalWeight * (x * x + y * y + z * z);
  const double measure = cone_measure(cluster.cone, std::acos(cluster.cos_theta_e));
  return std::max(cluster.power, kMinPower) * area * (cluster.two_sided ? 2.0 : 1.0) * measure;
}

bool is_sound(const LightBounds& light) {
  const float squared = dot(light.axis, light.axis);
  return is_finite(light.lower) && is_finite(light.upper) && squared > 0.9f && squared < 1.1f &&
         is_finite(light.cos_theta_o) && is_finite(light.cos_theta_e);
}

LightCluster make_cluster(const LightBounds& light) {
  LightCluster cluster;
  const float lower[3] = {light.lower.x, light.lower.y, light.lower.z};
  const float upper[3] = {light.upper.x, light.upper.y, light.upper.z};
  for (std::size_t c = 0; c < 3; ++c) {
    cluster.lower[c] = std::min(lower[c], upper[c]);
    cluster.upper[c] = std::max(lower[c], upper[c]);
  }
  cluster.cone = DirectionCone::from_cosine({light.axis.x, light.axis.y, light.axis.z}, light.cos_theta_o);
  cluster.cos_theta_e = std::clamp(double(light.cos_theta_e), 0.0, 1.0);
  cluster.power = light.power > 0.0f ? double(std::min(light.power, 1e37f)) : 0.0;
  cluster.count = 1;
  cluster.two_sided = light.two_sided;
  return cluster;
}

/// A split plane perpendicular to one axis. Lights in buckets <= `bucket` go to the first child.
struct Split {
  std::size_t axis = 0;
  int bucket = 0;
  double cost = kLargest;
};

/// A range of consecutive lights in the order.
struct LightRange {
  std::size_t begin = 0, end = 0;
  std::size_t size() const { return end - begin; }
};

/// Builds the tree top-down by dividing ranges of `order_`, and returns bounds bottom-up.
class TreeBuilder {
 public:
  explicit TreeBuilder(std::span<const LightBounds> lights) {
    clusters_.reserve(lights.size());
    order_.resize(lights.size());
    scratch_.resize(lights.size());
    for (std::size_t i = 0; i < lights.size(); ++i) {
      if (!is_sound(lights[i]))
        throw SceneError(fmt::format("light {} has no finite bounds (expected a box and a unit axis)", i));
      clusters_.push_back(make_cluster(lights[i]));
      order_[i] = static_cast<std::uint32_t>(i);
    }
    tree_.trails.resize(lights.size());
  }

  LightTree build() {
    const std::size_t n = order_.size();
    if (n > 0) {
      tree_.nodes.reserve(n / 2 + 1);
      tree_.nodes.resize(1);
      build_node(0, {0, n}, 0, 0);
    }
    return std::move(tree_);
  }

 private:
  double centroid(std::uint32_t light, std::size_t axis) const {
    return 0.5 * (clusters_[light].lower[axis] + clusters_[light].upper[axis]);
  }

  /// Builds node `index` at `level` from a range of lights. Returns their joined bounds.
  LightCluster build_node(std::uint32_t index, const LightRange& lights, int level, std::uint32_t trail) {
    // Divide the lights, and reserve the child nodes
    const std::vector<LightRange> ranges = divide(lights, level);
    const auto first_node = static_cast<std::uint32_t>(tree_.nodes.size());
    const auto node_count = static_cast<std::uint32_t>(
        std::count_if(ranges.begin(), ranges.end(), [](const LightRange& range) { return range.size() > 1; }));
    tree_.nodes.resize(first_node + node_count);
    tree_.depth = std::max(tree_.depth, level + 1);
    // Build the children
    LightCluster children[kLightChildren], whole;
    std::uint32_t leaves[kLightChildren] = {};
    for (std::uint32_t k = 0; k < ranges.size(); ++k) {
      const std::uint32_t child_trail = trail | k << 2 * level;
      if (k < node_count) {
        children[k] = build_node(first_node + k, ranges[k], level + 1, child_trail);
      } else {
        leaves[k] = order_[ranges[k].begin];
        tree_.trails[leaves[k]] = child_trail;
        children[k] = clusters_[leaves[k]];
      }
      whole.add(children[k]);
    }
    tree_.nodes[index] = pack_light_node(children, first_node, node_count, leaves);
    return whole;
  }

  /// Divides the lights of a node at `level` into up to four ranges. Ranges of more than one light come first.
  std::vector<LightRange> divide(const LightRange& lights, int level) {
    // Splitting into equal quarters from here still fits the maximum depth. One more uneven split might not.
    const int quarterings = (std::bit_width(lights.size() - 1) + 1) / 2;
    const bool may_be_uneven = level + quarterings < kMaxLightTreeDepth;
    std::vector<LightRange> ranges{lights};
    while (ranges.size() < kLightChildren) {
      const auto largest = std::max_element(
          ranges.begin(), ranges.end(), [](const LightRange& a, const LightRange& b) { return a.size() < b.size(); });
      if (largest->size() == 1) break;
      const std::size_t middle = split(largest->begin, largest->end, may_be_uneven);
      const LightRange second{middle, largest->end};
      largest->end = middle;
      ranges.insert(largest + 1, second);
    }
    std::stable_partition(ranges.begin(), ranges.end(), [](const LightRange& range) { return range.size() > 1; });
    return ranges;
  }

  /// Moves the lights of the first child before those of the second, each ordered by index. Returns the start of the
  /// second.
  std::size_t split(std::size_t begin, std::size_t end, bool may_be_uneven) {
    Triple low{kLargest, kLargest, kLargest}, high{-kLargest, -kLargest, -kLargest};
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double c = centroid(order_[i], axis);
        low[axis] = std::min(low[axis], c);
        high[axis] = std::max(high[axis], c);
      }
    if (may_be_uneven)
      if (const std::optional<Split> best = best_split(begin, end, low, high)) {
        const double base = low[best->axis], scale = kBuckets / (high[best->axis] - base);
        return partition(begin, end, [&](std::uint32_t light) {
          return bucket_of(centroid(light, best->axis), base, scale) <= best->bucket;
        });
      }
    return split_in_halves(begin, end, low, high);
  }

  static int bucket_of(double c, double base, double scale) {
    return std::clamp(static_cast<int>((c - base) * scale), 0, kBuckets - 1);
  }

  /// The cheapest split between buckets (Conty Estevez and Kulla 2018, equation 2). Empty if all centroids coincide.
  std::optional<Split> best_split(std::size_t begin, std::size_t end, const Triple& low, const Triple& high) const {
    const double longest = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
    Split best;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double extent = high[axis] - low[axis], scale = kBuckets / extent;
      if (!(extent > 0.0) || !std::isfinite(scale)) continue;
      // Distribute the lights to buckets
      LightCluster buckets[kBuckets];
      for (std::size_t i = begin; i < end; ++i)
        buckets[bucket_of(centroid(order_[i], axis), low[axis], scale)].add(clusters_[order_[i]]);
      // Sweep from both ends for the cheapest split
      double cost_after[kBuckets] = {};
      LightCluster after, before;
      for (int k = kBuckets - 1; k > 0; --k) {
        after.add(buckets[k]);
        cost_after[k - 1] = cluster_cost(after);
      }
      for (int k = 0; k + 1 < kBuckets; ++k) {
        before.add(buckets[k]);
        const double cost = longest / extent * (cluster_cost(before) + cost_after[k]);
        const bool divides = before.count != 0 && before.count != end - begin;
        if (divides && cost < best.cost) best = {axis, k, cost};
      }
    }
    if (best.cost == kLargest) return std::nullopt;
    return best;
  }

  /// Splits at the median along the longest axis; ties are resolved by index.
  std::size_t split_in_halves(std::size_t begin, std::size_t end, const Triple& low, const Triple& high) {
    std::size_t axis = 0;
    for (std::size_t c = 1; c < 3; ++c)
      if (high[c] - low[c] > high[axis] - low[axis]) axis = c;
    const auto less = [&](std::uint32_t a, std::uint32_t b) {
      const double ca = centroid(a, axis), cb = centroid(b, axis);
      return ca != cb ? ca < cb : a < b;
    };
    const auto at = [](auto& lights, std::size_t i) { return lights.begin() + static_cast<std::ptrdiff_t>(i); };
    const std::size_t middle = begin + (end - begin) / 2;
    std::copy(at(order_, begin), at(order_, end), at(scratch_, begin));
    std::nth_element(at(scratch_, begin), at(scratch_, middle), at(scratch_, end), less);
    const std::uint32_t median = scratch_[middle];
    return partition(begin, end, [&](std::uint32_t light) { return less(light, median); });
  }

  /// Stable partition of [begin, end) of the order.
  template <class Predicate> std::size_t partition(std::size_t begin, std::size_t end, Predicate&& goes_first) {
    std::size_t first = begin, second = begin;
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t light = order_[i];
      if (goes_first(light))
        order_[first++] = light;
      else
        scratch_[second++] = light;
    }
    std::copy_n(scratch_.begin() + static_cast<std::ptrdiff_t>(begin), second - begin,
                order_.begin() + static_cast<std::ptrdiff_t>(first));
    return first;
  }

  std::vector<LightCluster> clusters_;
  std::vector<std::uint32_t> order_, scratch_;
  LightTree tree_;
};

}  // namespace

LightChildren::LightChildren(const LightNodeRow& node) {
  float words[LightNodeRow::kWordCount];
  for (int k = 0; k < LightNodeRow::kWordCount; ++k) words[k] = std::bit_cast<float>(node.words[k]);
  children_[0] = unpack_light_child<Scalar, 0>(words);
  children_[1] = unpack_light_child<Scalar, 1>(words);
  children_[2] = unpack_light_child<Scalar, 2>(words);
  children_[3] = unpack_light_child<Scalar, 3>(words);
}

void LightCluster::add(const LightCluster& other) {
  if (other.count == 0) return;
  cone = count == 0 ? other.cone : join(cone, other.cone);
  for (std::size_t c = 0; c < 3; ++c) {
    lower[c] = std::min(lower[c], other.lower[c]);
    upper[c] = std::max(upper[c], other.upper[c]);
  }
  cos_theta_e = std::min(cos_theta_e, other.cos_theta_e);
  power += other.power;
  count += other.count;
  two_sided = two_sided || other.two_sided;
}

namespace {

/// Adds the glow sources below a node that has `power`.
void add_glow_sources(const LightTree& tree, std::uint32_t index, float power, int levels, LightTreeView& view) {
  const LightNodeRow& node = tree.nodes[index];
  const LightChildren children(node);
  for (std::uint32_t k = 0; k < kLightChildren; ++k) {
    const LightChild<Scalar>& child = children[k];
    if (std::isnan(child.spread)) continue;
    const float child_power = power * child.power_fraction;
    const std::uint32_t position = light_tree_child(node, index, k);
    if ((position & kLightLeaf) == 0 && levels > 1)
      add_glow_sources(tree, position, child_power, levels - 1, view);
    else
      view.glow_sources[view.glow_source_count++] = {child.center, child.radius, child_power};
  }
}

}  // namespace

LightTreeView LightTree::view() const {
  LightTreeView v;
  v.nodes = nodes.data();
  v.trails = trails.data();
  v.node_count = static_cast<std::uint32_t>(nodes.size());
  if (nodes.empty()) return v;
  for (std::size_t node = 0; node < kLightCutNodes; ++node)
    for (std::uint32_t k = 0; k < kLightChildren; ++k) {
      const std::uint32_t position = v.cut_nodes[node];
      v.cut_nodes[kLightChildren * node + 1 + k] =
          (position & kLightLeaf) != 0 ? position : light_tree_child(nodes[position], position, k);
    }
  add_glow_sources(*this, 0, 1.0f, kGlowLevels, v);
  return v;
}

LightTree build_light_tree(std::span<const LightBounds> lights) {
  if (lights.size() > kLightNodeIndex)
    throw SceneError(fmt::format("{} lights (expected at most {})", lights.size(), kLightNodeIndex));
  return TreeBuilder(lights).build();
}

}  // namespace sheaf
