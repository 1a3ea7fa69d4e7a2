// Scenes around a single model: its materials, a floor, a sky and a camera.
#include "scene/dialects/read_model.h"

#include "core/frame.h"
#include "scene/dialects/common/auto_camera.h"
#include "scene/dialects/common/obj_materials.h"
#include "scene/formats/mesh.h"
#include "scene/formats/mesh_io.h"
#include "scene/formats/smooth_normals.h"

#include <algorithm>
#include <cctype>

namespace sheaf {

namespace {

/// Ratio of floor size to model size; the floor's edge is near the horizon.
constexpr float kFloor = 200;

/// Returns a disk below the box, perpendicular to `up`.
ShapeDescription make_floor(const std::array<Vec3f, 2>& box, Vec3f up, MaterialId material) {
  const Vec3f center = box[0] * 0.5f + box[1] * 0.5f;
  const Vec3f half = box[1] * 0.5f - box[0] * 0.5f;
  const float radius = kFloor * std::max(length(half), 1e-6f);
  const Vec3f foot = center - up * dot(up, half);
  const Frame<Scalar> frame = Frame<Scalar>::from_normal(up);
  Matrix4 m;
  const Vec3f columns[4] = {frame.s * radius, frame.t * radius, up, foot};
  for (std::size_t j = 0; j < 4; ++j) {
    m.m[0][j] = columns[j].x;
    m.m[1][j] = columns[j].y;
    m.m[2][j] = columns[j].z;
  }
  ShapeDescription floor;
  floor.geometry = DiskShape{};
  floor.to_world = Transform(m);
  floor.material = material;
  return floor;
}

MaterialId add_two_sided(Description& description, DiffuseDescription diffuse) {
  MaterialDescription material;
  material.model = std::move(diffuse);
  MaterialDescription both;
  description.materials.push_back(std::move(material));
  const auto id = static_cast<MaterialId>(description.materials.size() - 1);
  both.model = TwoSidedDescription{id, id};
  description.materials.push_back(std::move(both));
  return static_cast<MaterialId>(description.materials.size() - 1);
}

MaterialId add_diffuse(Description& description, Vec3f reflectance) {
  return add_two_sided(description, {SpectrumDescription{SpectrumDescription::Rgb{reflectance}}});
}

/// Adds a constant sky and a sun over the viewer's left shoulder.
void add_sky(Description& description, const ModelView& view, const std::array<Vec3f, 2>& box) {
  constexpr Vec3f kSky{0.52f, 0.58f, 0.68f}, kSun{1.9f, 1.75f, 1.5f};
  description.lights.push_back({ConstantLightDescription{{SpectrumDescription::Rgb{kSky}}}, {}});
  const Vec3f center = box[0] * 0.5f + box[1] * 0.5f;
  const Vec3f up = up_vector(view);
  const Vec3f eye = description.camera.to_world.point({0, 0, 0});
  Vec3f front = eye - center;
  front = front - up * dot(up, front);
  front = length_squared(front) > 0.0f ? normalize(front) : Frame<Scalar>::from_normal(up).s;
  const Vec3f left = cross(front, up);
  DirectionalLightDescription sun;
  sun.direction = -(up * 1.0f + front * 0.5f + left * 0.6f);
  sun.irradiance = {SpectrumDescription::Rgb{kSun}};
  description.lights.push_back({std::move(sun), {}});
}

/// Adds a two-sided diffuse material with a texture.
MaterialId add_textured(Description& description, TextureDescription texture, const std::filesystem::path& file) {
  texture.where = {file.string(), 0};
  description.textures.push_back(std::move(texture));
  const auto id = static_cast<TextureId>(description.textures.size() - 1);
  return add_two_sided(description, DiffuseDescription{id});
}

/// Returns the material of a model's texture image or colours, if it has any.
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
    description.notes.push_back(SceneError({file.string(), 0}, "texture '" + name + "' not found").what());
  }
  for (const char* name : {"vertex_color", "face_color"})
    for (const Mesh::Attribute& attribute : model.mesh.attributes) {
      if (attribute.name != name || attribute.channels != 3) continue;
      texture.model = MeshAttributeDescription{name};
      return add_textured(description, std::move(texture), file);
    }
  return std::nullopt;
}

/// Loads the mesh file of a shape into memory, computes creased normals if it has none, and applies its colours.
void load_model(ShapeDescription& shape, const MeshFileShape& from, Description& description) {
  MeshFile model = read_mesh(from);
  Mesh& mesh = model.mesh;
  for (const std::string& w : model.warnings) description.notes.push_back(from.file.string() + ": " + w);
  check_mesh(mesh, shape.where);
  shape.face_normals = model.face_normals;
  const std::size_t dropped = drop_degenerate_triangles(mesh);
  if (dropped > 0)
    description.notes.push_back(from.file.string() + ": " + std::to_string(dropped) +
                                " degenerate or non-finite triangles ignored");
  if (!shape.face_normals && mesh.normals.empty()) compute_creased_normals(mesh, {});
  shape.material = color_material(model, from.file, description);
  shape.geometry = std::move(mesh);
}

}  // namespace

std::optional<MeshFileShape::Format> model_format(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension == ".obj") return MeshFileShape::Format::kObj;
  if (extension == ".ply") return MeshFileShape::Format::kPly;
  if (extension == ".serialized") return MeshFileShape::Format::kSerialized;
  return std::nullopt;
}

Description read_model(const std::filesystem::path& file, MeshFileShape::Format format, const ModelView& view,
                       bool lenient) {
  Description description;
  description.file = file;
  description.files = {file};
  ShapeDescription shape;
  // Flip v of OBJ and PLY files; the textures that they name undo the flip.
  MeshFileShape mesh{file, format, format != MeshFileShape::Format::kSerialized};
  if (lenient) mesh.bad_faces = MeshFileShape::BadFaces::kDrop;
  shape.geometry = std::move(mesh);
  shape.where = {file.string(), 0};
  description.shapes.push_back(std::move(shape));
  expand_obj_materials(description, lenient, true);
  if (description.shapes.empty()) throw SceneError(description.stand_ins.back());
  // Load the model and place the camera
  for (ShapeDescription& part : description.shapes)
    if (const auto* from = std::get_if<MeshFileShape>(&part.geometry))
      load_model(part, MeshFileShape(*from), description);
  const std::array<Vec3f, 2> box = read_bounds(description, lenient);
  frame_box(box, view, description);
  // Add floor, light and default materials
  const MaterialId grey = add_diffuse(description, {0.6f, 0.6f, 0.6f});
  for (ShapeDescription& part : description.shapes)
    if (!part.material) part.material = grey;
  description.shapes.push_back(make_floor(box, up_vector(view), add_diffuse(description, {0.45f, 0.43f, 0.41f})));
  add_sky(description, view, box);
  description.film.width = 800;
  description.film.height = 600;
  description.film.filter = {PixelFilter::Kind::kGaussian, 2.0f, 0.5f};
  description.sampler.sample_count = 64;
  return description;
}

}  // namespace sheaf
