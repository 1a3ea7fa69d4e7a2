// Measured scattering media by name.
#pragma once

#include "core/math/vec.h"

#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// Reduced scattering coefficient and absorption coefficient, 1/mm, linear Rec.709, and the index of refraction.
struct MeasuredMedium {
  const char* name;
  Vec3f sigma_s, sigma_a;
  float eta = 1.3f;
};

/// Returns the medium of this name, ignoring case, or null.
const MeasuredMedium* find_measured_medium(std::string_view name);

/// Returns all names in alphabetical order.
std::vector<std::string> measured_medium_names();

}  // namespace sheaf
