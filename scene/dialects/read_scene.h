// Reads a scene file of any dialect.
#pragma once

#include "scene/description.h"
#include "scene/dialects/common/file_contents.h"
#include "scene/dialects/model/model_view.h"
#include "scene/xml/xml_expand.h"

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sheaf {

/// Handedness of Nori's camera space. Images of the two variants mirror each other.
enum class NoriCamera { kEth, kUpstream };

/// Options of reading.
struct ReadOptions {
  std::vector<std::pair<std::string, std::string>> defines;  ///< -D name=value: the value of `$name` in the file
  bool lenient = false;  ///< substitute or drop unreadable elements; see Description::substitutions
  NoriCamera nori_camera = NoriCamera::kEth;
  /// Folder to which relative paths in the scene file refer. Default: that of the file.
  std::optional<std::filesystem::path> folder;
  ModelView view;  ///< for models and, if lenient, scenes without a camera
  ModelEnvironment surroundings;
  AnimationTime moment;
  std::string camera;  ///< name or number of a camera, in glTF files and scenes of Mitsuba; empty: the first
  /// Replaces the shutter of the scene. For models, its times are relative to `moment.time`.
  std::optional<ShutterDescription> shutter;
  /// Receives the contents of the file, unless null; a scene without a camera is then no error.
  FileContents* contents = nullptr;
};

/// A dialect of scene files.
struct SceneDialect {
  const char* name;
  std::vector<std::string_view> extensions;  ///< with their dots
};

std::span<const SceneDialect> scene_dialects();

/// Reads a scene file. Files named .pbrt or .pbrt.gz are pbrt-v4. XML files are Nori (`camera`, no version) or Mitsuba
/// 0.6 to 3 (`sensor`, `version`), chosen by content. Files of the formats of scene/formats/model_formats.h are models:
/// glTF and imported ones may be a whole scene, meshes are placed in a studio. Mesh files are located but
/// not loaded, except for models and for OBJ files whose materials are used (scene/dialects/model/obj_materials.h).
/// Throws SceneError.
Description read_scene(const std::filesystem::path& file, const ReadOptions& options = {});

/// Whether read_scene() reads the file as XML: neither pbrt nor glTF nor a model.
bool is_xml_scene(const std::filesystem::path& file);

/// The first half of read_scene() for an XML scene, for programs that change the tree. Throws SceneError.
ExpandedScene expand_scene(const std::filesystem::path& file, const ReadOptions& options);

/// The second half. Renames elements and plugins of old versions. `file`: the name for messages. Throws SceneError.
Description read_scene(ExpandedScene& scene, const std::filesystem::path& file, const ReadOptions& options);

}  // namespace sheaf
