// Measured BRDFs in the ".bsdf" format of the RGL material database.
#pragma once

#include <filesystem>
#include <vector>

namespace sheaf {

/// Tables as in the file, without negative values; see kernels/bsdf/measured.h for their meaning.
struct MeasuredBrdf {
  /// One or more grids of `width` x `height` points, x (elevation) fastest.
  struct Grids {
    std::size_t width = 0, height = 0;  ///< at least 2
    std::vector<float> values;          ///< grids in sequence
  };
  std::vector<float> phi, theta;  ///< incident directions, increasing, radians; at most 2 azimuths: isotropic
  Grids ndf, sigma;               ///< by direction: distribution of normals, projected area
  Grids vndf, luminance;          ///< one grid per (phi, theta), theta fastest
  Grids values;                   ///< one grid per (phi, theta, channel), channel fastest; as large as `luminance`
  std::size_t channels = 3;
  std::vector<float> wavelengths;  ///< of the channels, nm, increasing; empty: red, green, blue
  bool jacobian = false;           ///< whether to multiply the values by ndf / (4 sigma)

  bool isotropic() const { return phi.size() <= 2; }
};

/// Reads a tensor file (scene/formats/tensor_file.h) with the fields theta_i, phi_i, ndf, sigma, vndf, luminance,
/// jacobian, and rgb or spectra and wavelengths. If both are present, `prefer_spectra` selects the spectra. Negative
/// values become 0. Throws SceneError for fields that are missing, of the wrong size or not finite.
MeasuredBrdf read_measured(const std::filesystem::path& file, bool prefer_spectra);

}  // namespace sheaf
