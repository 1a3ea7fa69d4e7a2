// Light sampling for tests: selects a light and samples a direction in one call.
#pragma once

#include "kernels/lights/light_sample.h"

namespace sheaf {

/// Selects a light for a point without a normal and samples a direction towards it.
template <class L> LightSample<L> sample_any_light(const SceneView& scene, Vec3<L> from, const Random4<L>& u) {
  return sample_light<L>(scene, {from, {}}, choose_light<L>(scene, {from, Vec3<L>{}}, u.x), u, Float<L>(0.0f));
}

}  // namespace sheaf
