// Motion of the nodes of a glTF file while the shutter is open.
#pragma once

#include "scene/description/placement.h"
#include "scene/dialects/gltf/pose.h"

namespace sheaf::gltf {

/// Number of equidistant times over the shutter at which motion is tabulated that keys do not describe.
inline constexpr std::size_t kTabulatedTimes = 129;

/// The transforms to world space of nodes that move while the shutter is open; others are empty. Keys have times
/// relative to the moment. All are empty if the shutter does not open. Throws SceneError as pose_at() does.
std::vector<std::optional<AnimatedTransform>> node_motions(const GltfFile& file, const AnimationTime& moment,
                                                           const ShutterDescription& shutter, const Pose& pose);

/// Whether the animation may deform the mesh of a node while the shutter is open, by a skin or by morph targets.
bool deforms_mesh(const GltfFile& file, const AnimationTime& moment, const ShutterDescription& shutter,
                  std::size_t node);

/// A track of kTabulatedTimes keys with the values of at(time).
template <class At> AnimatedTransform tabulate(const ShutterDescription& shutter, At&& at) {
  std::vector<AnimatedTransform::Key> keys;
  keys.reserve(kTabulatedTimes);
  for (std::size_t i = 0; i < kTabulatedTimes; ++i) {
    const double t = static_cast<double>(i) / (kTabulatedTimes - 1);
    const double time = shutter.open + t * (shutter.close - shutter.open);
    if (keys.empty() || time > keys.back().time) keys.push_back({time, at(time)});
  }
  return AnimatedTransform(std::move(keys));
}

}  // namespace sheaf::gltf
