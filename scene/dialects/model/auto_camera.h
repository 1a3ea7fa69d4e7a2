// Automatic camera placement: a camera that sees all shapes of a scene.
#pragma once

#include "scene/description/error_sink.h"
#include "scene/dialects/model/model_view.h"
#include "scene/xml/properties.h"

#include <array>

namespace sheaf {

/// Returns the world-space bounds of all shapes except infinite ones; [0, 0] for a scene without shapes. Loads mesh
/// files; the shapes keep the loaded meshes. If `lenient`, drops shapes whose files cannot be read; otherwise throws
/// SceneError.
std::array<Vec3d, 2> read_bounds(Description& description, ErrorSink& errors);

/// The unit vector that points up.
Vec3f up_vector(const ModelView& view);

/// TextureCoordinates the camera such that it sees the whole box from the direction of `view`.
void frame_box(const std::array<Vec3d, 2>& box, const ModelView& view, Description& description);

/// Handles a scene without a camera. Throws SceneError at `root`, saying that `what` is missing; if the context is
/// lenient or needs no camera, requests automatic camera placement after reading.
void substitute_camera(const XmlElement& root, const char* what, ReadContext& context);

}  // namespace sheaf
