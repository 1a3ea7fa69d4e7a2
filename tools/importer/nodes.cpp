// The hierarchy of nodes with their meshes, skins, cameras and lights.
#include "tools/importer/conversion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>

namespace sheaf::importer {

namespace {

using nlohmann::json;

/// Columns of a matrix.
json columns_of(const aiMatrix4x4& m) {
  json out = json::array();
  for (unsigned column = 0; column < 4; ++column)
    for (unsigned row = 0; row < 4; ++row) out.push_back(finite(m[row][column]));
  return out;
}

aiVector3D vector(const std::array<double, 3>& v) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

/// The mean scale of a transform.
double scale_of(const aiMatrix4x4& m) { return std::cbrt(std::abs(double{m.Determinant()})); }

/// A coordinate system at a point whose -z axis is `forward`.
aiMatrix4x4 facing(const aiVector3D& origin, aiVector3D forward, aiVector3D up) {
  forward.NormalizeSafe();
  if (forward.SquareLength() == 0) forward = {0, 0, -1};
  aiVector3D right = forward ^ up;
  if (right.Length() < 1e-4f * up.Length() || up.SquareLength() == 0)
    right = std::abs(forward.y) < 0.9f ? forward ^ aiVector3D(0, 1, 0) : forward ^ aiVector3D(1, 0, 0);
  right.Normalize();
  up = right ^ forward;
  return {right.x, up.x, -forward.x, origin.x, right.y, up.y, -forward.y, origin.y,
          right.z, up.z, -forward.z, origin.z, 0,       0,    0,          1};
}

/// The transform of FBX's axes and units to y upwards and meters. Newer versions of Assimp set a similar one, without
/// the unit of FBX, centimeters.
std::optional<aiMatrix4x4> fbx_root(const aiScene& scene) {
  if (scene.mMetaData == nullptr) return std::nullopt;
  int axes[3] = {0, 1, 2}, signs[3] = {1, 1, 1};
  const char* const names[] = {"CoordAxis", "UpAxis", "FrontAxis"};
  for (int row = 0; row < 3; ++row) {
    scene.mMetaData->Get(names[row], axes[row]);
    scene.mMetaData->Get(names[row] + std::string("Sign"), signs[row]);
    if (axes[row] < 0 || axes[row] > 2) return std::nullopt;
  }
  float centimeters = 1;
  double exact = 1;
  if (scene.mMetaData->Get("UnitScaleFactor", exact)) {
    centimeters = static_cast<float>(exact);
  } else {
    scene.mMetaData->Get("UnitScaleFactor", centimeters);
  }
  if (!(centimeters > 0) || !std::isfinite(centimeters)) centimeters = 1;
  aiMatrix4x4 out;
  for (unsigned row = 0; row < 3; ++row)
    for (unsigned column = 0; column < 3; ++column)
      out[row][column] = static_cast<int>(column) == axes[row] ? static_cast<float>(signs[row]) * centimeters / 100 : 0;
  return out;
}

class NodeConverter {
 public:
  explicit NodeConverter(Conversion& to) : to_(to) {}

  void convert() {
    list_nodes();
    for (std::size_t i = 0; i < nodes_.size(); ++i) to_.glb.add("nodes", node(i));
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (!is_hidden(i))
        for (unsigned k = 0; k < nodes_[i]->mNumMeshes; ++k) add_mesh(i, nodes_[i]->mMeshes[k]);
    center_ = center();
    for (std::size_t i = 0; i < nodes_.size(); ++i) add_parts(i);
    to_.glb.json["scenes"] = {{{"nodes", {0}}}};
  }

 private:
  /// Lists the nodes, parents first.
  void list_nodes() {
    std::vector<std::pair<const aiNode*, int>> open = {{to_.scene.mRootNode, -1}};
    while (!open.empty()) {
      const auto [node, parent] = open.back();
      open.pop_back();
      const auto index = static_cast<int>(nodes_.size());
      aiMatrix4x4 local = node->mTransformation;
      if (parent < 0 && to_.format == "fbx") local = fbx_root(to_.scene).value_or(local);
      nodes_.push_back(node);
      locals_.push_back(local);
      to_world_.push_back(parent < 0 ? local : to_world_[static_cast<std::size_t>(parent)] * local);
      children_.emplace_back();
      if (parent >= 0) children_[static_cast<std::size_t>(parent)].push_back(index);
      to_.nodes_of[text(node->mName)].push_back(index);
      parts_.push_back(parts_of(*node));
      for (unsigned k = node->mNumChildren; k-- > 0;) open.emplace_back(node->mChildren[k], index);
    }
    for (unsigned i = 0; i < to_.scene.mNumAnimations; ++i)
      for (unsigned k = 0; k < to_.scene.mAnimations[i]->mNumChannels; ++k)
        moving_.insert(text(to_.scene.mAnimations[i]->mChannels[k]->mNodeName));
    for (const Animation& animation : to_.parts.animations)
      for (const Keys& keys : animation.channels) moving_.insert(keys.node);
  }

  /// The parts of a node that is the last one in nodes_. The root has none, unless Assimp assigns them.
  const NodeParts* parts_of(const aiNode& node) const {
    if (nodes_.size() == 1 && to_.format != "3ds") return nullptr;
    const auto found = to_.parts.nodes.find(text(node.mName));
    if (found == to_.parts.nodes.end() || found->second.empty()) return nullptr;
    return &found->second[std::min(to_.nodes_of[text(node.mName)].size(), found->second.size()) - 1];
  }

  json node(std::size_t i) const {
    json out = {{"name", text(nodes_[i]->mName)}};
    if (!children_[i].empty()) out["children"] = children_[i];
    if (!moving_.contains(text(nodes_[i]->mName))) {
      out["matrix"] = columns_of(locals_[i]);
      return out;
    }
    // Animations replace the parts of a transform.
    aiVector3D scale, position;
    aiQuaternion rotation;
    locals_[i].Decompose(scale, rotation, position);
    out["translation"] = {finite(position.x), finite(position.y), finite(position.z)};
    out["rotation"] = {finite(rotation.x), finite(rotation.y), finite(rotation.z), finite(rotation.w)};
    out["scale"] = {finite(scale.x), finite(scale.y), finite(scale.z)};
    return out;
  }

  /// Adds a node below another one.
  void add_child(std::size_t parent, json node) {
    const int index = to_.glb.add("nodes", std::move(node));
    to_.glb.json["nodes"][parent]["children"].push_back(index);
  }

  /// Adds a mesh to a node: as its mesh, or as a child if it has bones or is not the only one.
  void add_mesh(std::size_t i, unsigned index) {
    const aiMesh& mesh = *to_.scene.mMeshes[index];
    meshes_.resize(to_.scene.mNumMeshes, -1);
    int& converted = meshes_[index];
    if (mesh.mNumFaces == 0) return;
    if (converted < 0) {
      json made = mesh_of(to_, mesh);
      if (mesh.mNumBones > 0) add_joints(mesh, made["primitives"][0]["attributes"]);
      converted = to_.glb.add("meshes", std::move(made));
    }
    if (nodes_[i]->mNumMeshes == 1 && mesh.mNumBones == 0) {
      to_.glb.json["nodes"][i]["mesh"] = converted;
      return;
    }
    json child = {{"name", text(nodes_[i]->mName)}, {"mesh", converted}};
    if (mesh.mNumBones > 0) child["skin"] = add_skin(mesh);
    add_child(i, std::move(child));
  }

  /// Adds the four bones of each vertex, as joints of add_skin().
  void add_joints(const aiMesh& mesh, json& attributes) {
    constexpr std::size_t kJoints = 4;
    const std::size_t count = mesh.mNumVertices;
    if (mesh.mNumBones > 0xffff) throw ImportError("has a mesh with more than 65535 bones");
    std::vector<std::uint16_t> joints(kJoints * count, 0);
    std::vector<float> weights(kJoints * count, 0);
    std::vector<std::size_t> used(count, 0);
    for (unsigned b = 0; b < mesh.mNumBones; ++b)
      for (unsigned k = 0; k < mesh.mBones[b]->mNumWeights; ++k) {
        const aiVertexWeight& weight = mesh.mBones[b]->mWeights[k];
        if (weight.mVertexId >= count || used[weight.mVertexId] == kJoints) continue;
        const std::size_t at = kJoints * weight.mVertexId + used[weight.mVertexId]++;
        joints[at] = static_cast<std::uint16_t>(b);
        weights[at] = static_cast<float>(finite(weight.mWeight));
      }
    attributes["JOINTS_0"] = to_.glb.add_accessor(joints, count, "VEC4");
    attributes["WEIGHTS_0"] = to_.glb.add_accessor(weights, count, "VEC4");
  }

  int add_skin(const aiMesh& mesh) {
    json joints = json::array();
    std::vector<float> matrices;
    for (unsigned b = 0; b < mesh.mNumBones; ++b) {
      const auto node = to_.nodes_of.find(text(mesh.mBones[b]->mName));
      if (node == to_.nodes_of.end())
        throw ImportError(fmt::format("has a bone '{}' without a node", text(mesh.mBones[b]->mName)));
      joints.push_back(node->second.front());
      for (const json& value : columns_of(mesh.mBones[b]->mOffsetMatrix)) matrices.push_back(value.get<float>());
    }
    const int inverse = to_.glb.add_accessor(matrices, mesh.mNumBones, "MAT4");
    return to_.glb.add("skins", {{"joints", std::move(joints)}, {"inverseBindMatrices", inverse}});
  }

  bool is_hidden(std::size_t i) const { return parts_[i] != nullptr && parts_[i]->is_hidden; }

  /// Adds the cameras and lights of a node.
  void add_parts(std::size_t i) {
    if (parts_[i] == nullptr) return;
    for (const Camera& from : parts_[i]->cameras) add_camera(from, i);
    if (is_hidden(i)) return;
    for (const Light& from : parts_[i]->lights) add_light(from, i);
  }

  void add_camera(const Camera& from, std::size_t parent) {
    constexpr double kNear = 1e-6, kFar = 1e12;
    json camera = {{"name", from.name}, {"type", from.is_perspective ? "perspective" : "orthographic"}};
    if (from.is_perspective) {
      camera["perspective"] = {{"yfov", from.yfov}, {"znear", kNear}};
      if (from.aspect > 0) camera["perspective"]["aspectRatio"] = from.aspect;
    } else {
      const double scale = scale_of(to_world_[parent]);  // glTF's views are not scaled by their nodes
      camera["orthographic"] = {{"xmag", finite(scale * from.xmag)}, {"ymag", finite(scale * from.ymag)}};
      camera["orthographic"].update({{"znear", kNear}, {"zfar", kFar}});
    }
    const int index = to_.glb.add("cameras", std::move(camera));
    const aiMatrix4x4 matrix = facing(vector(from.position), vector(from.forward), vector(from.up));
    add_child(parent, {{"name", from.name}, {"camera", index}, {"matrix", columns_of(matrix)}});
  }

  /// The center of all visible meshes.
  aiVector3D center() const {
    aiVector3D low(1e30f, 1e30f, 1e30f), high = -low;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      for (unsigned k = 0; k < nodes_[i]->mNumMeshes && !is_hidden(i); ++k) {
        const aiMesh& mesh = *to_.scene.mMeshes[nodes_[i]->mMeshes[k]];
        for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
          const aiVector3D p = to_world_[i] * mesh.mVertices[v];
          for (unsigned axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], p[axis]);
            high[axis] = std::max(high[axis], p[axis]);
          }
        }
      }
    return low.x <= high.x ? (low + high) * 0.5f : aiVector3D(0, 0, 0);
  }

  /// Adds a light. Lights of these formats have no photometric unit: one of color 1 makes a white surface that it
  /// faces white. At the center of the scene, glTF's inverse-square law and the file's attenuation agree.
  void add_light(const Light& from, std::size_t parent) {
    const bool is_directional = from.kind == Light::Kind::kDirectional, is_spot = from.kind == Light::Kind::kSpot;
    if (from.kind == Light::Kind::kOther) {
      to_.notes.push_back(
          fmt::format("light '{}' is neither directional nor a point or spot light (ignored)", from.name));
      return;
    }
    double intensity = std::numbers::pi;
    if (!is_directional) intensity *= squared_distance_over_attenuation(from, to_world_[parent]);
    const double largest = std::max({finite(from.color[0]), finite(from.color[1]), finite(from.color[2])});
    if (!(largest > 0)) return;
    const auto fraction = [&](double value) { return std::max(value, 0.0) / largest; };
    json light = {{"name", from.name}, {"type", is_directional ? "directional" : is_spot ? "spot" : "point"}};
    light["color"] = {fraction(from.color[0]), fraction(from.color[1]), fraction(from.color[2])};
    light["intensity"] = finite(intensity * largest);
    if (is_spot) {
      const double outer = std::clamp(finite(from.outer_angle), 1e-3, std::numbers::pi / 2);
      light["spot"] = {{"innerConeAngle", std::clamp(finite(from.inner_angle), 0.0, outer)}, {"outerConeAngle", outer}};
    }
    json& lights = to_.glb.json["extensions"]["KHR_lights_punctual"]["lights"];
    lights.push_back(std::move(light));
    json node = {{"name", from.name}};
    node["matrix"] = columns_of(facing(vector(from.position), vector(from.direction), {0, 1, 0}));
    node["extensions"]["KHR_lights_punctual"]["light"] = lights.size() - 1;
    add_child(parent, std::move(node));
  }

  /// The squared distance of a light from the center over the attenuation there, 1/cd per unit of illumination.
  double squared_distance_over_attenuation(const Light& from, const aiMatrix4x4& to_world) const {
    const double distance = std::max(double{(to_world * vector(from.position) - center_).Length()}, 1e-6);
    const double scale = scale_of(to_world);
    const double unscaled = scale > 0 ? distance / scale : distance;
    double attenuation = 0, power = 1;
    for (const double factor : from.attenuation) {
      attenuation += std::max(factor, 0.0) * power;
      power *= unscaled;
    }
    if (!(attenuation > 0) || !std::isfinite(attenuation)) attenuation = 1;
    return distance * distance / attenuation;
  }

  Conversion& to_;
  std::vector<const aiNode*> nodes_;
  std::vector<aiMatrix4x4> locals_, to_world_;
  std::vector<std::vector<int>> children_;
  std::set<std::string> moving_;         ///< names of animated nodes
  std::vector<const NodeParts*> parts_;  ///< of each node; may be null
  std::vector<int> meshes_;              ///< indices of converted meshes; -1: not yet
  aiVector3D center_{0, 0, 0};
};

}  // namespace

void add_nodes(Conversion& to) { NodeConverter(to).convert(); }

}  // namespace sheaf::importer
