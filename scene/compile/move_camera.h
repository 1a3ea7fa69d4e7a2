// Gives a compiled scene another camera, for previews that follow the hand: no other table is compiled again.
#pragma once

#include "scene/description/camera.h"
#include "scene/scene.h"

#include <memory>

namespace sheaf {

/// Replaces the first camera of a scene by one that does not move, and the film, of which only the size and the crop
/// window may differ. The camera's medium is found as compile_scene() does. The bounding sphere never shrinks: images
/// may differ in noise from those of the compiled scene. Throws SceneError as make_camera(); the scene is then
/// unchanged.
void move_camera(const CameraDescription& camera, const FilmSettings& film, std::unique_ptr<Scene>& scene);

}  // namespace sheaf
