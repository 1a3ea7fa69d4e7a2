// A model without a scene: on a floor under a sky, seen by a camera that frames it.
#pragma once

#include "scene/dialects/read_scene.h"

namespace sheaf {

/// The format of a model by its file's extension (.obj, .ply, .serialized, in any case), or nothing for other files.
std::optional<MeshFileShape::Format> model_format(const std::filesystem::path& file);

/// A scene around a model, with the materials of its MTL files if it is an OBJ file, or with the picture that a PLY
/// file names (scene/formats/ply_header.h), or with the colours of its vertices or faces; models without are grey.
/// Where it has no normals, they are those of compute_creased_normals(). Throws SceneError.
/// `lenient`: faces with vertices that the file lacks, and materials that cannot be read, are warnings.
Description read_model(const std::filesystem::path& file, MeshFileShape::Format format, const ModelView& view,
                       bool lenient);

}  // namespace sheaf
