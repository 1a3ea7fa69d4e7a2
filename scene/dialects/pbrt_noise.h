// The pbrt dialect: noise of which procedural media and textures are made.
#pragma once

#include "core/vec.h"

namespace sheaf::pbrt {

/// Perlin's gradient noise, "Improving Noise" (SIGGRAPH 2002), with his permutation and pbrt's gradients (Pharr, Jakob
/// and Humphreys, "Physically Based Rendering", 3rd edition, section 10.6): 0 where all coordinates are whole, about
/// within [-1, 1].
double noise(double x, double y, double z);

/// The density of pbrt's cloud at a point of the medium's space, in [0, 1]: octaves of noise, looked up where finer
/// noise has moved the point to, and thinner with y.
struct CloudShape {
  double density = 1, wispiness = 1, frequency = 5;
};
double cloud_density(const CloudShape& cloud, double x, double y, double z);

}  // namespace sheaf::pbrt
