// glTF 2.0 files (.gltf, .glb): the document with all its bytes, in structures of our own.
//
// Khronos Group, "glTF 2.0 Specification" (2021), and the extensions that scene/formats/gltf_library.cpp lists. All
// indices in these structures are in range or kNoIndex; accessors, views and buffers fit into each other.
#pragma once

#include "core/image/image.h"
#include "core/io/error.h"
#include "core/math/transform.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sheaf {

/// Marks an absent reference.
inline constexpr int kNoIndex = -1;

/// Component types of accessors, with the numbers of the specification.
enum class GltfComponent {
  kByte = 5120,
  kUnsignedByte = 5121,
  kShort = 5122,
  kUnsignedShort = 5123,
  kUnsignedInt = 5125,
  kFloat = 5126,
};

/// A part of a buffer.
struct GltfView {
  int buffer = kNoIndex;
  std::size_t offset = 0, length = 0;  ///< bytes
  std::size_t stride = 0;              ///< bytes between elements; 0: tightly packed
};

/// An array of scalars, vectors or matrices.
struct GltfAccessor {
  int view = kNoIndex;  ///< kNoIndex: all zero
  std::size_t offset = 0, count = 0;
  int components = 1;  ///< 1 to 4, 9 or 16
  GltfComponent type = GltfComponent::kFloat;
  bool normalized = false;  ///< integers represent fractions
  /// Elements that differ from those of the view.
  struct Sparse {
    std::size_t count = 0;
    int index_view = kNoIndex, value_view = kNoIndex;
    std::size_t index_offset = 0, value_offset = 0;
    GltfComponent index_type = GltfComponent::kUnsignedInt;
  };
  std::optional<Sparse> sparse;
};

/// An image in a file of its own or, if `encoded`, inside of the glTF file.
struct GltfImage {
  std::filesystem::path file;
  std::shared_ptr<const EncodedImage> encoded;
};

/// A use of a texture by a material.
struct GltfTextureUse {
  int image = kNoIndex;
  int uv_set = 0;
  enum class Wrap { kRepeat, kClamp, kMirror } wrap_u = Wrap::kRepeat, wrap_v = Wrap::kRepeat;
  bool nearest = false;  ///< no interpolation
  /// KHR_texture_transform: uv' = offset + rotation (scale uv); radians, counter-clockwise with v downwards.
  float offset[2] = {0, 0}, scale[2] = {1, 1}, rotation = 0;
};
using GltfTexture = std::optional<GltfTextureUse>;

/// KHR_materials_pbrSpecularGlossiness.
struct GltfSpecularGlossiness {
  Vec3f diffuse{1, 1, 1}, specular{1, 1, 1};
  float glossiness = 1;
  GltfTexture diffuse_texture, specular_glossiness_texture;
};

/// A material with its extensions.
struct GltfMaterial {
  std::string name;
  Vec3f base_color{1, 1, 1};
  float alpha = 1, metallic = 1, roughness = 1;
  GltfTexture base_color_texture, metallic_roughness_texture;
  GltfTexture normal_texture;
  float normal_scale = 1;
  Vec3f emissive{0, 0, 0};
  GltfTexture emissive_texture;
  float emissive_strength = 1;  ///< KHR_materials_emissive_strength
  enum class AlphaMode { kOpaque, kMask, kBlend } alpha_mode = AlphaMode::kOpaque;
  float alpha_cutoff = 0.5f;
  bool double_sided = false;
  bool unlit = false;    ///< KHR_materials_unlit
  float ior = 1.5f;      ///< KHR_materials_ior; 0: reflects everything at normal incidence
  float dispersion = 0;  ///< KHR_materials_dispersion: 20 over the Abbe number
  // KHR_materials_transmission and KHR_materials_volume
  float transmission = 0;
  GltfTexture transmission_texture;
  float thickness = 0;  ///< above 0: the surface encloses a volume
  float attenuation_distance = kInfinity;
  Vec3f attenuation_color{1, 1, 1};
  // KHR_materials_clearcoat
  float clearcoat = 0, clearcoat_roughness = 0;
  GltfTexture clearcoat_texture, clearcoat_roughness_texture;
  // KHR_materials_sheen
  Vec3f sheen_color{0, 0, 0};
  float sheen_roughness = 0;
  GltfTexture sheen_color_texture, sheen_roughness_texture;
  // KHR_materials_specular
  float specular = 1;
  Vec3f specular_color{1, 1, 1};
  GltfTexture specular_texture, specular_color_texture;
  // KHR_materials_anisotropy
  float anisotropy = 0, anisotropy_rotation = 0;  ///< radians
  GltfTexture anisotropy_texture;
  std::optional<GltfSpecularGlossiness> specular_glossiness;
};

/// Attribute names ("POSITION", "TEXCOORD_0" ...) and their accessors.
using GltfAttributes = std::map<std::string, int>;

/// KHR_draco_mesh_compression: replaces the data of a primitive's indices and of these attributes.
struct GltfDraco {
  int view = kNoIndex;
  std::map<std::string, int> ids;  ///< of attributes in the compressed mesh
};

/// A part of a mesh with one material.
struct GltfPrimitive {
  GltfAttributes attributes;
  int indices = kNoIndex, material = kNoIndex;
  enum class Mode { kPoints, kLines, kLineLoop, kLineStrip, kTriangles, kStrip, kFan } mode = Mode::kTriangles;
  std::vector<GltfAttributes> targets;  ///< morph targets: differences of positions, normals and tangents
  std::optional<GltfDraco> draco;
};

struct GltfMesh {
  std::string name;
  std::vector<GltfPrimitive> primitives;
  std::vector<float> weights;  ///< of morph targets; may be shorter than they are many
};

/// A node's transform as translation, rotation (quaternion x y z w) and scale.
struct GltfPose {
  std::array<double, 3> translation{0, 0, 0};
  std::array<double, 4> rotation{0, 0, 0, 1};
  std::array<double, 3> scale{1, 1, 1};
};

struct GltfNode {
  std::string name;
  std::vector<int> children;
  int mesh = kNoIndex, skin = kNoIndex, camera = kNoIndex, light = kNoIndex;
  std::optional<Matrix4> matrix;  ///< replaces `pose`
  GltfPose pose;
  std::vector<float> weights;  ///< replace those of the mesh
  GltfAttributes instances;    ///< EXT_mesh_gpu_instancing: TRANSLATION, ROTATION, SCALE; empty: one instance
};

struct GltfSkin {
  std::vector<int> joints;               ///< nodes
  int inverse_bind_matrices = kNoIndex;  ///< accessor; kNoIndex: identity
};

struct GltfAnimation {
  std::string name;
  struct Channel {
    int node = kNoIndex;
    enum class Path { kTranslation, kRotation, kScale, kWeights } path = Path::kTranslation;
    int times = kNoIndex, values = kNoIndex;  ///< accessors; times in seconds
    enum class Interpolation { kStep, kLinear, kCubic } interpolation = Interpolation::kLinear;
  };
  std::vector<Channel> channels;
};

struct GltfCamera {
  std::string name;
  bool perspective = true;
  double yfov = 0.8, aspect = 0;  ///< perspective: radians; width over height, 0: that of the image
  double xmag = 1, ymag = 1;      ///< orthographic: half of the width and of the height
  double near_clip = 0, far_clip = kInfinity;
  // Members of "extras" with Mitsuba's names
  double aperture_radius = 0, focus_distance = kInfinity;  ///< of a thin lens; 0: pinhole
  double principal_point_offset_x = 0,
         principal_point_offset_y = 0;  ///< to the left and upwards, fractions of the film
};

/// KHR_lights_punctual.
struct GltfLight {
  std::string name;
  enum class Kind { kDirectional, kPoint, kSpot } kind = Kind::kPoint;
  Vec3f color{1, 1, 1};
  double intensity = 1;                             ///< lx for directional lights, otherwise cd
  double inner_angle = 0, outer_angle = 0.7853982;  ///< spots: from the axis, radians
};

/// A glTF file.
struct GltfFile {
  std::filesystem::path file, folder;  ///< names in the file are relative to the folder
  std::string generator;
  std::vector<std::filesystem::path> files;  ///< external buffers and images
  std::vector<std::vector<std::uint8_t>> buffers;
  std::vector<GltfView> views;
  std::vector<GltfAccessor> accessors;
  std::vector<GltfImage> images;
  std::vector<GltfMaterial> materials;
  std::vector<GltfMesh> meshes;
  std::vector<GltfNode> nodes;  ///< a forest
  std::vector<GltfSkin> skins;
  std::vector<GltfAnimation> animations;
  std::vector<GltfCamera> cameras;
  std::vector<GltfLight> lights;
  std::vector<int> roots;  ///< nodes of the scene
  std::vector<std::string> notes;

  /// Error or note about a part of the file, such as "materials[3]".
  SceneError error(const std::string& part, const std::string& message) const {
    return SceneError(SourceLocation{file.string(), 0}, fmt::format("{}: {}", part, message));
  }
};

/// Reads a glTF file with its external buffers and images. Throws SceneError if files are missing, if the document is
/// malformed or invalid, and for required extensions that are not supported. `folder`: see GltfFile.
GltfFile read_gltf_file(const std::filesystem::path& file, const std::filesystem::path& folder);

/// Bytes of an element: columns of matrices are padded to multiples of four.
std::size_t element_bytes(GltfComponent type, int components);

/// Elements of an accessor as floats, `components` each; normalized integers are converted to [0, 1] or [-1, 1]. Throws
/// SceneError if the accessor has another number of components.
std::vector<float> read_floats(const GltfFile& file, int accessor, int components);

/// Elements of an accessor of unsigned integers. Throws SceneError for other types.
std::vector<std::uint32_t> read_integers(const GltfFile& file, int accessor, int components);

}  // namespace sheaf
