// Glasses, crystals and liquids with published dispersion formulas.
#pragma once

#include "scene/description/dispersion.h"

#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// Returns the dispersion formula of a material by name ("bk7", "water"), or null for an unknown name. Names that
/// find_ior() shares denote the same material; its constants, from Mitsuba, differ from the formulas by up to 0.8 %.
const Dispersion* find_dispersion(std::string_view name);

/// Returns all names that find_dispersion() knows.
std::vector<std::string> dispersion_names();

}  // namespace sheaf
