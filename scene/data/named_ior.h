// Named dielectrics with their index of refraction.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// Returns the index of refraction of a dielectric at 589 nm ("bk7", "water"), or nullopt for an unknown name.
std::optional<float> find_ior(std::string_view name);

/// Returns all names that find_ior() knows.
std::vector<std::string> ior_names();

}  // namespace sheaf
