// RGB color spaces, defined by the chromaticities of their primaries and of white (SMPTE RP 177).
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

namespace sheaf {

/// A 3 x 3 matrix in row-major order.
using Matrix3 = std::array<std::array<double, 3>, 3>;
Matrix3 operator*(const Matrix3& a, const Matrix3& b);
std::array<double, 3> operator*(const Matrix3& a, const std::array<double, 3>& v);
/// Entries are infinite or NaN if the matrix is singular.
Matrix3 inverse(const Matrix3& m);

/// CIE xy.
struct Chromaticity {
  double x = 0, y = 0;
};

/// The primaries and white of an RGB space.
struct RgbChromaticities {
  Chromaticity red, green, blue, white;
};
inline constexpr RgbChromaticities kRec709Space{{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}, {0.3127, 0.3290}};
/// CIE XYZ as an RGB space whose white is illuminant E.
inline constexpr RgbChromaticities kXyzSpace{{1, 0}, {0, 1}, {0, 0}, {1.0 / 3, 1.0 / 3}};

/// The XYZ color of a chromaticity with Y = 1.
std::array<double, 3> xyz_of(const Chromaticity& c);

/// The matrix from linear colors of a space to XYZ; white (1, 1, 1) gets Y = 1.
Matrix3 rgb_to_xyz(const RgbChromaticities& space);

/// The matrix from linear colors of a space to linear Rec.709, without chromatic adaptation: white keeps its
/// chromaticity. Returns nothing if the primaries lie almost on a line or a number is not finite.
std::optional<Matrix3> rgb_to_rec709(const RgbChromaticities& space);

/// Converts pixels of `stride` values, of which the first three are colors, from a space to linear Rec.709. Pixels
/// with infinities or NaN stay unchanged. Returns false if rgb_to_rec709() returns nothing for the space.
bool convert_to_rec709(std::span<float> rgb, const RgbChromaticities& space, std::size_t stride = 3);

}  // namespace sheaf
