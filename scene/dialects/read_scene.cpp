// Selection of the scene dialect: pbrt by file name, XML dialects by content.
#include "scene/dialects/read_scene.h"

#include "scene/dialects/mitsuba/read_mitsuba.h"
#include "scene/dialects/model/auto_camera.h"
#include "scene/dialects/model/obj_materials.h"
#include "scene/dialects/native_color.h"
#include "scene/dialects/nori/read_nori.h"
#include "scene/dialects/pbrt/read_pbrt.h"
#include "scene/dialects/read_model.h"
#include "scene/dialects/xml/read_spectrum.h"
#include "scene/dialects/xml/read_texture.h"
#include "scene/formats/model_formats.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>

namespace sheaf {

namespace {

constexpr std::array<std::string_view, 2> kPbrtExtensions{".pbrt", ".pbrt.gz"};

/// Whether an XML scene is in the Nori dialect: no <sensor> and no version, but a <camera> or a <mesh>.
bool is_nori(const XmlElement& root) {
  const auto has = [&](const char* name) {
    return std::any_of(root.children.begin(), root.children.end(), [&](const XmlElement& e) { return e.name == name; });
  };
  if (has("sensor") || root.find_attribute("version") != nullptr) return false;
  return has("camera") || has("mesh");
}

/// Renames elements and plugins from before Mitsuba 0.3.
void rename_old_plugins(ExpandedScene& scene) {
  constexpr ExpandedScene::ElementSynonym kElements[] = {{"camera", "sensor"}, {"luminaire", "emitter"}};
  constexpr ExpandedScene::PluginSynonym kPlugins[] = {
      {"bsdf", "lambertian", "diffuse"},        {"bsdf", "roughglass", "roughdielectric"},
      {"bsdf", "roughmetal", "roughconductor"}, {"bsdf", "composite", "mixturebsdf"},
      {"texture", "ldrtexture", "bitmap"},      {"texture", "exrtexture", "bitmap"},
      {"film", "exrfilm", "hdrfilm"},           {"film", "pngfilm", "ldrfilm"},
  };
  scene.rename(kElements, kPlugins);
}

/// Adds a white sky to a scene without lights, which would render black.
void add_default_light(Description& description) {
  const auto emits = [](const ShapeDescription& shape) { return shape.radiance.has_value(); };
  bool lit = !description.lights.empty() || std::any_of(description.shapes.begin(), description.shapes.end(), emits);
  for (const ShapeGroup& group : description.groups)
    lit = lit || std::any_of(group.shapes.begin(), group.shapes.end(), emits);
  for (const MediumDescription& medium : description.media) lit = lit || medium.emission || medium.temperature;
  if (lit || !description.integrator.traits().uses_lights()) return;
  description.lights.push_back({ConstantLightDescription{}, {}});
  description.substitutions.push_back(description.file.string() +
                                      ": the scene has no light (rendered with a white sky)");
}

}  // namespace

std::span<const SceneDialect> scene_dialects() {
  static const std::vector<SceneDialect> dialects{
      {"Mitsuba", {".xml"}}, {"Nori", {".xml"}}, {"pbrt", {kPbrtExtensions.begin(), kPbrtExtensions.end()}}};
  return dialects;
}

bool is_pbrt_scene(const std::filesystem::path& file) {
  return std::any_of(kPbrtExtensions.begin(), kPbrtExtensions.end(),
                     [&](std::string_view extension) { return file.string().ends_with(extension); });
}

ColorMode native_color(const std::filesystem::path& file) {
  return is_pbrt_scene(file) ? ColorMode::kSpectral : ColorMode::kRgb;
}

namespace {

/// Advice on converting a file of this kind, starting with a semicolon.
std::string conversion(FileUse use) {
  switch (use) {
    case FileUse::kModel:
      return "; convert it to glTF, for example with Blender";
    case FileUse::kImage:
      return "; use images as textures or environment maps in a scene";
    case FileUse::kScenePart:
      return "; use it in a scene";
    case FileUse::kArchive:
      return "; unpack it first";
    case FileUse::kUnknown:
    case FileUse::kEmpty:
      break;
  }
  return "";
}

/// Throws SceneError for files that are neither scenes nor models.
void check_format(const std::filesystem::path& file) {
  const ModelFormat* const model = find_model_format(file);
  const FileFormat format = file_or_model_format(file);
  if (format.use == FileUse::kUnknown || (format.use == FileUse::kArchive && is_pbrt_scene(file))) return;
  // The readers report better errors of their own formats, and of empty files with a known extension.
  if (model != nullptr && (model->read == nullptr || !format.by_content || format.name == model->known.name)) return;
  const bool is_named = file.extension() == ".xml" || is_pbrt_scene(file) || model != nullptr;
  if (format.use == FileUse::kEmpty && is_named) return;
  throw SceneError(
      {file.string(), 0},
      fmt::format("is {}, expected a scene of Mitsuba or Nori (.xml) or of pbrt ({}), or a model ({}){}", format.name,
                  fmt::join(kPbrtExtensions, ", "), model_extensions(), conversion(format.use)));
}

/// Makes file meshes drop faces that refer to missing vertices.
void drop_bad_faces(Description& description) {
  const auto drop = [](std::vector<ShapeDescription>& shapes) {
    for (ShapeDescription& shape : shapes) {
      if (auto* mesh = std::get_if<MeshFileShape>(&shape.geometry)) mesh->bad_faces = MeshFileShape::BadFaces::kDrop;
      if (auto* deforming = std::get_if<DeformingMesh>(&shape.geometry))
        for (DeformingMesh::Key& key : deforming->keys)
          if (auto* mesh = std::get_if<MeshFileShape>(&key.mesh)) mesh->bad_faces = MeshFileShape::BadFaces::kDrop;
    }
  };
  drop(description.shapes);
  for (ShapeGroup& group : description.groups) drop(group.shapes);
}

/// Throws Error for scenes of formats that have one camera.
void reject_camera_choice(const ReadOptions& options) {
  if (!options.camera.empty())
    throw Error(ExitCode::kUsage,
                fmt::format("--camera applies to scenes of Mitsuba and to models ({})", scene_model_extensions()));
}

/// Reads a scene of an XML dialect, which it detects. `file`: for messages.
Description read_xml_scene(ExpandedScene& scene, const std::filesystem::path& file, const ReadOptions& options) {
  const XmlElement& root = scene.root();
  if (root.name != "scene")
    throw SceneError(root.where, fmt::format("root element is <{}>, expected <scene>", root.name));
  Description description;
  description.file = file;
  description.substitutions = scene.substitutions();
  const bool nori = is_nori(root);
  if (nori) {
    reject_camera_choice(options);
    constexpr ExpandedScene::ElementSynonym kShape[] = {{"shape", "mesh"}};
    scene.rename(kShape);
  } else {
    rename_old_plugins(scene);
  }
  // Read the elements
  ErrorSink errors(options.lenient, description.substitutions);
  ReadContext context{scene, description, description, description.textures, description.materials, description.phases,
                      errors};
  context.mirrors_nori_camera = options.nori_camera == NoriCamera::kEth;
  context.camera = options.camera;
  context.needs_camera = options.contents == nullptr;
  context.readers.spectrum = read_property_spectrum;
  context.readers.scalar_texture = scalar_texture;
  errors.run([&] {
    if (nori) {
      read_nori(context);
    } else {
      read_mitsuba(context);
    }
    // Complete the description
    description.files = scene.files();
    if (options.lenient) drop_bad_faces(description);
    expand_obj_materials(description, errors);
    if (!options.lenient && context.needs_camera) return;
    if (context.frames_scene) frame_box(read_bounds(description, errors), options.view, description);
  });
  if (options.lenient) add_default_light(description);
  if (options.contents != nullptr) {
    options.contents->has_camera = !context.frames_scene;
    options.contents->cameras = std::move(context.cameras);
  }
  return description;
}

Description read_format(const std::filesystem::path& file, const ReadOptions& options) {
  check_format(file);
  if (find_model_format(file) != nullptr && !options.defines.empty())
    throw Error(ExitCode::kUsage, fmt::format("-D {}: models have no parameters", options.defines[0].first));
  if (reads_as_gltf(file)) return read_gltf_scene(file, options);
  if (reads_as_mesh(file)) {
    reject_camera_choice(options);
    return read_model(file, options.view, options.surroundings, options.lenient, options.contents);
  }
  if (is_pbrt_scene(file)) {
    reject_camera_choice(options);
    Description description;
    description.file = file;
    ErrorSink errors(options.lenient, description.substitutions);
    errors.run(
        [&] { read_pbrt(file, options.folder.value_or(file.parent_path()), description, options.defines, errors); });
    if (options.lenient) drop_bad_faces(description);
    return description;
  }
  ExpandedScene scene(file, options.defines, options.lenient, options.folder);
  return read_xml_scene(scene, file, options);
}

/// Adds a note if the scene has moving objects, but its own shutter opens at a single time.
void note_closed_shutter(Description& description, const ReadOptions& options) {
  const ShutterDescription& shutter = description.shutter;
  if (description.motions.empty() || options.shutter || shutter.close > shutter.open) return;
  description.notes.push_back(
      fmt::format("{}: moving objects rendered as at the time {}: the shutter is not open (set 'shutter_close' of the "
                  "sensor, or --shutter)",
                  description.file.string(), number_text(shutter.open)));
}

/// Applies the options that do not depend on the format, and defaults that depend on the whole scene.
Description completed(Description description, const ReadOptions& options) {
  if (options.shutter) description.shutter = *options.shutter;
  note_closed_shutter(description, options);
  // Early Russian roulette is efficient for surfaces. In absorbing media it causes rare samples of high weight.
  std::optional<int>& rr_depth = description.integrator.rr_depth;
  if (!description.media.empty() && !rr_depth) rr_depth = kDefaultRouletteDepth;
  return description;
}

}  // namespace

bool is_xml_scene(const std::filesystem::path& file) {
  return find_model_format(file) == nullptr && !is_pbrt_scene(file);
}

ExpandedScene expand_scene(const std::filesystem::path& file, const ReadOptions& options) {
  check_format(file);
  return {file, options.defines, options.lenient, options.folder};
}

Description read_scene(const std::filesystem::path& file, const ReadOptions& options) {
  return completed(read_format(file, options), options);
}

Description read_scene(ExpandedScene& scene, const std::filesystem::path& file, const ReadOptions& options) {
  return completed(read_xml_scene(scene, file, options), options);
}

}  // namespace sheaf
