// Integrators as scene files and the command line name them; see scene/tables/integrator_list.h.
#pragma once

#include "scene/description.h"
#include "scene/xml/properties.h"

#include <string_view>

namespace sheaf {

/// Sets name, kind, strategy, thin_dielectrics_are_free, ends_at_diffuse and photons.progressive. Sets candidates and
/// max_depth only if the name determines them.
void apply(const IntegratorMatch& found, IntegratorSettings& integrator);

/// Adds a note, or a warning if the noise is far higher, if the integrator replaces the one that a file names at
/// `where`.
void report_substitution(const SourceLocation& where, std::string_view name, const IntegratorMatch& found,
                         Remarks& remarks);

/// Returns the integrator of `p`. Reports an unknown one, which becomes `path`; the message names those of the dialect,
/// `others`, too.
IntegratorMatch integrator_or_path(Properties& p, const std::vector<std::string>& others);

/// Makes all shapes white, diffuse and non-emissive, removes media and all lights. Removes null interfaces, except
/// those in groups. `two_sided`: back sides are white, too.
void make_white(Description& description, bool two_sided);

/// Modifies the scene for an integrator with IntegratorEntry::whitens_scene such that its image is what the integrator
/// computes: ambient occlusion, the cosine-weighted visibility of the sky, 0 where the camera ray misses; or the
/// average visibility, the fraction of the hemisphere without an occluder closer than `length` (m), 1 where the camera
/// ray misses. Call it after the scene is read.
void white_scene(const IntegratorMatch& found, float length, bool two_sided, Description& description);

/// Sets the scene's integrator by name, as the command line does. Adds a note if another integrator replaces it. Throws
/// Error (usage) for an unknown name; the message lists the nearest name and all names. Throws it for an unsupported
/// integrator, too; `lenient`: adds a warning instead.
void apply_integrator_name(std::string_view name, bool lenient, Description& description);

}  // namespace sheaf
