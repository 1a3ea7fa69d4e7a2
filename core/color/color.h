// Color: the sRGB transfer curve, conversion between Rec.709 and CIE XYZ, and RGB colors of tabulated spectra in the
// working space, linear Rec.709 with white D65.
#pragma once

#include "core/math/vec.h"

#include <array>
#include <span>

namespace sheaf {

/// Rec.709 primaries and white point as CIE xy chromaticities: red, green, blue, white (D65).
inline constexpr std::array<Vec2f, 4> kRec709Chromaticities{Vec2f{0.64f, 0.33f}, Vec2f{0.30f, 0.60f},
                                                            Vec2f{0.15f, 0.06f}, Vec2f{0.3127f, 0.3290f}};

/// The sRGB transfer curve (IEC 61966-2-1), linear to encoded; both in [0, 1]. Values outside are encoded by the same
/// formulas.
float linear_to_srgb(float linear);
/// The inverse of linear_to_srgb.
float srgb_to_linear(float encoded);
Vec3f srgb_to_linear(Vec3f encoded);

/// Linear Rec.709 to CIE XYZ (1931, 2 degrees); white (1, 1, 1) becomes Y = 1.
Vec3f rec709_to_xyz(Vec3f rgb);
/// The inverse of rec709_to_xyz. Colors outside the gamut get negative components.
Vec3f xyz_to_rec709(Vec3f xyz);
/// The Y component of rec709_to_xyz.
float luminance(Vec3f rgb);

/// Range of the CIE tables in nm. They have a value every 5 nm and are linear in between.
inline constexpr float kWavelengthMin = 360.0f;
inline constexpr float kWavelengthMax = 830.0f;
/// CIE 1931 2-degree color matching functions (x, y, z) at a wavelength in nanometers; zero outside the range.
/// Source: CIE 018:2019, every fifth value of the 1 nm tables.
Vec3f cie_1931_xyz(float wavelength);
/// Relative spectral power of CIE standard illuminant D65, 100 at 560 nm; zero outside the range of the tables.
/// Source: CIE 15:2018; ISO/CIE 11664-2.
float cie_d65(float wavelength);

/// Planck's law: spectral radiance in W / (m^2 sr nm) of a black body of `temperature` kelvin at a wavelength in
/// nanometers. Zero for temperatures that are not positive.
double blackbody_radiance(double wavelength, double temperature);

// The following functions take a spectrum as a table: strictly increasing wavelengths in nm and one value for each. The
// spectrum is linear in between and zero outside. They throw Error (exit code 3) if the sizes differ, the wavelengths
// do not increase, or a number is not finite. Negative components (colors outside the gamut) are set to zero.

/// The Rec.709 color of a reflectance or transmittance: its color under D65, with the perfect reflector at (1, 1, 1).
/// Components are clamped to [0, 1].
Vec3f reflectance_table_to_rgb(std::span<const float> wavelengths, std::span<const float> values);
/// As reflectance_table_to_rgb, without the upper limit: for indices of refraction (eta, k) and scales.
Vec3f unbounded_table_to_rgb(std::span<const float> wavelengths, std::span<const float> values);
/// The Rec.709 color of an emission spectrum in absolute units, such as W / (m^2 sr nm): XYZ divided by the integral
/// of the y curve. A spectrum of 1 at every wavelength has Y = 1 and the color of illuminant E, which is slightly
/// redder than (1, 1, 1).
Vec3f emission_table_to_rgb(std::span<const float> wavelengths, std::span<const float> values);
/// emission_table_to_rgb of a black body's spectrum, times `scale`.
Vec3f blackbody_to_rgb(float temperature, float scale);

}  // namespace sheaf
