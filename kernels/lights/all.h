// The list of all light kinds. Light sampling, its pdfs and photon emission are generated from it.
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

#include <utility>

namespace sheaf {

/// A list of light kinds, as types.
template <LightModel... Kinds> struct LightList {
  static constexpr int kCount = sizeof...(Kinds);
  /// Whether the kinds are in the order of LightKind.
  static constexpr bool is_ordered() {
    std::uint32_t next = 0;
    return ((static_cast<std::uint32_t>(Kinds::kKind) == next++) && ...);
  }
  /// Calls f(kind) for each kind, with a value of its type.
  template <class F> static SHEAF_INLINE void for_each(F&& f) { (f(Kinds{}), ...); }
};

/// All light kinds. Scenes whose lights are all of the first kind are the most common.
using Lights = LightList<MeshLight, SphereLight, QuadricLight, PointLight, SpotLight<LightKind::kSpot>,
                         SpotLight<LightKind::kSmoothSpot>, GoniometricLight, ProjectorLight, BeamLight,
                         DirectionalLight, SunLight, ConstantLight, EnvmapLight, VolumeLight>;
static_assert(Lights::kCount == kLightKinds && Lights::is_ordered(), "the list must hold LightKind's kinds, in order");

}  // namespace sheaf
