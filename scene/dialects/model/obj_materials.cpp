// Conversion of MTL materials, and splitting of OBJ meshes by material.
#include "scene/dialects/model/obj_materials.h"

#include "core/io/read_ahead.h"
#include "scene/dialects/common/covered_emission.h"
#include "scene/formats/mesh.h"
#include "scene/formats/obj.h"
#include "scene/formats/smooth_normals.h"
#include "scene/formats/text.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

namespace sheaf {

namespace {

constexpr float kSmallestAlpha = 1e-3f;

float largest(const std::optional<Vec3f>& color) { return color ? std::max({color->x, color->y, color->z}) : 0.0f; }

SpectrumDescription spectrum(Vec3f rgb) { return SpectrumDescription::rgb(rgb.x, rgb.y, rgb.z); }

/// Returns the index of refraction, or `default_value` if the file has none above 1.
float ior_or(const MtlMaterial& m, float default_value) { return m.ior && *m.ior > 1.0f ? *m.ior : default_value; }

/// Builds the descriptions of one material, innermost first.
class MaterialBuilder {
 public:
  MaterialBuilder(const MtlMaterial& m, bool flip_tex_coords, Description& out)
      : m_(m), flip_(flip_tex_coords), out_(out) {}

  MaterialId build() {
    if (is_glass()) return add(glass());
    MaterialId id = add(opaque());
    if (m_.normal) {
      id = add(NormalMapDescription{texture(*m_.normal, true), false, id});
    } else if (m_.bump) {
      id = add(BumpMapDescription{texture(*m_.bump, true), m_.bump->bump_multiplier, id});
    }
    id = add(TwoSidedDescription{id, id});
    const float dissolve = std::clamp(m_.dissolve.value_or(1.0f), 0.0f, 1.0f);
    if (m_.map_dissolve) return add(MaskDescription{texture(*m_.map_dissolve, true), id});
    if (dissolve < 1) return add(MaskDescription{dissolve, id});
    return id;
  }

 private:
  using Model = decltype(MaterialDescription::model);

  MaterialId add(Model model) {
    MaterialDescription material;
    material.model = std::move(model);
    material.id = m_.name;
    material.where = m_.where;
    out_.materials.push_back(std::move(material));
    return static_cast<MaterialId>(out_.materials.size() - 1);
  }

  TextureId texture(const MtlTexture& t, bool raw) {
    TextureDescription description;
    BitmapDescription bitmap;
    bitmap.file = t.file;
    out_.files.push_back(t.file);
    bitmap.raw = raw;
    if (t.clamp) bitmap.wrap_u = bitmap.wrap_v = TextureWrap::kClamp;
    description.model = std::move(bitmap);
    description.to_uv = {t.scale.x, 0, t.offset.x, 0, t.scale.y, t.offset.y};
    if (flip_) description.to_uv = {t.scale.x, 0, t.offset.x, 0, -t.scale.y, t.scale.y + t.offset.y};
    description.id = t.file.filename().string();
    description.where = t.where;
    out_.textures.push_back(std::move(description));
    return static_cast<TextureId>(out_.textures.size() - 1);
  }

  SpectrumInput color(const std::optional<Vec3f>& value, const std::optional<MtlTexture>& map, float default_value) {
    if (map) return texture(*map, false);
    return spectrum(value.value_or(Vec3f{default_value, default_value, default_value}));
  }
  ScalarInput number(const std::optional<float>& value, const std::optional<MtlTexture>& map, float default_value) {
    if (map) return texture(*map, true);
    return std::clamp(value.value_or(default_value), 0.0f, 1.0f);
  }
  SpectrumInput diffuse_color() { return color(m_.diffuse, m_.map_diffuse, 0.5f); }
  SpectrumInput specular_color() { return color(m_.specular, m_.map_specular, 1.0f); }

  bool has_illum(std::initializer_list<int> models) const {
    return m_.illum && std::find(models.begin(), models.end(), *m_.illum) != models.end();
  }
  bool is_glass() const {
    if (!has_illum({4, 6, 7, 9}) || m_.map_dissolve) return false;
    return m_.ior ? *m_.ior > 1.0f : m_.dissolve.value_or(1.0f) < 1.0f || largest(m_.transmission) > 0;
  }
  bool is_principled() const {
    return m_.roughness || m_.metallic || m_.sheen || m_.clearcoat || m_.anisotropy || m_.map_roughness ||
           m_.map_metallic || m_.map_sheen;
  }
  /// Whether the maximum channel of Ks exceeds `factor` times that of Kd.
  bool specular_exceeds(float factor) const {
    if (m_.map_diffuse) return false;
    const float specular = m_.map_specular ? std::max(largest(m_.specular), 1.0f) : largest(m_.specular);
    return specular > factor * (m_.diffuse ? largest(m_.diffuse) : 0.5f);
  }

  RoughnessDescription phong_roughness() const {
    constexpr float kExponent = 20;  // if the file has no Ns
    const float exponent = std::max(m_.shininess.value_or(kExponent), 0.0f);
    const float alpha = std::max(std::sqrt(2.0f / (exponent + 2.0f)), kSmallestAlpha);
    return {RoughnessDescription::Distribution::kBeckmann, alpha, alpha};
  }

  Model glass() {
    constexpr float kGlass = 1.5f;
    DielectricDescription d;
    d.int_ior = ior_or(m_, kGlass);
    d.ext_ior = 1;
    if (m_.roughness.value_or(0) > 0) {
      const float alpha = std::clamp(*m_.roughness * *m_.roughness, kSmallestAlpha, 1.0f);  // Burley 2012
      d.roughness = {RoughnessDescription::Distribution::kGgx, alpha, alpha};
    }
    d.specular_transmittance = spectrum(m_.transmission.value_or(Vec3f{1, 1, 1}));
    return d;
  }

  Model opaque() {
    if (is_principled()) return principled();
    const bool has_specular = largest(m_.specular) > 0 || m_.map_specular;
    if (!has_specular || has_illum({0, 1})) return DiffuseDescription{diffuse_color()};
    ConductorDescription metal;
    if (has_illum({3, 5}) && specular_exceeds(1)) {
      metal.specular_reflectance = specular_color();
      return metal;
    }
    if (specular_exceeds(10)) {
      metal.specular_reflectance = specular_color();
      metal.roughness = phong_roughness();
      return metal;
    }
    PlasticDescription plastic;
    plastic.int_ior = ior_or(m_, plastic.int_ior);
    plastic.ext_ior = 1;
    plastic.diffuse_reflectance = diffuse_color();
    plastic.specular_reflectance = specular_color();
    plastic.roughness = phong_roughness();
    return plastic;
  }

  Model principled() {
    PrincipledDescription p;
    p.base_color = diffuse_color();
    p.roughness = number(m_.roughness, m_.map_roughness, 0.5f);
    p.metallic = number(m_.metallic, m_.map_metallic, 0);
    p.sheen = number(m_.sheen, m_.map_sheen, 0);
    p.anisotropic = number(m_.anisotropy, {}, 0);
    p.clearcoat = number(m_.clearcoat, {}, 0);
    p.clearcoat_gloss = 1 - std::clamp(m_.clearcoat_roughness.value_or(0), 0.0f, 1.0f);
    p.eta = ior_or(m_, p.eta);
    return p;
  }

  const MtlMaterial& m_;
  bool flip_;
  Description& out_;
};

/// Quick test whether an OBJ file may use materials. False for unreadable files; reading the mesh later reports the
/// error.
bool may_use_materials(const std::filesystem::path& file) {
  constexpr std::string_view kWords[] = {"mtllib", "usemtl"};
  if (file.extension() == ".gz") {
    try {
      const std::string bytes = read_mesh_text(file, "OBJ file");
      return bytes.find(kWords[0]) != bytes.npos && bytes.find(kWords[1]) != bytes.npos;
    } catch (const SceneError&) { return false; }
  }
  // Read blocks that overlap by one word less a letter
  constexpr std::size_t kBlock = std::size_t{1} << 18, kOverlap = 5;
  std::error_code failure;
  if (!std::filesystem::is_regular_file(file, failure)) return false;
  std::ifstream stream(file, std::ios::binary);
  std::string block(kBlock, ' ');
  bool found[] = {false, false};
  while (stream && !(found[0] && found[1])) {
    std::copy(block.end() - kOverlap, block.end(), block.begin());
    stream.read(&block[kOverlap], kBlock - kOverlap);
    const std::string_view read(block.data(), kOverlap + static_cast<std::size_t>(stream.gcount()));
    for (std::size_t i = 0; i < 2; ++i) found[i] = found[i] || read.find(kWords[i]) != read.npos;
  }
  return found[0] && found[1];
}

/// Materials of MTL libraries. Each is read and added once.
class MaterialLibraries {
 public:
  MaterialLibraries(Description& description, ErrorSink& errors) : description_(description), errors_(errors) {}

  /// Returns the existing libraries in file order. Adds notes for missing ones; sets `complete` if all exist.
  std::vector<const MtlLibrary*> find(const std::vector<ObjLibrary>& named, bool& complete) {
    std::vector<const MtlLibrary*> found;
    complete = true;
    for (const ObjLibrary& line : named) {
      const std::filesystem::path folder = std::filesystem::path(line.where.file.string()).parent_path();
      if (const auto whole = find_file(folder, std::string(unquoted(line.names)))) {
        found.push_back(&read(*whole));
        continue;
      }
      for (const std::string& name : split(line.names)) {
        if (const auto file = find_file(folder, name)) {
          found.push_back(&read(*file));
        } else {
          note(line.where, fmt::format("material library '{}' not found, its materials are rendered as diffuse", name));
          complete = false;
        }
      }
    }
    return found;
  }

  MaterialId add(const MtlMaterial& material, bool flip_tex_coords) {
    const auto [found, is_new] = ids_.try_emplace({&material, flip_tex_coords}, MaterialId{});
    if (is_new) found->second = add_mtl_material(material, flip_tex_coords, description_);
    return found->second;
  }

  /// Sets the radiance Ke of a shape's material, covered by its opacity.
  void set_emission(const MtlMaterial& material, ShapeDescription& shape) {
    CoveredEmission emission = covered_emission(description_, spectrum(*material.emission), *shape.material);
    shape.radiance = std::move(emission.radiance);
    shape.radiance_scale = emission.scale;
  }

  void note(const SourceLocation& where, const std::string& message) {
    description_.notes.push_back(SceneError(where, message).what());
  }
  /// Reports an unknown material, which becomes a diffuse surface.
  void report(const SourceLocation& where, const std::string& message) {
    errors_.report(SceneError(where, message, SceneErrorCode::kUnknownName), "rendered as a diffuse surface");
  }

 private:
  static std::optional<std::filesystem::path> find_file(const std::filesystem::path& folder, std::string name) {
    std::replace(name.begin(), name.end(), '\\', '/');
    const std::filesystem::path file = folder / name;
    std::error_code failure;
    if (name.empty() || !std::filesystem::is_regular_file(file, failure)) return std::nullopt;
    return file;
  }

  /// Splits a line into words or quoted strings.
  static std::vector<std::string> split(const std::string& names) {
    std::vector<std::string> words;
    for (std::size_t at = names.find_first_not_of(" \t"); at != names.npos;) {
      const bool quoted = names[at] == '"' && names.find('"', at + 1) != names.npos;
      const std::size_t end =
          quoted ? names.find('"', at + 1) + 1 : std::min(names.find_first_of(" \t", at), names.size());
      words.emplace_back(unquoted(std::string_view(names).substr(at, end - at)));
      at = names.find_first_not_of(" \t", end);
    }
    return words;
  }

  const MtlLibrary& read(const std::filesystem::path& file) {
    const auto [found, is_new] = libraries_.try_emplace(file);
    if (is_new) {
      description_.files.push_back(file);
      found->second = read_mtl(file);
      for (const std::string& n : found->second.notes) description_.notes.push_back(n);
    }
    return found->second;
  }

  Description& description_;
  ErrorSink& errors_;
  std::map<std::filesystem::path, MtlLibrary> libraries_;
  std::map<std::pair<const MtlMaterial*, bool>, MaterialId> ids_;
};

const MtlMaterial* find_material(const std::vector<const MtlLibrary*>& libraries, const std::string& name) {
  for (const MtlLibrary* library : libraries) {
    for (const MtlMaterial& material : library->materials) {
      if (material.name == name) return &material;
    }
  }
  return nullptr;
}

/// Returns the material of each name that faces use, or null.
std::vector<const MtlMaterial*> find_materials(const ObjFile& obj, const std::string& file,
                                               MaterialLibraries& libraries) {
  bool complete = false;
  const std::vector<const MtlLibrary*> read = libraries.find(obj.libraries, complete);
  std::vector<std::string> names;
  for (const MtlLibrary* library : read) {
    for (const MtlMaterial& material : library->materials) names.push_back(material.name);
  }
  std::vector<const MtlMaterial*> found;
  for (std::size_t i = 0; i < obj.materials.size(); ++i) {
    const std::string& name = obj.materials[i];
    found.push_back(find_material(read, name));
    if (found.back() != nullptr || name.empty() || read.empty()) continue;
    const SourceLocation where{file, obj.material_lines[i]};
    const std::string similar = did_you_mean(name, names);
    if (complete) {
      libraries.report(where, fmt::format("material '{}' is in no material library of the file{}", name, similar));
    } else {
      libraries.note(where,
                     fmt::format("material '{}' is in no material library, rendered as diffuse{}", name, similar));
    }
  }
  return found;
}

/// Applies the processing steps that scene/formats/mesh.h lists, up to vertex normals. Works on the uncut mesh, so that
/// splitting leaves no seams. Leaves in `to_world`, the transform of the shape, what remains of it. Returns the number
/// of dropped triangles.
std::size_t place_in_world(ObjFile& obj, const ShapeDescription& shape, bool smooth_normals, bool creased,
                           Transform& to_world) {
  Mesh& mesh = obj.file.mesh;
  check_mesh(mesh, shape.where);
  if (shape.face_normals) mesh.normals.clear();
  if (!shape.motion) apply_linear_part(mesh, to_world);
  const std::size_t before = mesh.triangles.size();
  const std::vector<std::uint32_t> usable = usable_triangles(mesh);
  if (usable.size() < before) {
    mesh = extract_triangles(mesh, usable);
    for (std::size_t i = 0; i < usable.size(); ++i) obj.material_of[i] = obj.material_of[usable[i]];
    if (!obj.smoothing_of.empty())
      for (std::size_t i = 0; i < usable.size(); ++i) obj.smoothing_of[i] = obj.smoothing_of[usable[i]];
    if (!obj.smoothing_of.empty()) obj.smoothing_of.resize(usable.size());
  }
  if (!smooth_normals || shape.face_normals || !mesh.normals.empty()) return before - usable.size();
  if (creased) {
    compute_creased_normals(mesh, obj.smoothing_of);
  } else {
    compute_vertex_normals(mesh);
  }
  return before - usable.size();
}

/// Splits `shape` by material. Returns nothing if the shape stays as it is.
std::vector<ShapeDescription> cut(const ShapeDescription& shape, ObjFile obj, MaterialLibraries& libraries,
                                  bool creased) {
  const auto& geometry = std::get<MeshFileShape>(shape.geometry);
  const std::vector<const MtlMaterial*> materials = find_materials(obj, geometry.file.string(), libraries);
  std::vector<ShapeDescription> parts;
  const bool plain = std::all_of(materials.begin(), materials.end(), [](const MtlMaterial* m) { return m == nullptr; });
  if (plain && !creased) return parts;
  for (const std::string& warning : obj.file.warnings) libraries.note({geometry.file.string()}, warning);
  Transform to_world = shape.to_world;
  const std::size_t dropped = place_in_world(obj, shape, geometry.smooth_normals, creased, to_world);
  if (dropped > 0) {
    libraries.note(shape.where, fmt::format("{} degenerate or non-finite triangles ignored", dropped));
  }
  const Mesh& mesh = obj.file.mesh;
  // Collect the triangles of each material
  std::vector<std::vector<std::uint32_t>> triangles(materials.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) triangles[obj.material_of[i]].push_back(i);
  for (std::size_t i = 0; i < materials.size(); ++i) {
    if (triangles[i].empty()) continue;
    ShapeDescription part = shape;
    part.geometry = extract_triangles(mesh, triangles[i]);
    part.to_world = to_world;
    if (materials[i] != nullptr) {
      part.material = libraries.add(*materials[i], geometry.flip_tex_coords);
      if (largest(materials[i]->emission) > 0 && !part.radiance) libraries.set_emission(*materials[i], part);
    }
    parts.push_back(std::move(part));
  }
  return parts;
}

/// Whether a shape is an OBJ file whose materials count.
bool takes_materials(const ShapeDescription& shape) {
  const auto* file = std::get_if<MeshFileShape>(&shape.geometry);
  return file != nullptr && file->format == "obj" && !shape.material;
}

/// The jobs that read the OBJ files of shapes in order. Files without materials are not read; all are if `creased`.
std::vector<ReadAhead<std::optional<ObjFile>>::Job> obj_jobs(const std::vector<ShapeDescription>& shapes,
                                                             bool creased) {
  std::vector<ReadAhead<std::optional<ObjFile>>::Job> jobs;
  for (const ShapeDescription& shape : shapes) {
    if (!takes_materials(shape)) continue;
    const MeshFileShape file = std::get<MeshFileShape>(shape.geometry);
    const auto read = [file, creased]() -> std::optional<ObjFile> {
      if (!creased && !may_use_materials(file.file)) return std::nullopt;
      return read_obj_with_materials(file.file, file.flip_tex_coords, file.bad_faces);
    };
    jobs.push_back({read, mesh_reading_bytes(file)});
  }
  return jobs;
}

void expand(std::vector<ShapeDescription>& shapes, MaterialLibraries& libraries, ErrorSink& errors, bool creased) {
  std::vector<ShapeDescription> expanded;
  expanded.reserve(shapes.size());
  ReadAhead<std::optional<ObjFile>> files(obj_jobs(shapes, creased), read_ahead_bytes());
  std::size_t next_file = 0;
  for (ShapeDescription& shape : shapes) {
    std::vector<ShapeDescription> parts;
    if (takes_materials(shape)) {
      try {
        if (std::optional<ObjFile> obj = files.take(next_file++))
          parts = cut(shape, std::move(*obj), libraries, creased);
      } catch (const SceneError& error) {
        // A model without a scene file has no line; the error already names the file.
        errors.report(shape.where.line > 0 ? SceneError(shape.where, error) : error, "shape ignored");
        continue;
      }
    }
    if (parts.empty()) parts.push_back(std::move(shape));
    std::move(parts.begin(), parts.end(), std::back_inserter(expanded));
  }
  shapes = std::move(expanded);
}

}  // namespace

MaterialId add_mtl_material(const MtlMaterial& material, bool flip_tex_coords, Description& description) {
  return MaterialBuilder(material, flip_tex_coords, description).build();
}

void expand_obj_materials(Description& description, ErrorSink& errors, bool creased) {
  MaterialLibraries libraries(description, errors);
  expand(description.shapes, libraries, errors, creased);
  for (ShapeGroup& group : description.groups) expand(group.shapes, libraries, errors, creased);
}

}  // namespace sheaf
