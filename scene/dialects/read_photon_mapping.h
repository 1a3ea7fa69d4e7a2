// Properties of the integrators `photonmapper`, `ppm` and `sppm`, for both dialects.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Reads what a file says of photon maps, by the names of the Nori course (photonCount, photonRadius,
/// causticPhotonCount, causticRadius, volumePhotonCount, volumeRadius, mediumPhotons, finalGather, numGatherRays,
/// sampleDirect, kernel, lookupSize; of progressive maps initialRadius, alpha, maxPasses) or of Mitsuba 0.6
/// (globalPhotons, globalLookupRadius, causticPhotons, causticLookupRadius, volumePhotons, volumeLookupRadius: these
/// radii, or their names with Relative at the end, are parts of the scene's). Radii are metres otherwise; 0: chosen by
/// the scene's size. numGatherRays above 0 asks for final gathering by itself. Throws SceneError.
void read_photon_mapping(Properties& p, PhotonMappingDescription& mapping);

}  // namespace sheaf
