// Measured scattering of materials, by name.
#pragma once

#include "core/vec.h"

#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// Reduced scattering and absorption, per millimetre, linear Rec.709, and the index of refraction.
struct MeasuredMedium {
  const char* name;
  Vec3f sigma_s, sigma_a;
  float eta = 1.3f;
};

/// The material of this name, in any case of letters, or null.
const MeasuredMedium* find_measured_medium(std::string_view name);

/// All names, in order of the alphabet.
std::vector<std::string> measured_medium_names();

}  // namespace sheaf
