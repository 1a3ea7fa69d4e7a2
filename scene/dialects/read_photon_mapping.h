// Properties of the integrator `photonmapper`, for both dialects.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Reads what a file says of photon maps, by the names of the Nori course (photonCount, photonRadius,
/// causticPhotonCount, causticRadius, finalGather, numGatherRays, kernel) or of Mitsuba 0.6 (globalPhotons,
/// globalLookupRadius, globalLookupRadiusRelative, causticPhotons, causticLookupRadius, causticLookupRadiusRelative).
/// Radii are metres; 0: chosen by the scene's size. Throws SceneError.
void read_photon_mapping(Properties& p, PhotonMappingDescription& mapping);

}  // namespace sheaf
