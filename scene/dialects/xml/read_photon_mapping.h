// Properties of the integrators `photonmapper`, `ppm` and `sppm`, shared by the Nori and Mitsuba dialects.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// Reads the photon map settings. Names of the Nori course: photonCount, photonRadius, causticPhotonCount,
/// causticRadius, volumePhotonCount, volumeRadius, mediumPhotons, finalGather, numGatherRays, sampleDirect, kernel,
/// lookupSize; for progressive maps initialRadius, alpha, maxPasses. Names of Mitsuba 0.6: globalPhotons,
/// globalLookupRadius, causticPhotons, causticLookupRadius, volumePhotons, volumeLookupRadius. These lookup radii, also
/// with the suffix Relative, are fractions of the scene's radius. Other radii are in meters; 0 selects a radius by the
/// scene's size. numGatherRays above 0 enables final gathering. Throws SceneError.
void read_photon_mapping(Properties& p, PhotonMappingSettings& mapping);

}  // namespace sheaf
