// Animations of nodes: keys of translation, rotation and scale, interpolated linearly.
#include "tools/importer/conversion.h"

#include <assimp/anim.h>

#include <array>

namespace sheaf::importer {

namespace {

using nlohmann::json;

constexpr double kDefaultRate = 25;  ///< ticks per second of animations that do not say it

/// Adds a sampler and a channel for one part of a node's transform.
template <class Key, class Components>
void add_channel(Conversion& to, json& animation, int node, const char* path, const Key* keys, unsigned count,
                 double rate, const char* type, Components components) {
  if (count == 0) return;
  std::vector<float> times, values;
  for (unsigned i = 0; i < count; ++i) {
    times.push_back(static_cast<float>(finite(keys[i].mTime / rate)));
    for (const double value : components(keys[i].mValue)) values.push_back(static_cast<float>(finite(value)));
  }
  const int input = to.glb.add_accessor(times, count, "SCALAR"), output = to.glb.add_accessor(values, count, type);
  animation["samplers"].push_back({{"input", input}, {"output", output}});
  animation["channels"].push_back(
      {{"sampler", animation["samplers"].size() - 1}, {"target", {{"node", node}, {"path", path}}}});
}

}  // namespace

void add_animations(Conversion& to) {
  const auto vector = [](const aiVector3D& v) { return std::array<double, 3>{v.x, v.y, v.z}; };
  const auto quaternion = [](const aiQuaternion& q) { return std::array<double, 4>{q.x, q.y, q.z, q.w}; };
  bool has_morphs = false;
  for (unsigned i = 0; i < to.scene.mNumAnimations; ++i) {
    const aiAnimation& from = *to.scene.mAnimations[i];
    const double rate = from.mTicksPerSecond > 0 ? from.mTicksPerSecond : kDefaultRate;
    has_morphs = has_morphs || from.mNumMorphMeshChannels > 0;
    json animation = {{"name", text(from.mName)}};
    for (unsigned k = 0; k < from.mNumChannels; ++k) {
      const aiNodeAnim& channel = *from.mChannels[k];
      const auto node = to.node_of.find(text(channel.mNodeName));
      if (node == to.node_of.end()) continue;
      add_channel(to, animation, node->second, "translation", channel.mPositionKeys, channel.mNumPositionKeys, rate,
                  "VEC3", vector);
      add_channel(to, animation, node->second, "rotation", channel.mRotationKeys, channel.mNumRotationKeys, rate,
                  "VEC4", quaternion);
      add_channel(to, animation, node->second, "scale", channel.mScalingKeys, channel.mNumScalingKeys, rate, "VEC3",
                  vector);
    }
    if (animation.contains("channels")) to.glb.add("animations", std::move(animation));
  }
  if (has_morphs) to.notes.push_back("animations of morph targets are not supported (their weights stay)");
}

}  // namespace sheaf::importer
