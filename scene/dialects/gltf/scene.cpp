// Scenes of glTF: nodes, instances, and what is chosen of cameras.
#include "scene/dialects/common/choose_camera.h"
#include "scene/dialects/common/moving_groups.h"
#include "scene/dialects/gltf/animation_keys.h"
#include "scene/dialects/gltf/deformation.h"
#include "scene/dialects/gltf/node_motion.h"
#include "scene/dialects/gltf/reader.h"
#include "scene/formats/mesh.h"

#include <algorithm>

namespace sheaf {

namespace gltf {

namespace {

/// The time at which the shutter opens.
std::optional<double> time_of_opening(const AnimationTime& moment, const ShutterDescription& shutter) {
  if (!moment.time) return std::nullopt;
  return *moment.time + shutter.open;
}

/// Reads the nodes of the default scene.
class SceneReader {
 public:
  SceneReader(GltfFile& file, const AnimationTime& moment, bool lenient, Description& out)
      : file_(file),
        pose_(pose_at(file, {time_of_opening(moment, out.shutter), moment.animation})),
        motions_(node_motions(file, moment, out.shutter, pose_)),
        deformations_(file, moment, out.shutter, lenient),
        lenient_(lenient),
        out_(out),
        materials_(file, out) {}

  GltfContents read(const std::string& camera) {
    list_nodes();
    place_camera(camera);
    count_uses();
    for (const std::size_t i : nodes_) {
      const GltfNode& node = file_.nodes[i];
      if (node.light != kNoIndex) add_light_of(i);
      if (node.mesh != kNoIndex) add_mesh(i);
    }
    if (degenerate_ > 0)
      file_.notes.push_back(
          fmt::format("{}: {} degenerate or non-finite triangles left out", file_.file.string(), degenerate_));
    std::move(file_.notes.begin(), file_.notes.end(), std::back_inserter(out_.notes));
    return contents_;
  }

 private:
  /// Mesh of a node with its morph weights. Nodes with skins and nodes whose meshes deform while the shutter is open do
  /// not share meshes.
  struct MeshKey {
    int mesh = kNoIndex, unshared_node = kNoIndex;
    std::vector<float> weights;
    auto operator<=>(const MeshKey&) const = default;
  };
  struct MeshUse {
    std::size_t count = 0;
    std::optional<std::uint32_t> group;
  };

  /// Lists the nodes of the scene, parents first.
  void list_nodes() {
    std::vector<int> open(file_.roots.rbegin(), file_.roots.rend());
    while (!open.empty()) {
      const auto i = static_cast<std::size_t>(open.back());
      open.pop_back();
      nodes_.push_back(i);
      const std::vector<int>& children = file_.nodes[i].children;
      open.insert(open.end(), children.rbegin(), children.rend());
    }
  }

  void place_camera(const std::string& requested) {
    std::vector<std::string> names;
    std::vector<std::size_t> nodes;
    for (const std::size_t i : nodes_) {
      const GltfNode& node = file_.nodes[i];
      if (node.camera == kNoIndex) continue;
      nodes.push_back(i);
      names.push_back(node.name.empty() ? file_.cameras[static_cast<std::size_t>(node.camera)].name : node.name);
    }
    contents_.has_camera = !nodes.empty();
    contents_.cameras = names;
    if (nodes.empty() && requested.empty()) return;
    const std::size_t i = nodes[choose_camera(requested, names, file_.file)];
    set_camera(file_.cameras[static_cast<std::size_t>(file_.nodes[i].camera)], directed_placement_of(i), file_, out_);
  }

  void add_light_of(std::size_t i) {
    const GltfLight& light = file_.lights[static_cast<std::size_t>(file_.nodes[i].light)];
    const NodePlacement node = directed_placement_of(i);
    contents_.has_lights = true;
    Matrix4 inverse;
    if (light.kind != GltfLight::Kind::kPoint && node.motion == nullptr && !invert(node.to_world, inverse))
      return note(i, "its transform is singular (the light has no direction and is ignored)");
    add_light(light, node, file_, out_);
  }

  /// The placement of a light or camera, which scales do not affect, not even scales of zero.
  NodePlacement directed_placement_of(std::size_t i) const {
    NodePlacement node = placement_of(i);
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t column = 0; column < 3; ++column)
        node.to_world.m[row][column] = pose_.directions[i].m[row][column];
    return node;
  }

  NodePlacement placement_of(std::size_t i) const { return {pose_.to_world[i], motions_[i] ? &*motions_[i] : nullptr}; }

  MeshKey key_of(std::size_t i) const {
    const GltfNode& node = file_.nodes[i];
    const bool is_unshared = node.skin != kNoIndex || deformations_.deforms(i);
    return {node.mesh, is_unshared ? static_cast<int>(i) : kNoIndex, weights_of(file_, pose_, i)};
  }

  void count_uses() {
    for (const std::size_t i : nodes_)
      if (file_.nodes[i].mesh != kNoIndex) uses_[key_of(i)].count += file_.nodes[i].instances.empty() ? 1 : 2;
  }

  /// The shapes of a mesh in its own space.
  std::vector<ShapeDescription> shapes(std::size_t i, const MeshKey& key) {
    std::vector<ShapeDescription> out;
    std::vector<Primitive> primitives =
        load_mesh(file_, key.mesh, deformation_of(file_, pose_, i, skin_origin(file_, pose_, i)), lenient_);
    std::vector<DeformingMesh> deforming;
    if (deformations_.deforms(i)) deforming = deformations_.meshes(i);
    for (std::size_t k = 0; k < primitives.size(); ++k) {
      Primitive& primitive = primitives[k];
      ShapeDescription shape;
      if (deforming.empty()) {
        degenerate_ += drop_degenerate_triangles(primitive.mesh);
        if (primitive.mesh.triangles.empty()) continue;
        shape.geometry = std::move(primitive.mesh);
      } else {
        shape.geometry = std::move(deforming[k]);
      }
      const Surface surface = materials_.surface(primitive.material, primitive.vertex_data);
      shape.face_normals = !primitive.has_normals;
      shape.material = surface.material;
      shape.radiance = surface.radiance;
      shape.radiance_scale = surface.radiance_scale;
      shape.emission_coat = surface.emission_coat;
      shape.emits_on_both_sides = surface.emits_on_both_sides;
      shape.interior = surface.interior;
      shape.exterior_is_surrounding = surface.interior.has_value();
      shape.where = {file_.file.string(), 0};
      shape.id =
          file_.nodes[i].name.empty() ? file_.meshes[static_cast<std::size_t>(key.mesh)].name : file_.nodes[i].name;
      out.push_back(std::move(shape));
    }
    return out;
  }

  void add_mesh(std::size_t i) {
    const MeshKey key = key_of(i);
    MeshUse& use = uses_.at(key);
    // Skins have the transforms of their joints
    const bool skinned = file_.nodes[i].skin != kNoIndex;
    const NodePlacement node =
        skinned ? NodePlacement{Transform::translate(skin_origin(file_, pose_, i)).matrix()} : placement_of(i);
    if (use.count == 1) {
      const std::optional<Placement> combined =
          node.motion != nullptr ? Placement(*node.motion) : combined_placement(node, Matrix4{});
      if (!combined) return note_collapsed(i);
      const Placement& placement = *combined;
      const Transform& transform = placement.to_world;
      const std::optional<MotionId> motion = add_motion(out_.motions, placement);
      for (ShapeDescription& shape : shapes(i, key)) {
        shape.to_world = transform;
        shape.motion = motion;
        // A mirrored mesh keeps its front: without normals, the order of its corners says where it is.
        shape.flip_normals = shape.face_normals && transform.swaps_handedness();
        out_.shapes.push_back(std::move(shape));
      }
      return;
    }
    if (!use.group) {
      use.group = static_cast<std::uint32_t>(out_.groups.size());
      out_.groups.push_back({shapes(i, key), file_.nodes[i].name, {file_.file.string(), 0}});
    }
    if (out_.groups[*use.group].shapes.empty()) return;
    add_instances(i, node, *use.group);
  }

  /// The placement of a node times `local`; nothing if it collapses to a line or a point.
  static std::optional<Placement> combined_placement(const NodePlacement& node, const Matrix4& local) {
    const std::optional<Matrix4> matrix = thickened(node.motion != nullptr ? local : node.to_world * local);
    if (!matrix) return std::nullopt;
    return node.motion != nullptr ? Placement(*node.motion) * Transform(*matrix) : Placement(Transform(*matrix));
  }

  void note_collapsed(std::size_t i) { note(i, "its transform collapses it to a line or a point (not rendered)"); }
  void note(std::size_t i, const std::string& message) {
    file_.notes.push_back(file_.error(fmt::format("nodes[{}]", i), message).what());
  }

  void add_instances(std::size_t i, const NodePlacement& node, std::uint32_t group) {
    bool collapsed = false;
    const auto add = [&](const Matrix4& local) {
      const std::optional<Placement> combined = combined_placement(node, local);
      collapsed = collapsed || !combined;
      if (!combined) return;
      const Placement& placement = *combined;
      out_.instances.push_back({rows_of(placement.to_world), group, add_motion(out_.motions, placement)});
    };
    const GltfAttributes& attributes = file_.nodes[i].instances;
    if (attributes.empty()) {
      add(Matrix4{});
    } else {
      for (const GltfPose& pose : instance_poses(attributes, i)) add(matrix_of(pose));
    }
    if (collapsed) note_collapsed(i);
  }

  /// The poses of EXT_mesh_gpu_instancing.
  std::vector<GltfPose> instance_poses(const GltfAttributes& attributes, std::size_t i) const {
    std::vector<GltfPose> poses(file_.accessors[static_cast<std::size_t>(attributes.begin()->second)].count);
    const auto load = [&](const char* name, int components, auto member) {
      const auto found = attributes.find(name);
      if (found == attributes.end()) return;
      const std::vector<float> values = read_floats(file_, found->second, components);
      const auto size = static_cast<std::size_t>(components);
      if (values.size() != poses.size() * size)
        throw file_.error(fmt::format("nodes[{}]", i), "its instances have attributes of different lengths");
      for (std::size_t k = 0; k < values.size(); ++k) (poses[k / size].*member)[k % size] = values[k];
    };
    load("TRANSLATION", 3, &GltfPose::translation);
    load("ROTATION", 4, &GltfPose::rotation);
    load("SCALE", 3, &GltfPose::scale);
    return poses;
  }

  GltfFile& file_;
  Pose pose_;
  std::vector<std::optional<AnimatedTransform>> motions_;  ///< by node; empty: does not move
  Deformations deformations_;
  bool lenient_;
  Description& out_;
  Materials materials_;
  std::vector<std::size_t> nodes_;  ///< of the scene
  std::map<MeshKey, MeshUse> uses_;
  GltfContents contents_;
  std::size_t degenerate_ = 0;  ///< triangles left out
};

}  // namespace

}  // namespace gltf

GltfContents read_gltf(const std::filesystem::path& file, const std::filesystem::path& folder,
                       const AnimationTime& moment, const std::string& camera, bool lenient, Description& description) {
  GltfFile gltf = read_gltf_file(file, folder);
  description.file = file;
  description.files = {file};
  description.files.insert(description.files.end(), gltf.files.begin(), gltf.files.end());
  GltfContents contents = gltf::SceneReader(gltf, moment, lenient, description).read(camera);
  for (const GltfAnimation& animation : gltf.animations)
    contents.animations.push_back({animation.name, gltf::time_range(gltf, animation)});
  return contents;
}

}  // namespace sheaf
