// Scenes around a single model file: a studio and a camera that frames the model.
#pragma once

#include "scene/dialects/read_scene.h"

namespace sheaf {

/// Builds a scene around a model. Materials come from the MTL files of an OBJ file, the texture that a PLY file names
/// (scene/formats/ply_header.h), or vertex or face colors; otherwise the model is gray. Missing normals are computed
/// with compute_creased_normals(). Throws SceneError. `lenient`: unreadable materials and faces that refer to missing
/// vertices become warnings. `contents`: as ReadOptions::contents.
Description read_model(const std::filesystem::path& file, const ModelView& view, const ModelEnvironment& surroundings,
                       bool lenient, FileContents* contents);

/// Whether the scene is a model that came without cameras and lights, so that some were added
/// (scene/dialects/model/surroundings.h).
bool has_studio(const Description& description);

/// Whether a file is a mesh by its extension, in any case (scene/formats/model_formats.h).
bool reads_as_mesh(const std::filesystem::path& file);
/// Whether a file is glTF by its extension, or is imported as such.
bool reads_as_gltf(const std::filesystem::path& file);

/// Reads such a file. A file with neither camera nor lights gets a studio. Otherwise, without a camera in the file, one
/// frames the scene, and a file without lights gets a sky. Throws SceneError.
Description read_gltf_scene(const std::filesystem::path& file, const ReadOptions& options);

}  // namespace sheaf
