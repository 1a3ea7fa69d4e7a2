// Glasses, crystals and liquids whose index of refraction is published as a function of wavelength.
#pragma once

#include "scene/description/dispersion.h"

#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// The formula of a material by name ("bk7", "water"), or null for an unknown name. Names that find_ior() has too mean
/// the same material; its constants, which are Mitsuba's, differ from the formulas by up to 0.8 %.
const Dispersion* find_dispersion(std::string_view name);

/// All names that find_dispersion() knows.
std::vector<std::string> dispersion_names();

}  // namespace sheaf
