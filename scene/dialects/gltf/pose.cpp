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

Pose pose_at(const GltfFile& file, const ModelMoment& moment) {
  std::vector<GltfNode> nodes = file.nodes;
  if (const GltfAnimation* animation = find_animation(file, moment)) animate(file, *animation, *moment.time, nodes);
  Pose pose;
  pose.to_world.resize(nodes.size());
  for (const GltfNode& node : nodes) pose.weights.push_back(node.weights);
  // Multiply the transforms along the hierarchy, parents first
  std::vector<bool> is_child(nodes.size(), false);
  for (const GltfNode& node : nodes)
    for (const int child : node.children) is_child[static_cast<std::size_t>(child)] = true;
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (is_child[i]) continue;
    pose.to_world[i] = nodes[i].matrix.value_or(matrix_of(nodes[i].pose));
    open.push_back(i);
  }
  while (!open.empty()) {
    const std::size_t parent = open.back();
    open.pop_back();
    for (const int child : nodes[parent].children) {
      const auto i = static_cast<std::size_t>(child);
      pose.to_world[i] = pose.to_world[parent] * nodes[i].matrix.value_or(matrix_of(nodes[i].pose));
      open.push_back(i);
    }
  }
  return pose;
}

}  // namespace sheaf::gltf
