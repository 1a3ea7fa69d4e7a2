// The parts of the glTF dialect, which scene.cpp puts together.
#pragma once

#include "scene/description.h"
#include "scene/formats/gltf.h"

#include <map>
#include <optional>
#include <tuple>
#include <vector>

namespace sheaf::gltf {

/// Vertex data of a primitive on which its material depends.
struct VertexData {
  bool has_color = false, has_alpha = false;
  auto operator<=>(const VertexData&) const = default;
};

/// A primitive as a mesh. Texture coordinates have v upwards. The mesh's uvs are those of primary_uv_set(); the other
/// sets are the attributes that uv_attribute() names.
struct Primitive {
  Mesh mesh;
  bool has_normals = false;
  int material = kNoIndex;
  VertexData vertex_data;
};

/// Deformation of a mesh.
struct Deformation {
  std::vector<float> weights;          ///< of morph targets
  std::vector<Matrix4> joint_to_skin;  ///< with the inverse bind matrices, relative to skin_origin(); empty: no skin
};

/// The texture coordinates along which a material's tangents run.
int primary_uv_set(const GltfMaterial& material);

/// Name of the mesh attribute with texture coordinates.
std::string uv_attribute(int uv_set);

/// Loads the primitives of a mesh that have triangles. `lenient`: drops triangles with vertices out of range. Throws
/// SceneError.
std::vector<Primitive> load_mesh(GltfFile& file, int mesh, const Deformation& deformation, bool lenient);

/// A surface's material, and what belongs to the shape.
struct Surface {
  MaterialId material{};
  std::optional<SpectrumInput> radiance;
  std::optional<TextureId> radiance_scale;
  ScalarInput emission_coat = 0.0f;
  bool emits_on_both_sides = false;
  std::optional<MediumId> interior;
};

/// Adds materials to a scene, each once.
class Materials {
 public:
  Materials(const GltfFile& file, Description& out) : file_(file), out_(out) {}

  /// The surface of a primitive with this material; kNoIndex: the default material.
  Surface surface(int material, const VertexData& data);

 private:
  friend class MaterialBuilder;
  using TextureKey = std::tuple<int, int, bool, int, int, bool, std::array<float, 6>, int>;

  const GltfFile& file_;
  Description& out_;
  std::map<std::pair<int, VertexData>, Surface> surfaces_;
  std::map<TextureKey, TextureId> textures_;
};

/// The placement of a node: its transform at the moment, and if it moves while the shutter is open, its motion.
struct NodePlacement {
  Matrix4 to_world;
  const AnimatedTransform* motion = nullptr;
};

/// Adds a light of KHR_lights_punctual.
void add_light(const GltfLight& light, const NodePlacement& node, const GltfFile& file, Description& out);

/// Sets the camera and the size of the image.
void set_camera(const GltfCamera& camera, const NodePlacement& node, const GltfFile& file, Description& out);

}  // namespace sheaf::gltf
