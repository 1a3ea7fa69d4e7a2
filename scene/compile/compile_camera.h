// Compiles cameras.
#pragma once

#include "scene/compile/compile_motion.h"
#include "scene/description/error_sink.h"
#include "scene/tables/sensor_tables.h"

namespace sheaf {

struct CompiledCameras {
  SensorTables tables;
  std::vector<CameraDescription> at_open;  ///< the cameras when the shutter opens
};

/// Compiles the cameras of a scene, with their motions, and the pixel filter. Reports errors of make_camera(), and uses
/// the default lens. Throws SceneError for a film that is not divisible by the number of cameras, and for cameras that
/// the integrator does not support.
CompiledCameras compile_cameras(const Description& description, const SceneSettings& settings, MotionCompiler& motion,
                                ErrorSink& errors);

/// Prepares a camera for a frame of width x height pixels. Throws SceneError for a field of view outside (0, 180),
/// unordered clip distances, a negative aperture, a focus distance that is not positive, a distortion that is not
/// monotonic on the film, and a panorama whose transform is not a rotation.
Camera make_camera(const CameraDescription& description, int width, int height);

/// The narrowest cone of the pixels of a frame of width x height pixels. Ignores the lens and its distortion.
PixelCone pixel_cone_of(const Camera& camera, int width, int height);

/// Moves a kDistant camera outside the scene, whose shapes lie in the given sphere. Other cameras are unchanged.
void move_outside_scene(Camera& camera, const CameraDescription& description, Vec3f center, float radius);

}  // namespace sheaf
