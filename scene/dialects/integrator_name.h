// The names of integrators, in all dialects and on the command line.
#pragma once

#include "scene/description/description.h"

#include <string_view>

namespace sheaf {

/// What a name stands for.
struct NamedIntegrator {
  const char* name;
  IntegratorKind kind;
  LightStrategy strategy;
  bool direct;                             ///< light is scattered once: max_depth is 2
  int candidates = 1;                      ///< IntegratorDescription::candidates unless told
  bool thin_dielectrics_are_free = false;  ///< IntegratorDescription::thin_dielectrics_are_free
  bool progressive = false;                ///< PhotonMappingDescription::progressive
  bool ends_at_diffuse = false;            ///< IntegratorDescription::ends_at_diffuse
};

/// For the integrators of other renderers that compute the same picture in another way: the name of ours. Else null.
const char* same_expectation(std::string_view name);

/// The integrator of this name, or the one with the same expectation, or null.
const NamedIntegrator* find_integrator(std::string_view name);

/// All names.
std::vector<std::string> integrator_names();

/// Sets kind, strategy, thin_dielectrics_are_free, ends_at_diffuse, whether photon maps are progressive and, where the
/// name fixes them, candidates and depth.
void apply(const NamedIntegrator& named, IntegratorDescription& integrator);

/// What to tell the user if another integrator with the same expectation is rendered; else empty.
std::string stand_in_note(std::string_view name);

/// Gives the scene the integrator of this name: one of integrator_names(), which sets what apply() does, or one that
/// looks at shapes alone (scene/dialects/visibility_integrators.h). Notes if another one stands in. Throws Error
/// (usage) for an unknown name, with the nearest known one and all others.
void apply_integrator_name(std::string_view name, Description& description);

}  // namespace sheaf
