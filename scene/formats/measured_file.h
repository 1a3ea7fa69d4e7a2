// Measured BRDFs as the RGL material database has them, ".bsdf".
#pragma once

#include <filesystem>
#include <vector>

namespace sheaf {

/// Tables as the file has them; kernels/bsdf/measured.h tells what they mean. None of the values is negative.
struct MeasuredBrdf {
  /// One or more functions on a grid of `width` times `height` points, x (elevation) fastest.
  struct Grids {
    std::size_t width = 0, height = 0;  ///< at least 2
    std::vector<float> values;          ///< one grid after the other
  };
  std::vector<float> phi, theta;  ///< incident directions, increasing, radians; azimuths of one or two: isotropic
  Grids ndf, sigma;               ///< of a direction: distribution of normals, projected area
  Grids vndf, luminance;          ///< a grid for each phi and, faster, each theta
  Grids values;                   ///< the same for each channel, faster still; as large as those of `luminance`
  std::size_t channels = 3;
  std::vector<float> wavelengths;  ///< of the channels, nm, increasing; empty: red, green, blue
  bool jacobian = false;           ///< whether the values are to be multiplied by ndf / (4 sigma)

  bool isotropic() const { return phi.size() <= 2; }
};

/// Reads a tensor file (scene/formats/tensor_file.h) with the fields theta_i, phi_i, ndf, sigma, vndf, luminance,
/// jacobian, and rgb or spectra and wavelengths. Of a file with both, the spectra if `prefer_spectra`. Negative values
/// become 0. Throws SceneError for what is missing, of the wrong size or not finite.
MeasuredBrdf read_measured(const std::filesystem::path& file, bool prefer_spectra);

}  // namespace sheaf
