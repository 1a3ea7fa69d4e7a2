// Names of integrators, shared by all dialects and the command line.
#pragma once

#include "scene/xml/properties.h"

#include <string_view>

namespace sheaf {

/// Integrator settings that a name selects.
struct IntegratorChoice {
  IntegratorKind kind;
  LightStrategy strategy;
  bool direct = false;                     ///< direct lighting only: max_depth is 2
  int candidates = 1;                      ///< sets IntegratorSettings::candidates if above 1
  bool thin_dielectrics_are_free = false;  ///< IntegratorSettings::thin_dielectrics_are_free
  bool progressive = false;                ///< PhotonMappingSettings::progressive
  bool ends_at_diffuse = false;            ///< IntegratorSettings::ends_at_diffuse
};

/// Integrators of other renderers, and Sheaf's integrators with the same expected image.
extern const NameTable<const char*> kStandInIntegrators;

/// Returns the integrator of this name, or the one with the same expected image, or null.
const IntegratorChoice* find_integrator(std::string_view name);

/// Returns all integrator names, sorted.
std::vector<std::string> integrator_names();

/// Sets kind, strategy, thin_dielectrics_are_free, ends_at_diffuse and photons.progressive. Sets candidates and
/// max_depth only if the name determines them.
void apply(const IntegratorChoice& choice, IntegratorSettings& integrator);

/// Returns a note for the user if another integrator with the same expected image replaces this one; else empty.
std::string stand_in_note(std::string_view name);

/// Throws SceneError: the integrator of `p` is neither one of integrator_names() nor of the dialect's `others`.
[[noreturn]] void fail_integrator(const Properties& p, const std::vector<std::string>& others);

/// Sets the scene's integrator by name: one of integrator_names(), applied with apply(), or a visibility integrator
/// (scene/dialects/common/visibility_integrators.h). Adds a note if another integrator replaces it. Throws Error
/// (usage) for an unknown name; the message lists the nearest name and all names.
void apply_integrator_name(std::string_view name, Description& description);

}  // namespace sheaf
