// Linear spectral upsampling: basis spectra for which the spectrum of a sum of colors is the sum of their spectra.
#pragma once

#include <vector>

namespace sheaf {

/// Returns the basis spectrum whose linear Rec.709 color under D65 is (1, 0, 0), (0, 1, 0) or (0, 0, 1), for `channel`
/// 0, 1 or 2, at 360, 361, ... 830 nm. Values are in [0, 1]; the three spectra sum to 1. Follows Mallett and Yuksel,
/// "Spectral Primary Decomposition for Rendering with sRGB Reflectance", 2019; fitted by tools/color/fit_rgb_basis.py.
std::vector<float> rgb_basis(int channel);

}  // namespace sheaf
