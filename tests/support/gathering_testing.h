// Sets up rays for tests of the stages that gather photons in media.
#pragma once

#include "tests/support/stages_testing.h"

namespace sheaf {

/// Adds a ray along +z that ends at z = 10 and whose path is in a medium.
inline Slot add_ray_in_medium(TestWave& test, Vec3f origin) {
  Wave& wave = test.wave;
  const Slot slot = test.add(origin, {0, 0, 1}, 1u << kRayMediumShift);
  HitState<Scalar> hit{};
  hit.t = 10 - origin.z;
  hit.shape = 0, hit.instance = hit.light = kNone;
  wave.hits.set(slot, hit);
  wave.rescaled_pdfs.row(slot) = {Spectrum4(1.0f), Spectrum4(1.0f)};
  wave.distance_since_vertex[slot] = 0;
  wave.medium.push(slot);
  return slot;
}

}  // namespace sheaf
