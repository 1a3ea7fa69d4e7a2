// Illuminants that have names: CIE standard illuminants and the equal-energy spectrum.
#pragma once

#include "scene/description/description.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// The spectrum of "a", "d50", "d55", "d65", "d75" or "e" from 360 to 830 nm, scaled to Y = 1 (a power of 1 at every
/// wavelength has Y = 1); nothing for an unknown name.
std::optional<SpectrumDescription::Table> find_illuminant(std::string_view name);

/// All names that find_illuminant() knows.
std::vector<std::string> illuminant_names();

}  // namespace sheaf
