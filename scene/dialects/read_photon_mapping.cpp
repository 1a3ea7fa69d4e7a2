#include "scene/dialects/read_photon_mapping.h"

namespace sheaf {

namespace {

/// The names of one map's properties.
struct MapNames {
  const char *count, *also_count, *radius, *also_radius, *relative_radius;
};

void read_map(Properties& p, const MapNames& names, PhotonMapDescription& map) {
  for (const char* name : {names.count, names.also_count})
    if (p.has(name)) map.count = static_cast<std::uint64_t>(p.integer(name, 0, 0, static_cast<int>(kMaxPhotons)));
  for (const char* name : {names.radius, names.also_radius})
    if (p.has(name)) map.radius = p.number(name, 0, kNotNegative);
  map.relative_radius = p.number(names.relative_radius, map.relative_radius, kPositive);
}

PhotonKernel read_kernel(Properties& p) {
  const std::string name = p.find_string("kernel").value_or("disc");
  if (name == "disc" || name == "constant") return PhotonKernel::kDisc;
  if (name == "cone") return PhotonKernel::kCone;
  if (name == "epanechnikov") return PhotonKernel::kEpanechnikov;
  p.fail_at("kernel", "unknown kernel '" + name + "'" + did_you_mean(name, {"disc", "cone", "epanechnikov"}));
}

}  // namespace

void read_photon_mapping(Properties& p, PhotonMappingDescription& mapping) {
  read_map(p,
           {"photon_count", "global_photons", "photon_radius", "global_lookup_radius", "global_lookup_radius_relative"},
           mapping.global);
  read_map(p,
           {"caustic_photon_count", "caustic_photons", "caustic_radius", "caustic_lookup_radius",
            "caustic_lookup_radius_relative"},
           mapping.caustic);
  mapping.final_gather = p.boolean("final_gather", mapping.final_gather);
  constexpr int kMostRays = 65536;
  mapping.gather_rays = p.integer("num_gather_rays", mapping.gather_rays, 1, kMostRays);
  mapping.kernel = read_kernel(p);
}

}  // namespace sheaf
