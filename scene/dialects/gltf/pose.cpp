// Poses of glTF nodes at a moment of an animation.
#include "scene/dialects/gltf/pose.h"

#include "scene/dialects/gltf/animation_keys.h"

#include <algorithm>
#include <cmath>

namespace sheaf::gltf {

namespace {

/// Applies an animation to the poses and weights of nodes.
void animate(const GltfFile& file, const GltfAnimation& animation, double time, std::vector<GltfNode>& nodes) {
  for (std::size_t i = 0; i < animation.channels.size(); ++i) {
    const GltfAnimation::Channel& channel = animation.channels[i];
    const std::string part = channel_name(animation, i);
    const std::vector<double> value = load_keys(file, channel, part).at(time);
    GltfNode& node = nodes[static_cast<std::size_t>(channel.node)];
    if (channel.path != GltfAnimation::Channel::Path::kWeights && node.matrix)
      throw file.error(part, "moves a node that has a matrix");
    switch (channel.path) {
      case GltfAnimation::Channel::Path::kTranslation:
        std::copy(value.begin(), value.end(), node.pose.translation.begin());
        break;
      case GltfAnimation::Channel::Path::kRotation:
        std::copy(value.begin(), value.end(), node.pose.rotation.begin());
        break;
      case GltfAnimation::Channel::Path::kScale:
        std::copy(value.begin(), value.end(), node.pose.scale.begin());
        break;
      case GltfAnimation::Channel::Path::kWeights:
        node.weights.assign(value.begin(), value.end());
        break;
    }
  }
}

}  // namespace

std::optional<Matrix4> thickened(const Matrix4& matrix) {
  // Relative to the largest singular value
  constexpr double kFlat = 1e-12, kThickness = 1e-6;
  // The cofactors of a matrix of rank 2 are the outer product of the normal of the plane and the collapsed direction
  Matrix4 cofactors;
  double squared = 0, cofactors_squared = 0, determinant = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const auto& m = matrix.m;
      const std::size_t i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double cofactor = m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
      cofactors.m[i][j] = cofactor;
      squared += m[i][j] * m[i][j];
      cofactors_squared += cofactor * cofactor;
      if (i == 0) determinant += m[i][j] * cofactor;
    }
  const double size = std::sqrt(squared), cofactor_size = std::sqrt(cofactors_squared);
  if (!(cofactor_size > kFlat * squared) || !std::isfinite(cofactor_size)) return std::nullopt;
  Matrix4 out = matrix, inverse;
  if (!(std::fabs(determinant) > kFlat * size * cofactor_size))
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) out.m[i][j] += kThickness * size / cofactor_size * cofactors.m[i][j];
  return invert(out, inverse) ? std::optional(out) : std::nullopt;
}

Matrix4 matrix_of(const GltfPose& pose) {
  auto [x, y, z, w] = pose.rotation;
  const double norm = std::sqrt(x * x + y * y + z * z + w * w);
  if (norm > 0) {
    x /= norm, y /= norm, z /= norm, w /= norm;
  } else {
    w = 1;
  }
  const double rotation[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                                 {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                                 {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
  Matrix4 m;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) m.m[i][j] = rotation[i][j] * pose.scale[j];
    m.m[i][3] = pose.translation[i];
  }
  return m;
}

namespace {

/// The transforms of all nodes to world space.
std::vector<Matrix4> multiply_hierarchy(const std::vector<GltfNode>& nodes) {
  std::vector<Matrix4> to_world(nodes.size());
  std::vector<bool> is_child(nodes.size(), false);
  for (const GltfNode& node : nodes)
    for (const int child : node.children) is_child[static_cast<std::size_t>(child)] = true;
  // Parents first
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (is_child[i]) continue;
    to_world[i] = nodes[i].matrix.value_or(matrix_of(nodes[i].pose));
    open.push_back(i);
  }
  while (!open.empty()) {
    const std::size_t parent = open.back();
    open.pop_back();
    for (const int child : nodes[parent].children) {
      const auto i = static_cast<std::size_t>(child);
      to_world[i] = to_world[parent] * nodes[i].matrix.value_or(matrix_of(nodes[i].pose));
      open.push_back(i);
    }
  }
  return to_world;
}

}  // namespace

Pose pose_at(const GltfFile& file, const AnimationTime& moment) {
  std::vector<GltfNode> nodes = file.nodes;
  if (const GltfAnimation* animation = find_animation(file, moment)) animate(file, *animation, *moment.time, nodes);
  Pose pose;
  for (const GltfNode& node : nodes) pose.weights.push_back(node.weights);
  pose.to_world = multiply_hierarchy(nodes);
  bool has_zero = false;
  for (GltfNode& node : nodes)
    for (double& factor : node.pose.scale)
      if (factor == 0) has_zero = true, factor = 1;
  pose.directions = has_zero ? multiply_hierarchy(nodes) : pose.to_world;
  return pose;
}

}  // namespace sheaf::gltf
