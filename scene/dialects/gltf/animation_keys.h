// The keys of one channel of a glTF animation, with steps, linear interpolation and cubic splines.
#pragma once

#include "scene/dialects/model/model_view.h"
#include "scene/formats/gltf.h"

#include <array>
#include <optional>

namespace sheaf::gltf {

/// The keys of a channel. Each key of a cubic spline has an incoming tangent, a value and an outgoing tangent.
struct AnimationKeys {
  std::vector<float> times, values;  ///< times in s, not decreasing
  std::size_t size = 1;              ///< numbers per value
  GltfAnimation::Channel::Interpolation interpolation{};
  bool is_rotation = false;

  enum Part { kIn, kValue, kOut };
  std::vector<double> part(std::size_t key, Part part) const;
  /// The value at a time (s); that of the first or last key outside of their range.
  std::vector<double> at(double time) const;
};

/// Loads the keys of a channel, which `part` names in messages. Throws SceneError if times and values do not match.
AnimationKeys load_keys(const GltfFile& file, const GltfAnimation::Channel& channel, const std::string& part);

/// The animation that `moment` names, or null without a time. Throws SceneError if it does not exist.
const GltfAnimation* find_animation(const GltfFile& file, const AnimationTime& moment);

/// Times of the first and the last key of an animation, s; empty if it has none or they cannot be read.
std::optional<std::array<double, 2>> time_range(const GltfFile& file, const GltfAnimation& animation);

/// Name of a channel in messages.
std::string channel_name(const GltfAnimation& animation, std::size_t channel);

}  // namespace sheaf::gltf
