// Measured polarimetric BRDFs (Baek et al., "Image-Based Acquisition and Modeling of Polarimetric Reflectance", ACM
// Transactions on Graphics 39, 2020), the files of Mitsuba's plugin measured_polarized.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

namespace sheaf {

/// The unpolarized part of an isotropic polarimetric BRDF, tabulated over the half and difference angles of
/// Rusinkiewicz 1998. Without negative values.
struct PolarizedBrdf {
  std::vector<float> phi_d, theta_d, theta_h;  ///< increasing, radians; at least 2 each
  std::vector<float> wavelengths;              ///< nm, increasing; empty: red, green, blue
  std::size_t channels = 0;                    ///< one per wavelength, or 3
  std::vector<float> values;                   ///< 1/sr, by phi_d, channel, theta_d and theta_h, which varies fastest
};

/// Reads element (0, 0) of the Mueller matrices in a tensor file (scene/formats/tensor_file.h): its fields are phi_d,
/// theta_d, theta_h, wvls, and M with one 4 x 4 matrix per phi_d, theta_d, theta_h and wavelength. Negative values
/// become 0, and so do NaNs, which mark directions that were not measured. Throws SceneError for fields that are
/// missing, of the wrong type or size, or not finite.
PolarizedBrdf read_polarized_brdf(const std::filesystem::path& file);

}  // namespace sheaf
