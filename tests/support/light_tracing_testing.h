// Agreement of light tracing with path tracing.
#pragma once

#include "tests/support/render_testing.h"

namespace sheaf {

/// Checks that both integrators give the same mean over the left half of the image, so that a camera in the wrong place
/// shows.
inline void check_light_tracing_agrees(Description d) {
  const auto mean = [&](IntegratorKind kind, std::uint32_t seed) {
    d.integrator.kind = kind;
    d.sampler.seed = seed;
    const Image image = render(*compile_scene(d), {}).to_image();
    MeanVariance sum;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width / 2; ++x) sum.add(image.at(x, y, 1));
    return sum.mean();
  };
  MeanVariance paths, photons;
  for (std::uint32_t seed = 0; seed < 8; ++seed) {
    paths.add(mean(IntegratorKind::kPath, seed));
    photons.add(mean(IntegratorKind::kLightTracer, 100 + seed));
  }
  check_same_mean(paths, photons, kSignificance, 8);
}

}  // namespace sheaf
