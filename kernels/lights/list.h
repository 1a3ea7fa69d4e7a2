// The list of the kernels of all kinds of lights, in the order of scene/lights/list.h. Light sampling, its pdfs and
// photon emission are generated from it.
#pragma once

#include "kernels/lights/beam_light.h"
#include "kernels/lights/constant_light.h"
#include "kernels/lights/directional_light.h"
#include "kernels/lights/envmap_light.h"
#include "kernels/lights/goniometric_light.h"
#include "kernels/lights/mesh_light.h"
#include "kernels/lights/point_light.h"
#include "kernels/lights/projector_light.h"
#include "kernels/lights/quadric_light.h"
#include "kernels/lights/sphere_light.h"
#include "kernels/lights/spot_light.h"
#include "kernels/lights/sun_light.h"
#include "kernels/lights/volume_light.h"
#include "scene/lights/list.h"

#include <type_traits>

namespace sheaf {

/// A list of light kinds, as types.
template <LightModel... Models> struct LightList {
  using SceneKinds = LightKindList<typename Models::Kind...>;
  /// Calls f(kind) for each kind, with a value of its type.
  template <class F> static SHEAF_INLINE void for_each(F&& f) { (f(Models{}), ...); }
};

/// All light kinds. Scenes whose lights are all of the first kind are the most common.
using Lights = LightList<MeshLight,                       //
                         SphereLight,                     //
                         QuadricLight,                    //
                         PointLight,                      //
                         SpotLight<LinearSpotLightKind>,  //
                         SpotLight<SmoothSpotLightKind>,  //
                         GoniometricLight,                //
                         ProjectorLight,                  //
                         BeamLight,                       //
                         DirectionalLight,                //
                         SunLight,                        //
                         ConstantLight,                   //
                         EnvmapLight,                     //
                         VolumeLight>;
static_assert(std::is_same_v<Lights::SceneKinds, LightKinds>, "the list must match that of scene/lights/list.h");

}  // namespace sheaf
