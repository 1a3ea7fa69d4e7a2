// Animations of nodes: keys of translation, rotation and scale, interpolated linearly.
#include "tools/importer/conversion.h"

#include <assimp/anim.h>

#include <array>
#include <string_view>

namespace sheaf::importer {

namespace {

using nlohmann::json;

constexpr double kDefaultRate = 25;  ///< ticks per second of animations that do not say it

/// Adds a sampler and a channel.
void add_channel(Conversion& to, json& animation, int node, const Keys& keys) {
  if (keys.times.empty()) return;
  const bool is_rotation = std::string_view(keys.path) == "rotation";
  const int input = to.glb.add_accessor(keys.times, keys.times.size(), "SCALAR");
  const int output = to.glb.add_accessor(keys.values, keys.times.size(), is_rotation ? "VEC4" : "VEC3");
  animation["samplers"].push_back({{"input", input}, {"output", output}});
  animation["channels"].push_back(
      {{"sampler", animation["samplers"].size() - 1}, {"target", {{"node", node}, {"path", keys.path}}}});
}

/// Converts the keys of Assimp for one part of a node's transform.
template <class Key, class Components>
Keys keys_of(const char* path, const Key* from, unsigned count, double rate, Components components) {
  Keys out{{}, path, {}, {}};
  for (unsigned i = 0; i < count; ++i) {
    out.times.push_back(static_cast<float>(finite(from[i].mTime / rate)));
    for (const double value : components(from[i].mValue)) out.values.push_back(static_cast<float>(finite(value)));
  }
  return out;
}

/// Adds the animations that Sheaf has read itself, to all instances of their nodes.
void add_own_animations(Conversion& to) {
  for (const Animation& from : to.parts.animations) {
    json animation = {{"name", from.name}};
    for (const Keys& keys : from.channels)
      if (const auto nodes = to.nodes_of.find(keys.node); nodes != to.nodes_of.end())
        for (const int node : nodes->second) add_channel(to, animation, node, keys);
    if (animation.contains("channels")) to.glb.add("animations", std::move(animation));
  }
}

}  // namespace

void add_animations(Conversion& to) {
  add_own_animations(to);
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
      const auto nodes = to.nodes_of.find(text(channel.mNodeName));
      if (nodes == to.nodes_of.end()) continue;
      const int node = nodes->second.front();
      add_channel(to, animation, node,
                  keys_of("translation", channel.mPositionKeys, channel.mNumPositionKeys, rate, vector));
      add_channel(to, animation, node,
                  keys_of("rotation", channel.mRotationKeys, channel.mNumRotationKeys, rate, quaternion));
      add_channel(to, animation, node, keys_of("scale", channel.mScalingKeys, channel.mNumScalingKeys, rate, vector));
    }
    if (animation.contains("channels")) to.glb.add("animations", std::move(animation));
  }
  if (has_morphs) to.notes.push_back("animations of morph targets are not supported (their weights stay)");
}

}  // namespace sheaf::importer
