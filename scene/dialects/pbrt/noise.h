// The pbrt dialect: noise for procedural media and textures.
#pragma once

#include "core/math/vec.h"

namespace sheaf::pbrt {

/// Perlin's gradient noise, "Improving Noise" (SIGGRAPH 2002), with his permutation and pbrt's gradients (Pharr, Jakob
/// and Humphreys, "Physically Based Rendering", 3rd edition, section 10.6). It is 0 at integer coordinates and within
/// about [-1, 1].
double noise(double x, double y, double z);

/// Density of pbrt's "cloud" medium at a point in medium space, in [0, 1]: octaves of noise at a point displaced by
/// finer noise, decreasing with y.
struct CloudShape {
  double density = 1, wispiness = 1, frequency = 5;
};
double cloud_density(const CloudShape& cloud, double x, double y, double z);

}  // namespace sheaf::pbrt
