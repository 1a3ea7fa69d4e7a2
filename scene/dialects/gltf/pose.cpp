// Animation of glTF nodes: keys with steps, linear interpolation and cubic splines.
#include "scene/dialects/gltf/pose.h"

#include "core/error.h"

#include <algorithm>
#include <cmath>

namespace sheaf::gltf {

namespace {

using AnimationChannel = GltfAnimation::Channel;
using Values = std::vector<double>;

/// Position of a time between two keys.
struct KeyPair {
  std::size_t first = 0, second = 0;
  double t = 0;         ///< from 0 at the first to 1 at the second
  double duration = 0;  ///< seconds in between
};

KeyPair find_keys(const std::vector<float>& times, double time) {
  const auto after = std::upper_bound(times.begin(), times.end(), static_cast<float>(time));
  if (after == times.begin()) return {};
  const auto second = static_cast<std::size_t>(after - times.begin());
  if (second == times.size()) return {second - 1, second - 1, 0, 0};
  const double begin = times[second - 1], end = times[second];
  return {second - 1, second, std::clamp((time - begin) / (end - begin), 0.0, 1.0), end - begin};
}

double dot(const Values& a, const Values& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// Interpolation of unit quaternions at constant angular speed, along the shorter arc.
Values slerp(const Values& a, Values b, double t) {
  double cosine = dot(a, b);
  if (cosine < 0) {
    for (double& x : b) x = -x;
    cosine = -cosine;
  }
  constexpr double kNearlyEqual = 0.9995;
  double weight_a = 1 - t, weight_b = t;
  if (cosine < kNearlyEqual) {
    const double angle = std::acos(std::min(cosine, 1.0));
    weight_a = std::sin((1 - t) * angle) / std::sin(angle);
    weight_b = std::sin(t * angle) / std::sin(angle);
  }
  Values out(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) out[i] = weight_a * a[i] + weight_b * b[i];
  return out;
}

/// The keys of a channel. Each key of a cubic spline has an incoming tangent, a value and an outgoing tangent.
struct Keys {
  std::vector<float> times, values;
  std::size_t size = 1;  ///< numbers per value
  bool is_cubic = false;

  enum Part { kIn, kValue, kOut };
  Values at(std::size_t key, Part part) const {
    const std::size_t first = (is_cubic ? 3 * key + part : key) * size;
    return {values.begin() + static_cast<std::ptrdiff_t>(first),
            values.begin() + static_cast<std::ptrdiff_t>(first + size)};
  }
};

Values evaluate(const Keys& keys, const AnimationChannel& channel, double time) {
  const KeyPair pair = find_keys(keys.times, time);
  Values first = keys.at(pair.first, Keys::kValue);
  const Values second = keys.at(pair.second, Keys::kValue);
  if (channel.interpolation == AnimationChannel::Interpolation::kStep || pair.first == pair.second) return first;
  if (channel.interpolation == AnimationChannel::Interpolation::kLinear) {
    if (channel.path == AnimationChannel::Path::kRotation) return slerp(first, second, pair.t);
    Values out(first.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = first[i] + pair.t * (second[i] - first[i]);
    return out;
  }
  // Cubic Hermite spline (glTF 2.0, appendix C)
  const Values leaving = keys.at(pair.first, Keys::kOut), arriving = keys.at(pair.second, Keys::kIn);
  const double t = pair.t, t2 = t * t, t3 = t2 * t;
  Values out(first.size());
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = (2 * t3 - 3 * t2 + 1) * first[i] + pair.duration * (t3 - 2 * t2 + t) * leaving[i] +
             (3 * t2 - 2 * t3) * second[i] + pair.duration * (t3 - t2) * arriving[i];
  return out;
}

/// Loads the keys of a channel. Throws SceneError if times and values do not match.
Keys load_keys(const GltfFile& file, const AnimationChannel& channel, const std::string& part) {
  Keys keys;
  keys.is_cubic = channel.interpolation == AnimationChannel::Interpolation::kCubic;
  keys.times = read_floats(file, channel.times, 1);
  constexpr int kComponents[] = {3, 4, 3, 1};
  const int components = kComponents[static_cast<int>(channel.path)];
  keys.values = read_floats(file, channel.values, components);
  const std::size_t parts = keys.times.size() * (keys.is_cubic ? 3 : 1);
  if (parts == 0 || keys.values.size() % parts != 0 || keys.values.empty())
    throw file.error(part, "its keys do not match: " + std::to_string(keys.times.size()) + " times and " +
                               std::to_string(keys.values.size()) + " numbers");
  keys.size = keys.values.size() / parts;
  if (channel.path != AnimationChannel::Path::kWeights && keys.size != static_cast<std::size_t>(components))
    throw file.error(part,
                     "has " + std::to_string(keys.size) + " numbers per key, expected " + std::to_string(components));
  const auto bad = [](float x) { return !std::isfinite(x); };
  if (!std::is_sorted(keys.times.begin(), keys.times.end()) || std::any_of(keys.times.begin(), keys.times.end(), bad) ||
      std::any_of(keys.values.begin(), keys.values.end(), bad))
    throw file.error(part, "its times do not increase, or its values are not finite");
  return keys;
}

const GltfAnimation* find_animation(const GltfFile& file, const ModelMoment& moment) {
  if (!moment.time) return nullptr;
  if (file.animations.empty()) {
    if (moment.animation.empty()) return nullptr;
    throw SceneError({file.file.string(), 0}, "has no animation");
  }
  if (moment.animation.empty()) return &file.animations.front();
  std::vector<std::string> names;
  for (std::size_t i = 0; i < file.animations.size(); ++i) {
    const GltfAnimation& animation = file.animations[i];
    if (animation.name == moment.animation || std::to_string(i) == moment.animation) return &animation;
    names.push_back(animation.name);
  }
  throw SceneError({file.file.string(), 0},
                   "has no animation " + in_quotes(moment.animation) + did_you_mean(moment.animation, names));
}

/// Applies an animation to the poses and weights of nodes.
void animate(const GltfFile& file, const GltfAnimation& animation, double time, std::vector<GltfNode>& nodes) {
  for (std::size_t i = 0; i < animation.channels.size(); ++i) {
    const AnimationChannel& channel = animation.channels[i];
    const std::string part = "animation " + in_quotes(animation.name) + ", channel " + std::to_string(i);
    const Values value = evaluate(load_keys(file, channel, part), channel, time);
    GltfNode& node = nodes[static_cast<std::size_t>(channel.node)];
    if (channel.path != AnimationChannel::Path::kWeights && node.matrix)
      throw file.error(part, "moves a node that has a matrix");
    switch (channel.path) {
      case AnimationChannel::Path::kTranslation:
        std::copy(value.begin(), value.end(), node.pose.translation.begin());
        break;
      case AnimationChannel::Path::kRotation:
        std::copy(value.begin(), value.end(), node.pose.rotation.begin());
        break;
      case AnimationChannel::Path::kScale:
        std::copy(value.begin(), value.end(), node.pose.scale.begin());
        break;
      case AnimationChannel::Path::kWeights:
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
