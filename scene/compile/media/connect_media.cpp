// Finds the media in which connections of rays to lights pay (kernels/stages/segment_lights.cpp).
#include "scene/compile/media/compile_media.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sheaf {

namespace {

/// A connection pays if a ray through the medium can subtend this angle at a light, in radians. In media that are small
/// beside their distance from all lights, sampling of distances is as good.
constexpr float kLeastMediumAngle = 0.5f;
/// It also pays only if at least this fraction of the medium is within a mean free path of a light: paths in dense
/// media scatter near lights by themselves.
constexpr float kLeastLitFraction = 0.02f;

/// Whether the stage can connect the rays of a medium, because it knows the pdf of distances: exactly in homogeneous
/// media, by the mean extinction in media with one grid. In both, the pdfs of light sampling are equal in all lanes.
bool can_connect(const MediumRow& row) {
  if ((row.flags & kMediumScatters) == 0 || (row.flags & kMediumFlakes) != 0) return false;
  if ((row.flags & kMediumHomogeneous) != 0) return true;
  constexpr std::uint32_t kNeeded = kMediumSingleGrid | kMediumGray;
  const bool has_constant_albedo = row.second_grid == kNone && (row.density == kNone || row.first_grid == kNone);
  return (row.flags & kNeeded) == kNeeded && has_constant_albedo;
}

/// A part of a medium, and how much of it is near lights.
class MediumPart {
 public:
  /// `mean_free_path`: m; may be infinite.
  MediumPart(const Bounds3f& box, float mean_free_path) : box_(box), mean_free_path_(mean_free_path) {
    const Vec3f size = box.max - box.min;
    length_ = std::min(std::max({size.x, size.y, size.z}), kSegmentDepth * mean_free_path);
    volume_ = size.x * size.y * size.z;
  }

  bool is_lit() const { return lit_fraction_ >= kLeastLitFraction; }

  /// Adds the lights below node `index` of the tree, other than emitting media, until the part is lit.
  void add_lights(const LightTree& tree, const std::vector<bool>& is_medium, std::uint32_t index) {
    const LightNodeRow& node = tree.nodes[index];
    const LightChildren children(node);
    for (std::uint32_t k = 0; k < kLightChildren && !is_lit(); ++k) {
      const LightChild<Scalar>& child = children[k];
      if (std::isnan(child.spread)) continue;  // no power
      const std::uint32_t position = light_tree_child(node, index, k);
      const float distance = distance_to(child.center);
      if ((position & kLightLeaf) != 0) {
        if (!is_medium[node.lights[k]] && is_near(distance, child.radius))
          lit_fraction_ += fraction_around(distance, child.radius);
      } else if (is_near(std::max(distance - child.radius, 0.0f), 0.0f)) {
        add_lights(tree, is_medium, position);
      }
    }
  }

 private:
  float distance_to(Vec3f p) const {
    const auto outside = [](float low, float high, float x) { return std::max({low - x, x - high, 0.0f}); };
    return std::hypot(outside(box_.min.x, box_.max.x, p.x), outside(box_.min.y, box_.max.y, p.y),
                      outside(box_.min.z, box_.max.z, p.z));
  }
  /// Whether the longest rays subtend enough at a sphere of `radius` meters.
  bool is_near(float distance, float radius) const {
    return std::atan2(0.5f * length_, std::hypot(distance, radius)) > 0.5f * kLeastMediumAngle;
  }
  /// Bound on the fraction of the part that is within a mean free path of the sphere.
  float fraction_around(float distance, float radius) const {
    const float reach = mean_free_path_ + radius;
    if (distance > reach) return 0.0f;
    return volume_ > 0.0f ? 4.0f / 3.0f * std::numbers::pi_v<float> * reach * reach * reach / volume_ : 1.0f;
  }

  Bounds3f box_;
  float mean_free_path_, length_, volume_, lit_fraction_ = 0;
};

}  // namespace

void connect_media(const CompiledMedia& media, SceneTables& scene) {
  const LightTree& tree = scene.lights.tree;
  const auto is_exact = [](const MediumRow& row) { return (row.flags & (kMediumHomogeneous | kMediumGray)) != 0; };
  if (tree.nodes.empty() || !std::all_of(scene.media.rows.begin(), scene.media.rows.end(), is_exact)) return;
  std::vector<bool> is_medium(scene.lights.rows.size());
  for (const MediumRow& row : scene.media.rows)
    if (row.light != kNone) is_medium[row.light] = true;
  for (std::size_t i = 0; i < scene.media.rows.size(); ++i) {
    MediumRow& row = scene.media.rows[i];
    if (!can_connect(row)) continue;
    std::vector<Bounds3f> boxes = media.boxes[i];
    const Vec3f reach = Vec3f{1, 1, 1} * scene.radius;
    if (boxes.empty()) boxes.push_back({scene.center - reach, scene.center + reach});
    const std::uint32_t grid = row.density != kNone ? row.density : row.first_grid;
    for (const Bounds3f& box : boxes) {
      const bool homogeneous = (row.flags & kMediumHomogeneous) != 0;
      MediumPart part(homogeneous ? box : intersection(box, media.grids[grid].box), 1.0f / row.mean_extinction);
      part.add_lights(tree, is_medium, 0);
      if (part.is_lit()) row.flags |= kMediumConnects;
    }
  }
}

}  // namespace sheaf
