// Sampling of lights as tests want it: selection and direction in one.
#pragma once

#include "kernels/lights/light_sample.h"

namespace sheaf {

/// A light chosen for a point in mid-air, and a direction towards it.
template <class L> LightSample<L> sample_any_light(const SceneView& scene, Vec3<L> from, const Random4<L>& u) {
  return sample_light<L>(scene, from, choose_light<L>(scene, {from, Vec3<L>{}}, u.x), u);
}

}  // namespace sheaf
