// What the dialects share in reading cameras and samplers.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// near_clip and far_clip (10,000) of a camera. Throws SceneError if they are out of order.
void read_clip(Properties& p, CameraDescription& camera, float near_clip);

/// `fov_axis` (x). Throws SceneError for an unknown one.
CameraDescription::FovAxis read_fov_axis(Properties& p);

/// `shutter_open`, `shutter_close`: not used, with a note if the shutter is open for some time.
void read_shutter(Properties& p);

/// The kind that a sampler's plugin name stands for; a note where another stands in for it. Throws SceneError for an
/// unknown name.
SamplerKind read_sampler_kind(Properties& p);

}  // namespace sheaf
