// The table of the formats of models that Sheaf reads. Detection, messages, help and the standard input derive from it.
#pragma once

#include "core/io/file_format.h"
#include "scene/formats/mesh_io.h"

#include <span>
#include <string>
#include <string_view>

namespace sheaf {

/// One format; a row of the table.
struct ModelFormat {
  const char* key;    ///< MeshFileShape::format, and the name of Mitsuba's plugin if it has one
  KnownFormat known;  ///< name for messages, magic numbers, extensions
  /// Reads a mesh; null: the file is glTF, or becomes glTF (`is_imported`), which may be a whole scene.
  MeshFile (*read)(const MeshFileShape& shape) = nullptr;
  bool is_imported = false;    ///< by Assimp; see scene/formats/model_import.h
  bool is_compressed = false;  ///< may be much smaller than its mesh
  /// Whether bytes from the standard input, without a byte order mark, are a model of this format. Null: decided by the
  /// magic numbers.
  bool (*begins)(std::string_view bytes) = nullptr;
  const char* documentation;  ///< file and heading in docs/scene-format
};

std::span<const ModelFormat> model_formats();

/// The format of a file by its extension, in any case; null for other files.
const ModelFormat* find_model_format(const std::filesystem::path& file);

/// The format of a mesh with this key. Throws Error for others.
const ModelFormat& mesh_format(std::string_view key);

/// The format of a model on the standard input; null if it is not recognized.
const ModelFormat* detect_model_format(std::string_view bytes);

/// file_format() with the formats of models.
FileFormat file_or_model_format(const std::filesystem::path& file);

/// The extensions of all models, for messages: ".gltf, .glb, ...".
std::string model_extensions();
/// Those of models that may have cameras and animations, which are read as glTF.
std::string scene_model_extensions();

}  // namespace sheaf
