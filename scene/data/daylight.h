// Coefficients of the sky and sun models, from daylight_tables.txt; see scene/lights/daylight.cpp for their use.
#pragma once

#include <cstddef>
#include <iterator>
#include <span>

namespace sheaf::daylight_data {

inline constexpr std::size_t kTurbidities = 10;   ///< 1, 2, ... 10
inline constexpr std::size_t kControlPoints = 6;  ///< of a Bezier curve over the sun's elevation
inline constexpr std::size_t kSkyParameters = 9;
inline constexpr std::size_t kSunPieces = 45;       ///< pieces of the sun's elevation
inline constexpr std::size_t kSunWavelengths = 11;  ///< 320, 360, ... 720 nm
inline constexpr std::size_t kSunOrder = 4;
inline constexpr std::size_t kLimbOrder = 6;

/// Parameters of the sky's distribution: [turbidity][albedo 0 and 1][control point][R, G, B][parameter].
std::span<const float> sky_shape();
/// Factor of the sky's distribution: [turbidity][albedo 0 and 1][control point][R, G, B].
std::span<const float> sky_radiance();
/// Radiance of the sun's center: [turbidity][piece][wavelength][power of the elevation above the start of the piece].
std::span<const float> sun_radiance();
/// Limb darkening of the sun: [wavelength][power of the cosine].
std::span<const float> limb_darkening();

}  // namespace sheaf::daylight_data
