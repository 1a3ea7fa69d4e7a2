// The Mitsuba dialect: integrators. Those that compute the same picture in another way are mapped to ours with a note.
#include "scene/dialects/integrator_name.h"
#include "scene/dialects/light_selector_name.h"
#include "scene/dialects/medium_estimator_name.h"
#include "scene/dialects/mitsuba.h"
#include "scene/dialects/read_photon_mapping.h"

#include <algorithm>

namespace sheaf::mitsuba {

namespace {

constexpr int kMaxDepth = 1'000'000;

/// Integrators with the expectation of a path tracer, and the depth they stop at unless told.
struct PathLike {
  const char* name;
  int max_depth;
};
constexpr PathLike kPathLike[] = {
    {"path", -1},         {"bdpt", -1}, {"prb", 6},   {"prb_basic", 6}, {"prbvolpath", 6},  {"ptracer", -1},
    {"photonmapper", -1}, {"ppm", -1},  {"sppm", -1}, {"volpath", -1},  {"volpathmis", -1}, {"volpath_simple", -1},
};

void read_path_like(Properties& p, const PathLike& like, IntegratorDescription& integrator) {
  integrator.max_depth = p.integer("max_depth", like.max_depth, -1, kMaxDepth);
  integrator.rr_depth = p.integer("rr_depth", integrator.rr_depth, 1, kMaxDepth);
  integrator.hide_emitters = p.boolean("hide_emitters", false);
  if (const NamedIntegrator* named = find_integrator(p.type())) apply(*named, integrator);
  read_light_sampling(p, integrator);
  read_medium_estimation(p, integrator);
  p.accept({"strict_normals", "samples_per_pass", "block_size", "timeout"});
  if (p.type() == "bdpt") p.accept({"light_image", "sample_direct"});
  if (integrator.kind == IntegratorKind::kPhotonMapper) {
    PhotonMappingDescription& photons = integrator.photons;
    if (!photons.progressive) {
      photons.global = {250'000, 0, 0.05f};
      photons.caustic = {250'000, 0, 0.0125f};
      photons.volume.count = 250'000;
      photons.gathering = PhotonGathering::kIndirect;
      photons.lookup_size = 120;
    }
    read_photon_mapping(p, photons);
    p.accept({"direct_samples", "glossy_samples", "granularity", "cache_photons", "auto_cancel_gathering",
              "gather_locally", "max_specular_depth", "caustic_lookup_size", "volume_lookup_size"});
  }
  if (p.type() == "ptracer") p.accept({"granularity", "brute_force", "samples_per_pass"});
  if (p.type() == "volpathmis") p.accept({"use_spectral_mis"});
  for (const char* ours : {"path", "volpath", "vol_path", "medium_path", "ptracer", "photonmap", "ppm", "sppm"})
    if (p.type().starts_with(ours)) return;
  p.context().note(p.where(), "integrator '" + p.type() + "' is rendered with 'path', which has the same expectation");
}

/// Direct light. Several samples per strategy have the expectation of one; none switches the strategy off.
void read_direct(Properties& p, IntegratorDescription& integrator) {
  constexpr int kMost = 1'000'000;
  integrator.max_depth = 2;
  integrator.hide_emitters = p.boolean("hide_emitters", false);
  const int shading = p.integer("shading_samples", 1, 1, kMost);
  const int lights = p.integer("emitter_samples", shading, 0, kMost);
  const int bsdfs = p.integer("bsdf_samples", shading, 0, kMost);
  if (lights + bsdfs == 0) p.fail("has neither emitter_samples nor bsdf_samples");
  if (bsdfs == 0) integrator.strategy = LightStrategy::kLightOnly;
  if (lights == 0) integrator.strategy = LightStrategy::kBsdfOnly;
  read_light_sampling(p, integrator);
  read_medium_estimation(p, integrator);
  if (std::max(lights, bsdfs) > 1)
    p.context().note(p.where(), "direct light is sampled once per path; raise sample_count for less noise");
  p.accept({"strict_normals", "samples_per_pass", "block_size", "timeout"});
}

void read_wrapper(Properties& p, Reader& reader) {
  if (p.type() == "aov" && p.find_string("aovs"))
    p.context().note(p.where(), "the layers of 'aovs' are not written by the integrator");
  const XmlElement* nested = p.object("integrator");
  if (nested == nullptr) p.fail("holds no nested <integrator>, expected one");
  p.accept({"samples_per_pass", "block_size", "timeout"});
  p.finish();
  read_integrator(*nested, reader);
}

}  // namespace

void read_integrator(const XmlElement& element, Reader& reader) {
  Properties p(element, reader.context);
  IntegratorDescription& integrator = reader.context.description.integrator;
  if (p.type() == "moment" || p.type() == "aov") return read_wrapper(p, reader);
  const auto* like = std::find_if(std::begin(kPathLike), std::end(kPathLike),
                                  [&](const PathLike& candidate) { return p.type() == candidate.name; });
  if (like != std::end(kPathLike)) {
    read_path_like(p, *like, integrator);
  } else if (p.type() == "direct") {
    read_direct(p, integrator);
  } else if (p.type() == "depth") {
    integrator.kind = IntegratorKind::kDepth;
    p.accept({"samples_per_pass", "block_size", "timeout"});
  } else if (const NamedIntegrator* named = find_integrator(p.type())) {
    // Names that only Nori has.
    apply(*named, integrator);
    read_path_like(p, {named->name, -1}, integrator);
    if (named->direct) integrator.max_depth = 2;
  } else {
    std::vector<std::string> known = integrator_names();
    known.insert(known.end(), {"aov", "moment"});
    for (const PathLike& candidate : kPathLike)
      if (find_integrator(candidate.name) == nullptr) known.emplace_back(candidate.name);
    p.fail_plugin(known);
  }
  p.finish();
}

}  // namespace sheaf::mitsuba
