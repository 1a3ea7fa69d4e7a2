// Reading of cameras and samplers, shared by the Nori and Mitsuba dialects.
#pragma once

#include "scene/description/camera.h"
#include "scene/tables/render_settings.h"
#include "scene/xml/properties.h"

namespace sheaf {

/// Reads near_clip and far_clip (default 10,000) of a camera. Throws SceneError if they are out of order.
void read_clip(NamedValues& p, CameraDescription& camera, float near_clip);

/// Reads `fov_axis` (default x). Throws SceneError for an unknown axis.
CameraDescription::FovAxis read_fov_axis(NamedValues& p);

/// Reads `shutter_open`, `shutter_close` (default 0 each) and `shutter_ramp` (default 0). Throws SceneError if the
/// shutter closes before it opens.
ShutterDescription read_shutter(Properties& p);

/// Returns the kind for a sampler's plugin name, with a note if another sampler replaces it. Throws SceneError for an
/// unknown name.
SamplerKind read_sampler_kind(Properties& p, const char* substitute);

}  // namespace sheaf
