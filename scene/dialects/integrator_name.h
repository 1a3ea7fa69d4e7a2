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
  bool direct;  ///< light is scattered once: max_depth is 2
  int candidates = 1;  ///< IntegratorDescription::candidates unless told
  bool free_panes = false;  ///< IntegratorDescription::free_panes
  bool progressive = false;  ///< PhotonMappingDescription::progressive
  bool ends_at_diffuse = false;  ///< IntegratorDescription::ends_at_diffuse
};

/// For the integrators of other renderers that compute the same picture in another way: the name of ours. Else null.
const char* same_expectation(std::string_view name);

/// The integrator of this name, or the one with the same expectation, or null.
const NamedIntegrator* find_integrator(std::string_view name);

/// All names.
std::vector<std::string> integrator_names();

/// Sets kind, strategy, free_panes, ends_at_diffuse, whether photon maps are progressive and, where the name fixes
/// them, candidates and depth.
void apply(const NamedIntegrator& named, IntegratorDescription& integrator);

/// `base` with kind, strategy and, where the name fixes them, depth and candidates as `name` says: path, path_mis,
/// path_mats, path_ems, path_ris, direct, direct_mis, direct_mats, direct_ems, direct_ris, whitted, ptracer,
/// photonmapper, ppm, sppm, normals, depth, names of path with `vol` or `medium` in them, and Mitsuba's integrators of
/// the same expectation. Throws Error (usage) for an unknown name, with the nearest known one and all others.
IntegratorDescription integrator_from_name(std::string_view name, const IntegratorDescription& base);

}  // namespace sheaf
