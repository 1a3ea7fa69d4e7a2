// Limits on the transforms of instances.
#pragma once

#include <array>

namespace sheaf {

/// Whether single precision suffices to transform rays to the instance and back. `to_world` holds the rows of a 3x4
/// matrix. No entry of its linear part, or of the inverse of that, may exceed kLargestInstanceScale; the translation is
/// finite.
bool is_usable_instance(const std::array<float, 12>& to_world);
inline constexpr double kLargestInstanceScale = 1e9;

/// Rounds a matrix to single precision.
std::array<float, 12> rounded_rows(const std::array<double, 12>& to_world);

/// The determinant of a transform's linear part.
double determinant_of(const std::array<float, 12>& to_world);

}  // namespace sheaf
