// Models of other programs, which sheaf_import_model (tools/importer/) converts to glTF by the library Assimp.
//
// The conversion is a process of its own, because that library may crash on damaged files. The process can only
// compute: see tools/importer/sandbox.h.
#pragma once

#include <filesystem>
#include <string>

namespace sheaf {

/// Whether a file has such a format by its extension; see ModelFormat::is_imported.
bool is_imported_model(const std::filesystem::path& file);

/// The program that imports models.
inline constexpr char kModelImporter[] = "sheaf_import_model";

/// Whether sheaf_import_model exists, next to the program or in ../lib/sheaf. Builds without Assimp lack it.
bool can_import_models();

/// Converts a model to a binary glTF file (.glb), whose images have the names in the model. A FileCache keeps the
/// result. Throws SceneError if the model cannot be read, if it takes too much memory or time, or if this build of
/// Sheaf lacks Assimp.
std::string import_model(const std::filesystem::path& file);

/// Finds an image by its name in a model, which may be a path on another computer: relative to `folder`, or else a file
/// of that name in `folder` or in its folders "textures" and "images". Returns a path relative to `folder`. If nothing
/// is found, that is the name of the file.
std::filesystem::path find_model_image(const std::string& name, const std::filesystem::path& folder);

}  // namespace sheaf
