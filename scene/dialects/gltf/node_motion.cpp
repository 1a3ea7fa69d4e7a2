#include "scene/dialects/gltf/node_motion.h"

#include "core/io/error.h"
#include "scene/dialects/gltf/animation_keys.h"

#include <algorithm>
#include <cmath>

namespace sheaf::gltf {

namespace {

using Path = GltfAnimation::Channel::Path;
using Interpolation = GltfAnimation::Channel::Interpolation;

/// Values of a channel, with times relative to the moment.
struct TrackSample {
  double time;
  std::vector<double> value;
};

/// The part of a channel within the shutter.
class ChannelSampler {
 public:
  ChannelSampler(const AnimationKeys& keys, double moment, const ShutterDescription& shutter)
      : keys_(keys), moment_(moment), shutter_(shutter) {}

  std::vector<TrackSample> samples() {
    if (keys_.interpolation == Interpolation::kCubic) {
      for (std::size_t i = 0; i < kTabulatedTimes; ++i)
        add_at(shutter_.open + static_cast<double>(i) / (kTabulatedTimes - 1) * duration());
      return std::move(samples_);
    }
    add_at(shutter_.open);
    for (std::size_t i = 0; i < keys_.times.size(); ++i) {
      const double time = double{keys_.times[i]} - moment_;
      if (!(time > shutter_.open && time < shutter_.close)) continue;
      // A step changes within a small part of the interval
      constexpr double kStepDuration = 1.0 / 1024;
      if (keys_.interpolation == Interpolation::kStep) add(time - kStepDuration * duration(), samples_.back().value);
      add(time, keys_.part(i, AnimationKeys::kValue));
    }
    if (keys_.interpolation == Interpolation::kStep)
      add(shutter_.close, samples_.back().value);
    else
      add_at(shutter_.close);
    return std::move(samples_);
  }

 private:
  double duration() const { return shutter_.close - shutter_.open; }
  void add_at(double time) { add(time, keys_.at(moment_ + time)); }
  /// Appends a sample. The last of several at one time counts.
  void add(double time, std::vector<double> value) {
    if (!samples_.empty() && !(time > samples_.back().time)) {
      if (time == samples_.back().time) samples_.back().value = std::move(value);
      return;
    }
    samples_.push_back({time, std::move(value)});
  }

  const AnimationKeys& keys_;
  double moment_;
  const ShutterDescription& shutter_;
  std::vector<TrackSample> samples_;
};

/// Replaces factors of scale that are zero, or have another sign than at first, by small ones: a node cannot be turned
/// inside out while the shutter is open.
void keep_invertible(std::vector<TrackSample>& samples) {
  constexpr double kSmallest = 1e-6;
  for (std::size_t k = 0; k < 3; ++k) {
    double largest = 0;
    for (const TrackSample& sample : samples) largest = std::max(largest, std::fabs(sample.value[k]));
    const double smallest = kSmallest * (largest > 0 ? largest : 1), sign = samples[0].value[k] < 0 ? -1 : 1;
    for (TrackSample& sample : samples) sample.value[k] = sign * std::max(sign * sample.value[k], smallest);
  }
}

/// The transform of one translation, rotation or scale.
Transform transform_of(Path path, const std::vector<double>& value) {
  GltfPose pose;
  if (path == Path::kTranslation) std::copy(value.begin(), value.end(), pose.translation.begin());
  if (path == Path::kRotation) std::copy(value.begin(), value.end(), pose.rotation.begin());
  if (path == Path::kScale) std::copy(value.begin(), value.end(), pose.scale.begin());
  return Transform(matrix_of(pose));
}

/// The track of a channel; nothing if it does not change.
std::optional<AnimatedTransform> track_of(const AnimationKeys& keys, Path path, double moment,
                                          const ShutterDescription& shutter) {
  std::vector<TrackSample> samples = ChannelSampler(keys, moment, shutter).samples();
  const auto is_first = [&](const TrackSample& sample) { return sample.value == samples[0].value; };
  if (std::all_of(samples.begin(), samples.end(), is_first)) return std::nullopt;
  if (path == Path::kScale) keep_invertible(samples);
  std::vector<AnimatedTransform::Key> list;
  list.reserve(samples.size());
  for (const TrackSample& sample : samples) list.push_back({sample.time, transform_of(path, sample.value)});
  return AnimatedTransform(std::move(list));
}

/// The tracks of a node.
struct NodeTracks {
  std::optional<AnimatedTransform> translation, rotation, scale;

  int count() const { return int{translation.has_value()} + int{rotation.has_value()} + int{scale.has_value()}; }
};

/// The tracks of all nodes, and where they do not move their poses at the moment.
void animate(const GltfFile& file, const GltfAnimation& animation, double moment, const ShutterDescription& shutter,
             std::vector<NodeTracks>& tracks, std::vector<GltfPose>& poses) {
  for (std::size_t i = 0; i < animation.channels.size(); ++i) {
    const GltfAnimation::Channel& channel = animation.channels[i];
    if (channel.path == Path::kWeights) continue;
    const AnimationKeys keys = load_keys(file, channel, channel_name(animation, i));
    NodeTracks& node = tracks[static_cast<std::size_t>(channel.node)];
    GltfPose& pose = poses[static_cast<std::size_t>(channel.node)];
    const std::vector<double> value = keys.at(moment + shutter.open);
    std::optional<AnimatedTransform> track = track_of(keys, channel.path, moment, shutter);
    if (channel.path == Path::kTranslation) {
      std::copy(value.begin(), value.end(), pose.translation.begin());
      node.translation = std::move(track);
    } else if (channel.path == Path::kRotation) {
      std::copy(value.begin(), value.end(), pose.rotation.begin());
      node.rotation = std::move(track);
    } else {
      std::copy(value.begin(), value.end(), pose.scale.begin());
      node.scale = std::move(track);
    }
  }
}

/// The transform of a matrix, thickened if it is flat. Throws SceneError if it leaves only a line or a point.
Transform regular(const Matrix4& matrix) { return Transform(thickened(matrix).value_or(matrix)); }

/// The transform of a node to its parent. Throws SceneError if it leaves only a line or a point.
AnimatedTransform local_transform(const GltfNode& node, const NodeTracks& tracks, const GltfPose& pose) {
  if (node.matrix) return AnimatedTransform(regular(*node.matrix));
  const auto factor = [](const std::optional<AnimatedTransform>& track, const GltfPose& rest) {
    return track ? *track : AnimatedTransform(regular(matrix_of(rest)));
  };
  return factor(tracks.translation, {pose.translation}) * factor(tracks.rotation, {{}, pose.rotation}) *
         factor(tracks.scale, {{}, {0, 0, 0, 1}, pose.scale});
}

/// Long products become one track.
constexpr int kMaxTracks = 32;

}  // namespace

bool deforms_mesh(const GltfFile& file, const AnimationTime& moment, const ShutterDescription& shutter,
                  std::size_t node) {
  const GltfAnimation* animation = find_animation(file, moment);
  if (animation == nullptr || !(shutter.close > shutter.open)) return false;
  return file.nodes[node].skin != kNoIndex ||
         std::any_of(animation->channels.begin(), animation->channels.end(), [&](const GltfAnimation::Channel& c) {
           return c.path == Path::kWeights && static_cast<std::size_t>(c.node) == node;
         });
}

std::vector<std::optional<AnimatedTransform>> node_motions(const GltfFile& file, const AnimationTime& moment,
                                                           const ShutterDescription& shutter, const Pose& pose) {
  std::vector<std::optional<AnimatedTransform>> motions(file.nodes.size());
  const GltfAnimation* animation = find_animation(file, moment);
  if (animation == nullptr || !(shutter.close > shutter.open)) return motions;
  // Load the tracks
  std::vector<NodeTracks> tracks(file.nodes.size());
  std::vector<GltfPose> poses;
  for (const GltfNode& node : file.nodes) poses.push_back(node.pose);
  animate(file, *animation, *moment.time, shutter, tracks, poses);
  // Multiply along the hierarchy, parents first
  std::vector<int> parents(file.nodes.size(), kNoIndex), counts(file.nodes.size(), 0);
  for (std::size_t i = 0; i < file.nodes.size(); ++i)
    for (const int child : file.nodes[i].children) parents[static_cast<std::size_t>(child)] = static_cast<int>(i);
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < file.nodes.size(); ++i)
    if (parents[i] == kNoIndex) open.push_back(i);
  while (!open.empty()) {
    const std::size_t i = open.back();
    open.pop_back();
    for (const int child : file.nodes[i].children) open.push_back(static_cast<std::size_t>(child));
    const bool is_root = parents[i] == kNoIndex;
    const std::size_t parent = is_root ? i : static_cast<std::size_t>(parents[i]);
    counts[i] = (is_root ? 0 : counts[parent]) + tracks[i].count();
    if (counts[i] == 0) continue;
    try {
      const AnimatedTransform local = local_transform(file.nodes[i], tracks[i], poses[i]);
      AnimatedTransform outer;
      if (!is_root) outer = motions[parent] ? *motions[parent] : AnimatedTransform(regular(pose.to_world[parent]));
      motions[i] = outer * local;
      if (counts[i] <= kMaxTracks) continue;
      motions[i] = tabulate(shutter, [&](double time) { return motions[i]->at(time); });
      counts[i] = 1;
    } catch (const SceneError&) {
      // Collapsed: the reader of the scene leaves the node out
      motions[i].reset();
    }
  }
  return motions;
}

}  // namespace sheaf::gltf
