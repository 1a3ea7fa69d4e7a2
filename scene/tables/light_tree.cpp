#include "scene/tables/light_tree.h"

#include "core/error.h"
#include "scene/tables/light_cone.h"

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
constexpr double kLargest = std::numeric_limits<double>::max();

/// Bounds of some lights, in double precision. No lights: a box inside out.
struct Cluster {
  Vec3d lower{kLargest, kLargest, kLargest}, upper{-kLargest, -kLargest, -kLargest};
  DirectionCone cone;
  double cos_theta_e = 1, power = 0;
  std::uint32_t count = 0;
  bool two_sided = false;

  void add(const Cluster& other) {
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
};

/// What a cluster costs in expectation: power x area x solid angle (Conty Estevez and Kulla 2018, section 4.4). The
/// square of the diagonal joins the area with a small weight, which tells clusters along a line apart.
double cluster_cost(const Cluster& cluster) {
  constexpr double kDiagonalWeight = 1e-3, kLeastPower = 1e-30;
  if (cluster.count == 0) return 0;
  const double x = cluster.upper[0] - cluster.lower[0], y = cluster.upper[1] - cluster.lower[1];
  const double z = cluster.upper[2] - cluster.lower[2];
  const double area = 2.0 * (x * y + y * z + z * x) + kDiagonalWeight * (x * x + y * y + z * z);
  const double measure = cone_measure(cluster.cone, std::acos(cluster.cos_theta_e));
  return std::max(cluster.power, kLeastPower) * area * (cluster.two_sided ? 2.0 : 1.0) * measure;
}

bool is_sound(const LightBounds& light) {
  const float squared = dot(light.axis, light.axis);
  return is_finite(light.lower) && is_finite(light.upper) && squared > 0.9f && squared < 1.1f &&
         is_finite(light.cos_theta_o) && is_finite(light.cos_theta_e);
}

Cluster make_cluster(const LightBounds& light) {
  Cluster cluster;
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

/// The row for a cluster; `pair_power`: of it and its sibling.
LightNodeRow make_row(const Cluster& cluster, double pair_power, std::uint32_t link) {
  LightNodeRow row{};
  float* const centers[3] = {&row.center.x, &row.center.y, &row.center.z};
  float* const tilts[3] = {&row.tilt.x, &row.tilt.y, &row.tilt.z};
  const double cos_theta_o = std::max(cluster.cone.cos_theta, 0.0);
  double squared = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double center = 0.5 * (cluster.lower[c] + cluster.upper[c]);
    *centers[c] = static_cast<float>(center);
    *tilts[c] = static_cast<float>(cluster.cone.axis[c] * cos_theta_o);
    const double reach = std::max(cluster.upper[c] - *centers[c], *centers[c] - cluster.lower[c]);
    squared += reach * reach;
  }
  constexpr double kOutwards = 1.0 + 0x1p-21;
  row.radius = static_cast<float>(std::min(std::sqrt(squared) * kOutwards, 3e38));
  row.share = cluster.power > 0.0 ? std::max(static_cast<float>(cluster.power / pair_power), kLeastShare) : 0.0f;
  row.spread = static_cast<float>(cos_theta_o > 0.0 ? cluster.cone.sin_theta : 1.0);
  constexpr double kCosineError = 1e-6;
  row.cos_theta_e = static_cast<float>(std::cos(std::acos(cluster.cos_theta_e) + kLightConeSlack) - kCosineError);
  row.link = link | (cluster.two_sided ? kLightTwoSided : 0u);
  row.power = static_cast<float>(std::min(cluster.power, 3e38));
  row.light_count = cluster.count;
  return row;
}

/// A plane across one axis; lights of bucket <= `bucket` go to the first child.
struct Split {
  std::size_t axis = 0;
  int bucket = 0;
  double cost = kLargest;
};

/// Divides ranges of `order_` from the root down; bounds come back up.
class Builder {
 public:
  explicit Builder(std::span<const LightBounds> lights) {
    clusters_.reserve(lights.size());
    order_.resize(lights.size());
    scratch_.resize(lights.size());
    for (std::size_t i = 0; i < lights.size(); ++i) {
      if (!is_sound(lights[i]))
        throw SceneError("light " + std::to_string(i) + " has no finite bounds, expected a box and a unit axis");
      clusters_.push_back(make_cluster(lights[i]));
      order_[i] = static_cast<std::uint32_t>(i);
    }
    tree_.trails.resize(lights.size());
  }

  LightTree build() {
    const std::size_t n = order_.size();
    tree_.nodes.reserve(2 * n);
    if (n == 1) {
      tree_.nodes.push_back(make_row(clusters_[0], clusters_[0].power, kLightLeaf));
      tree_.nodes.push_back(LightNodeRow{});
      tree_.nodes.back().link = kLightLeaf;
      tree_.depth = 1;
    } else if (n > 1) {
      build_children(0, n, 0, 0);
    }
    return std::move(tree_);
  }

 private:
  double centroid(std::uint32_t light, std::size_t axis) const {
    return 0.5 * (clusters_[light].lower[axis] + clusters_[light].upper[axis]);
  }

  /// Divides lights [begin, end) of the order, two or more, into a pair of nodes at `level`. Their bounds, joined.
  Cluster build_children(std::size_t begin, std::size_t end, int level, std::uint32_t trail) {
    const std::size_t first = tree_.nodes.size(), middle = split(begin, end, level);
    tree_.nodes.resize(first + 2);
    tree_.depth = std::max(tree_.depth, level + 1);
    const std::size_t bounds[3] = {begin, middle, end};
    Cluster children[2];
    std::uint32_t links[2];
    for (std::size_t side = 0; side < 2; ++side) {
      const std::uint32_t turned = trail | static_cast<std::uint32_t>(side) << level;
      if (bounds[side + 1] - bounds[side] == 1) {
        const std::uint32_t light = order_[bounds[side]];
        tree_.trails[light] = turned;
        children[side] = clusters_[light];
        links[side] = kLightLeaf | light;
      } else {
        links[side] = static_cast<std::uint32_t>(tree_.nodes.size());
        children[side] = build_children(bounds[side], bounds[side + 1], level + 1, turned);
      }
    }
    const double power = children[0].power + children[1].power;
    for (std::size_t side = 0; side < 2; ++side)
      tree_.nodes[first + side] = make_row(children[side], power, links[side]);
    children[0].add(children[1]);
    return children[0];
  }

  /// Puts the lights of the first child before those of the second, both in order of their index. Where the second
  /// begins.
  std::size_t split(std::size_t begin, std::size_t end, int level) {
    Vec3d low{kLargest, kLargest, kLargest}, high{-kLargest, -kLargest, -kLargest};
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double c = centroid(order_[i], axis);
        low[axis] = std::min(low[axis], c);
        high[axis] = std::max(high[axis], c);
      }
    // Halving from here on still reaches single lights in time; one more uneven split might not leave that room.
    const int halvings = std::bit_width(end - begin - 1);
    if (level + halvings < kMaxLightTreeDepth)
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

  /// The cheapest of the planes between buckets (Conty Estevez and Kulla 2018, equation 2). None if all lights have one
  /// place.
  std::optional<Split> best_split(std::size_t begin, std::size_t end, const Vec3d& low, const Vec3d& high) const {
    const double longest = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
    Split best;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double extent = high[axis] - low[axis], scale = kBuckets / extent;
      if (!(extent > 0.0) || !std::isfinite(scale)) continue;
      Cluster buckets[kBuckets];
      for (std::size_t i = begin; i < end; ++i)
        buckets[bucket_of(centroid(order_[i], axis), low[axis], scale)].add(clusters_[order_[i]]);
      double cost_after[kBuckets] = {};
      Cluster after, before;
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

  /// At the median along the longest axis, ties by index.
  std::size_t split_in_halves(std::size_t begin, std::size_t end, const Vec3d& low, const Vec3d& high) {
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

  /// A stable partition of [begin, end) of the order.
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

  std::vector<Cluster> clusters_;
  std::vector<std::uint32_t> order_, scratch_;
  LightTree tree_;
};

}  // namespace

LightTreeView LightTree::view() const {
  LightTreeView v{nodes.data(), trails.data(), static_cast<std::uint32_t>(nodes.size()), {}};
  if (nodes.empty()) return v;
  for (std::size_t pair = 0; pair < kLightTopPairs; ++pair)
    for (std::size_t side = 0; side < 2; ++side) {
      const std::uint32_t link = v.top[pair];
      v.top[2 * pair + 1 + side] = (link & kLightLeaf) != 0 ? link : nodes[(link & kLightIndex) + side].link;
    }
  return v;
}

LightTree build_light_tree(std::span<const LightBounds> lights) {
  if (lights.size() > kLightIndex)
    throw SceneError(std::to_string(lights.size()) + " lights, expected at most " + std::to_string(kLightIndex));
  return Builder(lights).build();
}

}  // namespace sheaf
