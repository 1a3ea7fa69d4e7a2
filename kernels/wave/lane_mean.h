// The mean over the spectral lanes of a path's probabilities: what light that is found is divided by.
#pragma once

#include "core/spectrum.h"
#include "scene/tables/scene.h"

namespace sheaf {

/// Of all four lanes in spectral mode, else of the three that are colours.
template <class L> SHEAF_INLINE Float<L> lane_mean(ColorMode color, const Spectrum<L>& r) {
  return color == ColorMode::kSpectral ? total(r) * Float<L>(0.25f) : (r.c0 + r.c1 + r.c2) * Float<L>(1.0f / 3.0f);
}

}  // namespace sheaf
