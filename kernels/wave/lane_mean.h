// Mean of rescaled path pdfs over the spectral lanes, by which the contribution of a path is divided (PBR 14.2.1).
#pragma once

#include "core/color/spectrum.h"
#include "scene/tables/scene_view.h"

namespace sheaf {

/// Mean of all four lanes in spectral mode, or of the three colors in RGB mode.
template <class L> SHEAF_INLINE Float<L> lane_mean(ColorMode color, const Spectrum<L>& r) {
  return color == ColorMode::kSpectral ? total(r) * Float<L>(0.25f) : (r.c0 + r.c1 + r.c2) * Float<L>(1.0f / 3.0f);
}

}  // namespace sheaf
