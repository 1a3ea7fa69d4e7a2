// Photon map settings of the Nori and Mitsuba dialects.
#include "scene/dialects/xml/read_photon_mapping.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Property names of one photon map: Nori's course, then Mitsuba 0.6.
struct MapNames {
  const char *count, *also_count, *radius, *lookup_radius, *relative_radius;
};

void read_map(Properties& p, const MapNames& names, PhotonMapSettings& map) {
  for (const char* name : {names.count, names.also_count})
    map.count =
        static_cast<std::uint64_t>(p.integer(name, static_cast<int>(map.count), 0, static_cast<int>(kMaxPhotons)));
  map.radius = p.number(names.radius, map.radius, kNotNegative);
  for (const char* name : {names.lookup_radius, names.relative_radius})
    map.relative_radius = p.number(name, map.relative_radius, kPositive);
}

/// Reads the gathering mode. A positive number of gather rays enables final gathering unless `final_gather` is false.
void read_gathering(Properties& p, PhotonMappingSettings& mapping) {
  constexpr int kMaxRays = 65536;
  const bool direct = p.boolean("sample_direct", mapping.gathering != PhotonGathering::kAll);
  const int rays = p.integer("num_gather_rays", 0, 0, kMaxRays);
  mapping.gather_rays = std::max(rays, 1);
  const bool is_final = p.boolean("final_gather", rays > 0 || mapping.gathering == PhotonGathering::kFinal);
  mapping.gathering = is_final ? PhotonGathering::kFinal : direct ? PhotonGathering::kIndirect : PhotonGathering::kAll;
}

PhotonKernel read_kernel(Properties& p) {
  static constexpr NameTable<PhotonKernel> kKernels{{{"disc", PhotonKernel::kDisc},
                                                     {"constant", PhotonKernel::kDisc},
                                                     {"cone", PhotonKernel::kCone},
                                                     {"epanechnikov", PhotonKernel::kEpanechnikov}}};
  return p.choice("kernel", kKernels, PhotonKernel::kDisc);
}

MediumPhotons read_medium_photons(Properties& p) {
  static constexpr NameTable<MediumPhotons> kKinds{
      {{"auto", MediumPhotons::kAuto}, {"points", MediumPhotons::kPoints}, {"beams", MediumPhotons::kBeams}}};
  return p.choice("medium_photons", kKinds, MediumPhotons::kAuto);
}

}  // namespace

void read_photon_mapping(Properties& p, PhotonMappingSettings& mapping) {
  const bool counts_caustics = p.has("caustic_photon_count") || p.has("caustic_photons");
  const bool counts_volume = p.has("volume_photon_count") || p.has("volume_photons");
  const bool has_volume_radius =
      p.has("volume_radius") || p.has("volume_lookup_radius") || p.has("volume_lookup_radius_relative");
  read_map(p,
           {"photon_count", "global_photons", "photon_radius", "global_lookup_radius", "global_lookup_radius_relative"},
           mapping.global);
  read_map(p,
           {"caustic_photon_count", "caustic_photons", "caustic_radius", "caustic_lookup_radius",
            "caustic_lookup_radius_relative"},
           mapping.caustic);
  read_map(p,
           {"volume_photon_count", "volume_photons", "volume_radius", "volume_lookup_radius",
            "volume_lookup_radius_relative"},
           mapping.volume);
  mapping.medium_photons = read_medium_photons(p);
  read_gathering(p, mapping);
  // If the global map carries all light, the dialect's default number of caustic photons does not apply.
  if (mapping.gathering == PhotonGathering::kAll && !counts_caustics) mapping.caustic.count = 0;
  mapping.kernel = read_kernel(p);
  for (const char* name : {"lookup_size", "global_lookup_size"})
    mapping.lookup_size = p.integer(name, mapping.lookup_size, 0, kMaxLookupSize);
  if (p.type() == "volumetricphotonmapper") {
    if (!counts_volume) mapping.volume.count = mapping.global.count;
    if (!has_volume_radius) {
      mapping.volume.radius = mapping.global.radius;
      mapping.volume.relative_radius = mapping.global.relative_radius;
    }
  }
  if (!mapping.progressive) return;
  mapping.global.radius = p.number("initial_radius", mapping.global.radius, kNotNegative);
  mapping.alpha = p.number("alpha", mapping.alpha, {0, 1, true});
  constexpr int kMaxPasses = 1 << 22;
  mapping.max_passes = std::max(p.integer("max_passes", 0, -1, kMaxPasses), 0);
}

}  // namespace sheaf
