// Scenes around a single model: its materials, surroundings and a camera.
#include "scene/dialects/read_model.h"

#include "scene/dialects/gltf/read_gltf.h"
#include "scene/dialects/model/auto_camera.h"
#include "scene/dialects/model/obj_materials.h"
#include "scene/dialects/model/surroundings.h"
#include "scene/formats/mesh.h"
#include "scene/formats/mesh_io.h"
#include "scene/formats/model_formats.h"
#include "scene/formats/smooth_normals.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Adds a two-sided diffuse material with a texture.
MaterialId add_textured(Description& description, TextureDescription texture, const std::filesystem::path& file) {
  texture.where = {file.string(), 0};
  description.textures.push_back(std::move(texture));
  const auto id = static_cast<TextureId>(description.textures.size() - 1);
  return add_two_sided(description, DiffuseDescription{id});
}

/// Returns the material of a model's texture image or colors, if it has any.
std::optional<MaterialId> color_material(const MeshFile& model, const std::filesystem::path& file,
                                         Description& description) {
  TextureDescription texture;
  if (!model.texture.empty() && !model.mesh.uvs.empty()) {
    std::string name = model.texture;
    std::replace(name.begin(), name.end(), '\\', '/');
    const std::filesystem::path image = file.parent_path() / name;
    std::error_code failure;
    if (std::filesystem::is_regular_file(image, failure)) {
      BitmapDescription bitmap;
      bitmap.file = image;
      description.files.push_back(image);
      texture.model = std::move(bitmap);
      texture.to_uv = {1, 0, 0, 0, -1, 1};  // undoes the flip of v in read_model()
      return add_textured(description, std::move(texture), file);
    }
    description.notes.push_back(SceneError({file.string(), 0}, fmt::format("texture '{}' not found", name)).what());
  }
  for (const char* name : {"vertex_color", "face_color"})
    for (const Mesh::Attribute& attribute : model.mesh.attributes) {
      if (attribute.name != name || attribute.channels != 3) continue;
      texture.model = MeshAttributeDescription{name};
      return add_textured(description, std::move(texture), file);
    }
  return std::nullopt;
}

/// Loads the mesh file of a shape into memory, computes creased normals if it has none, and applies its colors.
void load_model(ShapeDescription& shape, const MeshFileShape& from, Description& description) {
  MeshFile model = read_mesh(from);
  Mesh& mesh = model.mesh;
  for (const std::string& w : model.warnings) description.notes.push_back(fmt::format("{}: {}", from.file.string(), w));
  check_mesh(mesh, shape.where);
  shape.face_normals = model.face_normals;
  const std::size_t dropped = drop_degenerate_triangles(mesh);
  if (dropped > 0)
    description.notes.push_back(
        fmt::format("{}: {} degenerate or non-finite triangles ignored", from.file.string(), dropped));
  if (!shape.face_normals && mesh.normals.empty()) compute_creased_normals(mesh, {});
  shape.material = color_material(model, from.file, description);
  shape.geometry = std::move(mesh);
}

}  // namespace

bool has_studio(const Description& description) {
  if (find_model_format(description.file) == nullptr) return false;
  const auto is_added = [](const auto& object) { return object.id.starts_with(kStudioPrefix); };
  return std::any_of(description.shapes.begin(), description.shapes.end(), is_added) ||
         std::any_of(description.lights.begin(), description.lights.end(), is_added);
}

bool reads_as_gltf(const std::filesystem::path& file) {
  const ModelFormat* const format = find_model_format(file);
  return format != nullptr && format->read == nullptr;
}

bool reads_as_mesh(const std::filesystem::path& file) {
  const ModelFormat* const format = find_model_format(file);
  return format != nullptr && format->read != nullptr;
}

Description read_model(const std::filesystem::path& file, const ModelView& view, const ModelEnvironment& surroundings,
                       bool lenient, FileContents* contents) {
  Description description;
  description.file = file;
  description.files = {file};
  ShapeDescription shape;
  // Flip v of OBJ and PLY files; the textures that they name undo the flip.
  MeshFileShape mesh{file, find_model_format(file)->key, true};
  if (lenient) mesh.bad_faces = MeshFileShape::BadFaces::kDrop;
  shape.geometry = std::move(mesh);
  shape.where = {file.string(), 0};
  description.shapes.push_back(std::move(shape));
  ErrorSink errors(lenient, description.substitutions);
  expand_obj_materials(description, errors, true);
  // Nothing replaces the only shape
  if (description.shapes.empty()) throw errors.errors().back();
  errors.throw_errors();
  // Load the model and place the camera
  for (ShapeDescription& part : description.shapes)
    if (const auto* from = std::get_if<MeshFileShape>(&part.geometry))
      load_model(part, MeshFileShape(*from), description);
  const std::array<Vec3d, 2> box = read_bounds(description, errors);
  if (contents != nullptr) *contents = {false, {}, {}, box};
  // Add default materials, surroundings and a camera
  const MaterialId gray = add_two_sided(description, {SpectrumDescription::rgb(0.6f, 0.6f, 0.6f)});
  for (ShapeDescription& part : description.shapes)
    if (!part.material) part.material = gray;
  add_studio(box, view, surroundings, description);
  set_model_defaults(description);
  return description;
}

Description read_gltf_scene(const std::filesystem::path& file, const ReadOptions& options) {
  Description description;
  set_model_defaults(description);
  if (options.shutter) description.shutter = *options.shutter;
  GltfContents contents = read_gltf(file, options.folder.value_or(file.parent_path()), options.moment, options.camera,
                                    options.lenient, description);
  std::array<Vec3d, 2> box{Vec3d{-1, -1, -1}, Vec3d{1, 1, 1}};
  if (!description.shapes.empty() || !description.instances.empty()) {
    ErrorSink errors(options.lenient, description.substitutions);
    box = read_bounds(description, errors);
    errors.throw_errors();
    contents.model_bounds = box;
  } else {
    // An animation may hide everything for a while
    const SceneError nothing({file.string(), 0}, "has no triangles to render");
    if (!contents.has_camera) throw nothing;
    description.notes.push_back(nothing.what());
  }
  if (options.contents != nullptr) *options.contents = contents;
  if (!contents.has_camera && !contents.has_lights) {
    add_studio(box, options.view, options.surroundings, description);
    return description;
  }
  if (options.surroundings.studio)
    description.notes.push_back(file.string() + ": has a camera or lights of its own (--studio ignored)");
  if (!contents.has_camera) frame_box(box, options.view, description);
  if (!contents.has_lights || !options.surroundings.environment.empty())
    add_sky(box, options.view, options.surroundings, description);
  return description;
}

}  // namespace sheaf
