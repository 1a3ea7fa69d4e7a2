// Scenes around a single model file: a floor, a sky and a camera that frames the model.
#pragma once

#include "scene/dialects/read_scene.h"

namespace sheaf {

/// Returns the model format by file extension (.obj, .ply, .serialized, .stl, .off, in any case); nullopt for other
/// files.
std::optional<MeshFileShape::Format> model_format(const std::filesystem::path& file);

/// Builds a scene around a model. Materials come from the MTL files of an OBJ file, the texture that a PLY file names
/// (scene/formats/ply_header.h), or vertex or face colours; otherwise the model is grey. Missing normals are computed
/// with compute_creased_normals(). Throws SceneError. `lenient`: unreadable materials and faces that refer to missing
/// vertices become warnings.
Description read_model(const std::filesystem::path& file, MeshFileShape::Format format, const ModelView& view,
                       const ModelSurroundings& surroundings, bool lenient);

/// Whether a file is glTF by its extension (.gltf, .glb, in any case), or is imported as such (.dae, .fbx, .3ds).
bool reads_as_gltf(const std::filesystem::path& file);

/// The file extensions of all models, for messages.
inline constexpr const char* kModelExtensions = ".gltf, .glb, .dae, .fbx, .3ds, .obj, .ply, .stl, .off, .serialized";
/// Those of models that may have cameras and animations: reads_as_gltf().
inline constexpr const char* kSceneModelExtensions = ".gltf, .glb, .dae, .fbx, .3ds";

/// Reads such a file. Without a camera in the file, one frames the scene. A file without lights gets a sky. A
/// file with neither camera nor lights gets a floor. Throws
/// SceneError.
Description read_gltf_scene(const std::filesystem::path& file, const ReadOptions& options);

}  // namespace sheaf
