// Named metals with their complex index of refraction.
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

/// Returns the samples of a metal or another absorbing solid ("Au", "SiC") in order of wavelength; empty for an unknown
/// name. They range from 360 nm or less to 830 nm or more. The suffix "_palik", which Mitsuba has for some names,
/// denotes the same metal, except that "Cu_palik" has fewer samples. The sources are listed at the tables.
std::span<const MetalSample> find_metal(std::string_view name);

/// Returns all names that find_metal() knows, without optional suffixes.
std::vector<std::string> metal_names();

}  // namespace sheaf
