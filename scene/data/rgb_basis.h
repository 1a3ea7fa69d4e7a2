// Spectra whose mixtures stand for colours where these must stay linear: a sum of colours is the sum of their spectra.
#pragma once

#include <vector>

namespace sheaf {

/// The spectrum that is (1, 0, 0), (0, 1, 0) or (0, 0, 1) of linear Rec.709 under D65, for `channel` 0, 1 or 2, at 360,
/// 361, ... 830 nm: in [0, 1], and the three add up to 1. After the idea of Mallett and Yuksel, "Spectral Primary
/// Decomposition for Rendering with sRGB Reflectance", 2019; the values were found by tools/fit_rgb_basis.py.
std::vector<float> rgb_basis(int channel);

}  // namespace sheaf
