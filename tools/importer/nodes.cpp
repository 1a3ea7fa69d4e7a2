// The hierarchy of nodes with their meshes, skins, cameras and lights.
#include "tools/importer/conversion.h"

#include <assimp/camera.h>
#include <assimp/light.h>
#include <assimp/version.h>

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

/// The transform of FBX's axes and units to y upwards and metres. Newer versions of Assimp set a similar one, without
/// the unit of FBX, centimetres.
std::optional<aiMatrix4x4> fbx_root(const aiScene& scene) {
  if (scene.mMetaData == nullptr) return std::nullopt;
  int axes[3] = {0, 1, 2}, signs[3] = {1, 1, 1};
  const char* const names[] = {"CoordAxis", "UpAxis", "FrontAxis"};
  for (int row = 0; row < 3; ++row) {
    scene.mMetaData->Get(names[row], axes[row]);
    scene.mMetaData->Get(names[row] + std::string("Sign"), signs[row]);
    if (axes[row] < 0 || axes[row] > 2) return std::nullopt;
  }
  float centimetres = 1;
  double exact = 1;
  if (scene.mMetaData->Get("UnitScaleFactor", exact)) {
    centimetres = static_cast<float>(exact);
  } else {
    scene.mMetaData->Get("UnitScaleFactor", centimetres);
  }
  if (!(centimetres > 0) || !std::isfinite(centimetres)) centimetres = 1;
  aiMatrix4x4 out;
  for (unsigned row = 0; row < 3; ++row)
    for (unsigned column = 0; column < 3; ++column)
      out[row][column] = static_cast<int>(column) == axes[row] ? static_cast<float>(signs[row]) * centimetres / 100 : 0;
  return out;
}

class NodeConverter {
 public:
  explicit NodeConverter(Conversion& to) : to_(to) {}

  void convert() {
    list_nodes();
    for (std::size_t i = 0; i < nodes_.size(); ++i) to_.glb.add("nodes", node(i));
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      for (unsigned k = 0; k < nodes_[i]->mNumMeshes; ++k) add_mesh(i, nodes_[i]->mMeshes[k]);
    for (unsigned i = 0; i < to_.scene.mNumCameras; ++i) add_camera(*to_.scene.mCameras[i]);
    if (to_.scene.mNumLights > 0) measure();
    for (unsigned i = 0; i < to_.scene.mNumLights; ++i) add_light(*to_.scene.mLights[i]);
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
      to_.node_of.try_emplace(text(node->mName), index);
      for (unsigned k = node->mNumChildren; k-- > 0;) open.emplace_back(node->mChildren[k], index);
    }
    for (unsigned i = 0; i < to_.scene.mNumAnimations; ++i)
      for (unsigned k = 0; k < to_.scene.mAnimations[i]->mNumChannels; ++k)
        moving_.insert(text(to_.scene.mAnimations[i]->mChannels[k]->mNodeName));
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
      const auto node = to_.node_of.find(text(mesh.mBones[b]->mName));
      if (node == to_.node_of.end())
        throw ImportError("has a bone '" + text(mesh.mBones[b]->mName) + "' without a node");
      joints.push_back(node->second);
      for (const json& value : columns_of(mesh.mBones[b]->mOffsetMatrix)) matrices.push_back(value.get<float>());
    }
    const int inverse = to_.glb.add_accessor(matrices, mesh.mNumBones, "MAT4");
    return to_.glb.add("skins", {{"joints", std::move(joints)}, {"inverseBindMatrices", inverse}});
  }

  /// The node that a camera or light belongs to.
  std::size_t node_named(const aiString& name) const {
    const auto found = to_.node_of.find(text(name));
    return found == to_.node_of.end() ? 0 : static_cast<std::size_t>(found->second);
  }

  void add_camera(const aiCamera& from) {
    constexpr double kAspect = 4.0 / 3, kAngle = 0.7;  // of cameras that do not say them
    const double aspect = from.mAspect > 0 && std::isfinite(from.mAspect) ? double{from.mAspect} : kAspect;
    // Assimp 5.3 and later give half of the angle for FBX.
    const bool is_half = to_.format == "fbx" && 100 * aiGetVersionMajor() + aiGetVersionMinor() >= 503;
    const double given = finite(from.mHorizontalFOV) * (is_half ? 2 : 1);
    const double angle = given > 0 ? std::clamp(given, 0.01, 3.1) : kAngle;
    json camera = {{"name", text(from.mName)}, {"type", "perspective"}};
    camera["perspective"] = {{"yfov", 2 * std::atan(std::tan(angle / 2) / aspect)}, {"aspectRatio", aspect}};
    camera["perspective"]["znear"] = 1e-6;
    const int index = to_.glb.add("cameras", std::move(camera));
    add_child(node_named(from.mName), {{"name", text(from.mName)},
                                       {"camera", index},
                                       {"matrix", columns_of(facing(from.mPosition, from.mLookAt, from.mUp))}});
  }

  /// Finds the centre of all meshes.
  void measure() {
    aiVector3D low(1e30f, 1e30f, 1e30f), high = -low;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      for (unsigned k = 0; k < nodes_[i]->mNumMeshes; ++k) {
        const aiMesh& mesh = *to_.scene.mMeshes[nodes_[i]->mMeshes[k]];
        for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
          const aiVector3D p = to_world_[i] * mesh.mVertices[v];
          for (unsigned axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], p[axis]);
            high[axis] = std::max(high[axis], p[axis]);
          }
        }
      }
    if (low.x <= high.x) centre_ = (low + high) * 0.5f;
  }

  /// Adds a light. Lights of these formats have no photometric unit: one of colour 1 makes a white surface that it
  /// faces white. At the centre of the scene, glTF's inverse-square law and the file's attenuation agree.
  void add_light(const aiLight& from) {
    const bool is_directional = from.mType == aiLightSource_DIRECTIONAL, is_spot = from.mType == aiLightSource_SPOT;
    if (!is_directional && !is_spot && from.mType != aiLightSource_POINT) {
      to_.notes.push_back("light '" + text(from.mName) +
                          "' is neither directional nor a point or spot light (ignored)");
      return;
    }
    const std::size_t parent = node_named(from.mName);
    double intensity = std::numbers::pi;
    if (!is_directional) intensity *= squared_distance_over_attenuation(from, to_world_[parent]);
    const aiColor3D& c = from.mColorDiffuse;
    const double largest = std::max({finite(c.r), finite(c.g), finite(c.b)});
    if (!(largest > 0)) return;
    const auto share = [&](double value) { return std::max(value, 0.0) / largest; };
    json light = {{"name", text(from.mName)}, {"type", is_directional ? "directional" : is_spot ? "spot" : "point"}};
    light["color"] = {share(c.r), share(c.g), share(c.b)};
    light["intensity"] = finite(intensity * largest);
    if (is_spot) {
      const double outer = std::clamp(finite(from.mAngleOuterCone) / 2, 1e-3, std::numbers::pi / 2);
      light["spot"] = {{"innerConeAngle", std::clamp(finite(from.mAngleInnerCone) / 2, 0.0, outer)},
                       {"outerConeAngle", outer}};
    }
    json& lights = to_.glb.json["extensions"]["KHR_lights_punctual"]["lights"];
    lights.push_back(std::move(light));
    json node = {{"name", text(from.mName)}};
    node["matrix"] = columns_of(facing(from.mPosition, from.mDirection, {0, 1, 0}));
    node["extensions"]["KHR_lights_punctual"]["light"] = lights.size() - 1;
    add_child(parent, std::move(node));
  }

  /// The squared distance of a light from the centre over the attenuation there, 1/cd per unit of illumination.
  double squared_distance_over_attenuation(const aiLight& from, const aiMatrix4x4& to_world) const {
    const double distance = std::max(double{(to_world * from.mPosition - centre_).Length()}, 1e-6);
    const double scale = std::cbrt(std::abs(double{to_world.Determinant()}));
    const double unscaled = scale > 0 ? distance / scale : distance;
    const double linear = std::max(from.mAttenuationLinear, 0.0f),
                 quadratic = std::max(from.mAttenuationQuadratic, 0.0f);
    double attenuation = linear * unscaled + quadratic * unscaled * unscaled;
    // The constant of FBX is the distance at which the decay starts.
    if (to_.format != "fbx") attenuation += std::max(from.mAttenuationConstant, 0.0f);
    if (!(attenuation > 0) || !std::isfinite(attenuation)) attenuation = 1;
    return distance * distance / attenuation;
  }

  Conversion& to_;
  std::vector<const aiNode*> nodes_;
  std::vector<aiMatrix4x4> locals_, to_world_;
  std::vector<std::vector<int>> children_;
  std::set<std::string> moving_;  ///< names of animated nodes
  std::vector<int> meshes_;       ///< indices of converted meshes; -1: not yet
  aiVector3D centre_{0, 0, 0};
};

}  // namespace

void add_nodes(Conversion& to) { NodeConverter(to).convert(); }

}  // namespace sheaf::importer
