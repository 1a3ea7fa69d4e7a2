// Phase functions, which both dialects spell alike.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Appends the phase function of a <phase>, nested ones first: isotropic, hg (`g`), rayleigh, tabphase
/// (`values`), blendphase or blend (`weight`). Throws SceneError.
PhaseId read_phase(const XmlElement& element, ReadContext& context);

/// The one phase function of a medium, as <phase> or <phasefunction>; nothing if it has none.
std::optional<PhaseId> find_phase(Properties& p);

}  // namespace sheaf
