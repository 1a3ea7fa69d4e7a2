// Where to look at a scene from that does not say it: a camera that sees all of it.
#pragma once

#include "scene/dialects/dialects.h"
#include "scene/dialects/read_scene.h"

#include <array>

namespace sheaf {

/// Bounds of all shapes but the infinite, in world space; [0, 0] for a scene without shapes. Mesh files are read for
/// it, and stay in memory: their shapes hold them from then on. Leniently, shapes whose files cannot be read are left
/// out; otherwise throws SceneError.
std::array<Vec3f, 2> read_bounds(Description& description, bool lenient);

/// The direction that points up, of unit length.
Vec3f up_vector(const ModelView& view);

/// Puts the camera where it sees the box, from the side that `view` says.
void frame_box(const std::array<Vec3f, 2>& box, const ModelView& view, Description& description);

/// For a scene without a camera: throws SceneError at `root` that `what` is missing or, if the context is lenient, has
/// the scene framed once it is read.
void stand_in_camera(const XmlElement& root, const char* what, ReadContext& context);

}  // namespace sheaf
