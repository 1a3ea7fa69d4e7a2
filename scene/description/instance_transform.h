// Which transforms instances may have.
#pragma once

#include <array>

namespace sheaf {

/// Whether single precision can take rays through the transform (rows of a 3x4 matrix) and back: no entry of its
/// linear part nor of the inverse of that is beyond kLargestInstanceScale, and the translation is finite.
bool is_usable_instance(const std::array<float, 12>& to_world);
inline constexpr double kLargestInstanceScale = 1e9;

/// The determinant of a transform's linear part.
double determinant_of(const std::array<float, 12>& to_world);

}  // namespace sheaf
