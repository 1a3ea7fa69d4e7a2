// Phase functions, shared by the Nori and Mitsuba dialects.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Appends the phase function of a <phase>, nested ones first. Types: isotropic, hg (`g`), rayleigh, tabphase
/// (`values`), sggx (`S`), blendphase or blend (`weight`), mixturephase (`weights`). Throws SceneError.
PhaseId read_phase(const XmlElement& element, ReadContext& context);

/// Returns the phase function of a medium, given as <phase> or <phasefunction>; nullopt if it has none.
std::optional<PhaseId> find_phase(Properties& p);

}  // namespace sheaf
