// Meshes of glTF: triangles of all modes, morph targets and skins.
#include "scene/formats/mesh.h"
#include "scene/dialects/gltf/reader.h"
#include "scene/dialects/gltf/vertex_map.h"
#include "scene/formats/draco.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace sheaf::gltf {

namespace {

/// Joints and weights of a vertex come in up to this many sets of four.
constexpr int kMaxJointSets = 4;

/// Whether a texture of a material uses a set of texture coordinates.
bool uses_uv_set(const GltfMaterial& m, int set) {
  const GltfSpecularGlossiness none;
  const GltfSpecularGlossiness& glossy = m.specular_glossiness ? *m.specular_glossiness : none;
  for (const GltfTexture* texture :
       {&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture, &m.emissive_texture,
        &m.transmission_texture, &m.clearcoat_texture, &m.clearcoat_roughness_texture, &m.sheen_color_texture,
        &m.sheen_roughness_texture, &m.specular_texture, &m.specular_color_texture, &m.anisotropy_texture,
        &glossy.diffuse_texture, &glossy.specular_glossiness_texture})
    if (*texture && (*texture)->uv_set == set) return true;
  return false;
}

/// Whether a material depends on tangents.
bool uses_tangents(const GltfMaterial& m) { return m.normal_texture || m.anisotropy > 0; }

/// Loads one primitive.
class PrimitiveLoader {
 public:
  PrimitiveLoader(const GltfFile& file, const GltfPrimitive& from, std::string part)
      : file_(file), from_(from), part_(std::move(part)) {
    if (from_.draco) decompress();
  }

  /// Returns nothing for primitives without triangles.
  std::optional<Primitive> load(const Deformation& deformation, bool lenient, std::vector<std::string>& notes) {
    if (from_.mode < GltfPrimitive::Mode::kTriangles) {
      notes.push_back(file_.error(part_, "consists of points or lines (not rendered)").what());
      return std::nullopt;
    }
    if (!has("POSITION")) {
      notes.push_back(file_.error(part_, "has no positions (not rendered)").what());
      return std::nullopt;
    }
    out_.material = from_.material;
    note_ignored_targets(notes);
    load_vertices();
    load_triangles(lenient, notes);
    if (out_.mesh.triangles.empty()) return std::nullopt;
    morph(deformation.weights);
    skin(deformation.joint_to_skin);
    compact();
    return std::move(out_);
  }

 private:
  void decompress() {
    const GltfView& view = file_.views[static_cast<std::size_t>(from_.draco->view)];
    const std::span<const std::uint8_t> buffer(file_.buffers[static_cast<std::size_t>(view.buffer)]);
    draco_ = decode_draco(buffer.subspan(view.offset, view.length), from_.draco->ids);
    if (!draco_) throw file_.error(part_, "its mesh compressed by Draco is invalid");
  }

  bool has(const std::string& name) const { return from_.attributes.contains(name); }
  const GltfAccessor& accessor(int index) const { return file_.accessors[static_cast<std::size_t>(index)]; }

  /// The values of an attribute for each vertex. Throws SceneError for another number of components or of vertices.
  std::vector<float> values(const std::string& name, int components) const {
    const int index = from_.attributes.at(name);
    if (draco_) {
      const auto found = draco_->attributes.find(name);
      if (found != draco_->attributes.end()) return decompressed(found->second, accessor(index), name, components);
    }
    return values(index, name, components);
  }
  std::vector<float> values(int index, const std::string& name, int components) const {
    check_count(accessor(index).count, name);
    return read_floats(file_, index, components);
  }

  std::vector<float> decompressed(const DracoMesh::Attribute& attribute, const GltfAccessor& as,
                                  const std::string& name, int components) const {
    const auto size = static_cast<std::size_t>(components);
    if (attribute.components != components)
      throw file_.error(part_, fmt::format("{} has {} numbers, expected {}", name, attribute.components, components));
    check_count(attribute.values.size() / size, name);
    std::vector<float> out = attribute.values;
    if (!as.normalized || attribute.is_normalized) return out;
    constexpr float kLargest[] = {127, 255, 32767, 65535};
    const int type = static_cast<int>(as.type) - static_cast<int>(GltfComponent::kByte);
    if (type < 4)
      for (float& x : out) x = std::max(x / kLargest[type], -1.0f);
    return out;
  }

  /// Throws SceneError unless an attribute has a value for each vertex.
  void check_count(std::size_t count, const std::string& name) const {
    if (count != vertices_)
      throw file_.error(part_, fmt::format("{} has {} values for {} vertices", name, count, vertices_));
  }

  static std::vector<Vec3f> vectors(const std::vector<float>& values) {
    std::vector<Vec3f> out(values.size() / 3);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
    return out;
  }

  void load_vertices() {
    const int positions = from_.attributes.at("POSITION");
    vertices_ = accessor(positions).count;
    if (draco_ && draco_->attributes.contains("POSITION"))
      vertices_ = draco_->attributes.at("POSITION").values.size() / 3;
    out_.mesh.positions = vectors(values("POSITION", 3));
    out_.has_normals = has("NORMAL");
    if (out_.has_normals) out_.mesh.normals = vectors(values("NORMAL", 3));
    const GltfMaterial standard;
    const GltfMaterial& material =
        from_.material == kNoIndex ? standard : file_.materials[static_cast<std::size_t>(from_.material)];
    // Tangents belong to normals (glTF 2.0, 3.7.2.1)
    if (out_.has_normals && has("TANGENT") && uses_tangents(material)) load_tangents();
    load_uvs(material);
    if (has("COLOR_0")) load_colors();
  }

  void load_tangents() {
    const std::vector<float> xyzw = values("TANGENT", 4);
    out_.mesh.tangents.reserve(vertices_);
    for (std::size_t i = 0; i < vertices_; ++i) {
      const float* t = &xyzw[4 * i];
      out_.mesh.tangents.push_back({{t[0], t[1], t[2]}, t[3] < 0 ? -1.0f : 1.0f});
    }
  }

  void load_uvs(const GltfMaterial& material) {
    const int primary = primary_uv_set(material);
    for (const auto& [name, index] : from_.attributes) {
      constexpr std::string_view kPrefix = "TEXCOORD_";
      if (!name.starts_with(kPrefix)) continue;
      const int set = std::atoi(name.c_str() + kPrefix.size());
      if (set != primary && !uses_uv_set(material, set)) continue;
      const std::vector<float> uv = values(name, 2);
      if (set == primary) {
        for (std::size_t i = 0; i < vertices_; ++i) out_.mesh.uvs.push_back({uv[2 * i], 1 - uv[2 * i + 1]});
        continue;
      }
      Mesh::Attribute attribute{uv_attribute(set), 3, {}};
      for (std::size_t i = 0; i < vertices_; ++i)
        attribute.values.insert(attribute.values.end(), {uv[2 * i], 1 - uv[2 * i + 1], 0.0f});
      out_.mesh.attributes.push_back(std::move(attribute));
    }
  }

  void load_colors() {
    const std::string name = "COLOR_0";
    int components = accessor(from_.attributes.at(name)).components;
    if (draco_ && draco_->attributes.contains(name)) components = draco_->attributes.at(name).components;
    if (components != 3 && components != 4) throw file_.error(part_, "COLOR_0 is neither VEC3 nor VEC4");
    const std::vector<float> rgba = values(name, components);
    const auto stride = static_cast<std::size_t>(components);
    Mesh::Attribute color{"vertex_color", 3, {}}, alpha{"vertex_alpha", 1, {}};
    for (std::size_t i = 0; i < vertices_; ++i) {
      for (std::size_t k = 0; k < 3; ++k) color.values.push_back(std::clamp(rgba[i * stride + k], 0.0f, 1.0f));
      if (components == 4) alpha.values.push_back(std::clamp(rgba[i * stride + 3], 0.0f, 1.0f));
    }
    out_.vertex_data.has_color = true;
    out_.mesh.attributes.push_back(std::move(color));
    out_.vertex_data.has_alpha = components == 4;
    if (components == 4) out_.mesh.attributes.push_back(std::move(alpha));
  }

  void load_triangles(bool lenient, std::vector<std::string>& notes) {
    if (draco_) {
      out_.mesh.triangles = std::move(draco_->triangles);
      return;
    }
    std::vector<std::uint32_t> corners;
    if (from_.indices != kNoIndex) {
      corners = read_integers(file_, from_.indices, 1);
    } else {
      corners.resize(vertices_);
      for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = static_cast<std::uint32_t>(i);
    }
    std::size_t dropped = 0;
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      const std::uint32_t largest = std::max({a, b, c});
      if (largest < vertices_) {
        out_.mesh.triangles.push_back({a, b, c});
      } else if (lenient) {
        ++dropped;
      } else {
        throw file_.error(part_, fmt::format("a triangle refers to vertex {}, but there are {}", largest, vertices_));
      }
    };
    const std::size_t count = corners.size();
    if (from_.mode == GltfPrimitive::Mode::kTriangles) {
      for (std::size_t i = 0; i + 2 < count; i += 3) add(corners[i], corners[i + 1], corners[i + 2]);
    } else if (from_.mode == GltfPrimitive::Mode::kStrip) {
      for (std::size_t i = 0; i + 2 < count; ++i) add(corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]);
    } else {
      for (std::size_t i = 1; i + 1 < count; ++i) add(corners[i], corners[i + 1], corners[0]);
    }
    if (dropped > 0)
      notes.push_back(file_.error(part_, fmt::format("{} triangles without vertices ignored", dropped)).what());
  }

  void morph(const std::vector<float>& weights) {
    for (std::size_t t = 0; t < std::min(weights.size(), from_.targets.size()); ++t) {
      if (weights[t] == 0) continue;
      const auto add = [&](const char* name, auto& to, auto&& vector_of) {
        const auto found = from_.targets[t].find(name);
        if (found == from_.targets[t].end() || to.empty()) return;
        const std::vector<Vec3f> difference = vectors(values(found->second, name, 3));
        for (std::size_t i = 0; i < to.size(); ++i) {
          Vec3f& vector = vector_of(to[i]);
          vector = vector + difference[i] * weights[t];
        }
      };
      const auto itself = [](Vec3f& v) -> Vec3f& { return v; };
      add("POSITION", out_.mesh.positions, itself);
      add("NORMAL", out_.mesh.normals, itself);
      add("TANGENT", out_.mesh.tangents, [](MeshTangent& tangent) -> Vec3f& { return tangent.direction; });
    }
  }

  /// Notes the attributes of morph targets that are ignored.
  void note_ignored_targets(std::vector<std::string>& notes) const {
    std::set<std::string> ignored;
    for (const GltfAttributes& target : from_.targets)
      for (const auto& [name, index] : target)
        if (name.starts_with("COLOR_") || name.starts_with("TEXCOORD_")) ignored.insert(name);
    std::string names;
    for (const std::string& name : ignored) names += (names.empty() ? "" : ", ") + name;
    if (!names.empty())
      notes.push_back(
          file_.error(part_, fmt::format("its morph targets change {} (not supported: ignored)", names)).what());
  }

  /// Moves the vertices by the weighted mean of their joints' transforms.
  void skin(const std::vector<Matrix4>& joints) {
    if (joints.empty()) return;
    std::vector<Matrix4> sums(vertices_);
    for (Matrix4& sum : sums) sum.m = {};
    std::vector<double> totals(vertices_, 0);
    for (int set = 0; set < kMaxJointSets; ++set) {
      const std::string indices = fmt::format("JOINTS_{}", set), joint_weights = fmt::format("WEIGHTS_{}", set);
      if (!has(indices) || !has(joint_weights)) break;
      add_joints(values(indices, 4), values(joint_weights, 4), joints, sums, totals);
    }
    for (std::size_t i = 0; i < vertices_; ++i) {
      if (!(totals[i] > 0)) continue;
      for (auto& row : sums[i].m)
        for (double& x : row) x /= totals[i];
      VertexMap(sums[i]).apply(out_.mesh, i);
    }
  }

  void add_joints(const std::vector<float>& indices, const std::vector<float>& joint_weights,
                  const std::vector<Matrix4>& joints, std::vector<Matrix4>& sums, std::vector<double>& totals) const {
    for (std::size_t k = 0; k < indices.size(); ++k) {
      const double weight = joint_weights[k];
      if (!(weight > 0)) continue;
      const auto joint = static_cast<std::size_t>(std::clamp(indices[k], 0.0f, 65535.0f));
      if (joint >= joints.size())
        throw file_.error(part_, fmt::format("a vertex refers to joint {}, but the skin has {}", joint, joints.size()));
      totals[k / 4] += weight;
      for (std::size_t row = 0; row < 4; ++row)
        for (std::size_t column = 0; column < 4; ++column)
          sums[k / 4].m[row][column] += weight * joints[joint].m[row][column];
    }
  }

  /// Drops unused vertices of large shared arrays.
  void compact() {
    Mesh& mesh = out_.mesh;
    if (3 * mesh.triangles.size() >= mesh.positions.size()) return;
    std::vector<std::uint32_t> all(mesh.triangles.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint32_t>(i);
    mesh = extract_triangles(mesh, all);
  }

  const GltfFile& file_;
  const GltfPrimitive& from_;
  std::string part_;
  std::optional<DracoMesh> draco_;
  std::size_t vertices_ = 0;
  Primitive out_;
};

}  // namespace

int primary_uv_set(const GltfMaterial& material) {
  if (material.normal_texture) return material.normal_texture->uv_set;
  return material.base_color_texture ? material.base_color_texture->uv_set : 0;
}

std::string uv_attribute(int uv_set) { return fmt::format("vertex_uv{}", uv_set); }

std::vector<Primitive> load_mesh(GltfFile& file, int mesh, const Deformation& deformation, bool lenient) {
  const GltfMesh& from = file.meshes[static_cast<std::size_t>(mesh)];
  std::vector<Primitive> out;
  for (std::size_t i = 0; i < from.primitives.size(); ++i) {
    const std::string part = fmt::format("meshes[{}].primitives[{}]", mesh, i);
    auto primitive = PrimitiveLoader(file, from.primitives[i], part).load(deformation, lenient, file.notes);
    if (primitive) out.push_back(std::move(*primitive));
  }
  return out;
}

}  // namespace sheaf::gltf
