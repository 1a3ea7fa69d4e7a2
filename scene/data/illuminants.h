// Named illuminants: CIE standard illuminants and the equal-energy spectrum.
#pragma once

#include "scene/description/inputs.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// Returns the spectrum of "a", "d50", "d55", "d65", "d75" or "e" from 360 to 830 nm, scaled to Y = 1 (a constant power
/// of 1 has Y = 1); nullopt for an unknown name.
std::optional<SpectrumDescription::Table> find_illuminant(std::string_view name);

/// Returns all names that find_illuminant() knows.
std::vector<std::string> illuminant_names();

}  // namespace sheaf
