// Metals that a scene may name instead of giving their complex index of refraction.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// A measured complex index of refraction eta + i k, relative to vacuum.
struct MetalSample {
  float wavelength;  ///< nm
  float eta, k;
};

/// The samples of a metal, or of another absorbing solid ("Au", "SiC"), in order of wavelength, from 360 nm or less to
/// 830 nm or more; empty for an unknown name. A name ending in "_palik", as Mitsuba has for some, means the same metal.
/// The sources stand with the tables.
std::span<const MetalSample> find_metal(std::string_view name);

/// All names that find_metal() knows, without the endings.
std::vector<std::string> metal_names();

}  // namespace sheaf
