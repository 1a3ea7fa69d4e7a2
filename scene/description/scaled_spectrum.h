// Multiples of described spectra.
#pragma once

#include "scene/description/inputs.h"

namespace sheaf {

/// Returns the spectrum multiplied by `by`.
SpectrumDescription scaled(SpectrumDescription spectrum, float by);

}  // namespace sheaf
