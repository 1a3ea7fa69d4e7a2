// The Mitsuba dialect: integrators. Integrators with the same expected image are mapped to Sheaf's, with a note.
#include "scene/dialects/common/integrators.h"
#include "scene/dialects/common/setting_names.h"
#include "scene/dialects/mitsuba/reader.h"
#include "scene/dialects/xml/read_photon_mapping.h"

namespace sheaf::mitsuba {

namespace {

constexpr int kMaxDepth = 1'000'000;

/// Default maximum depth. The `prb` integrators limit it because they compute derivatives, which is expensive.
int usual_depth(const std::string& type) { return type.starts_with("prb") ? 6 : -1; }

void read_photon_maps(Properties& p, IntegratorSettings& integrator) {
  PhotonMappingSettings& photons = integrator.photons;
  if (!photons.progressive) {
    photons.global = {250'000, 0, 0.05f};
    photons.caustic = {250'000, 0, 0.0125f};
    photons.volume.count = 250'000;
    photons.gathering = PhotonGathering::kIndirect;
    photons.lookup_size = 120;
  }
  read_photon_mapping(p, photons);
  p.ignore({"direct_samples", "glossy_samples", "granularity", "cache_photons", "auto_cancel_gathering",
            "gather_locally", "max_specular_depth", "caustic_lookup_size", "volume_lookup_size"});
}

void read_path_like(Properties& p, const IntegratorMatch& found, IntegratorSettings& integrator) {
  integrator.max_depth = p.integer("max_depth", usual_depth(p.type()), -1, kMaxDepth);
  if (p.has("rr_depth")) integrator.rr_depth = p.integer("rr_depth", 0, 1, kMaxDepth);
  integrator.hide_emitters = p.boolean("hide_emitters", false);
  apply(found, integrator);
  read_light_sampling(p, integrator);
  read_medium_estimation(p, integrator);
  p.ignore({"strict_normals", "samples_per_pass", "block_size", "timeout"});
  if (integrator.traits().has_photon_maps()) read_photon_maps(p, integrator);
  if (p.type() == "ptracer") p.ignore({"granularity", "brute_force", "samples_per_pass"});
  if (p.type() == "volpathmis") p.ignore({"use_spectral_mis"});
  // Forks of Mitsuba use `version` to select among equivalent estimators, and the others for intermediate output.
  if (p.type().starts_with("volpath")) p.ignore({"version"});
  if (integrator.photons.progressive) p.ignore({"k_nn", "step_snapshot", "dual_buffer", "granularity"});
}

/// Reads an integrator with the same expected image; ignores its own properties.
void read_substitute(Properties& p, const IntegratorMatch& found, IntegratorSettings& integrator) {
  read_path_like(p, found, integrator);
  p.ignore_all();
  report_substitution(p.where(), p.type(), found, p.context().remarks);
}

/// Reads `direct`. Several samples per strategy have the same expectation as one; 0 samples disable a strategy.
void read_direct(Properties& p, const IntegratorMatch& found, IntegratorSettings& integrator) {
  constexpr int kMax = 1'000'000;
  apply(found, integrator);
  integrator.hide_emitters = p.boolean("hide_emitters", false);
  const int shading = p.integer("shading_samples", 1, 1, kMax);
  const int lights = p.integer("emitter_samples", shading, 0, kMax);
  const int bsdfs = p.integer("bsdf_samples", shading, 0, kMax);
  if (lights + bsdfs == 0)
    p.report("has 0 'emitter_samples' and 0 'bsdf_samples', expected at least 1 of either", SceneErrorCode::kOutOfRange,
             "rendered with 1 of both");
  if (bsdfs == 0 && lights > 0) integrator.strategy = LightStrategy::kLightOnly;
  if (lights == 0 && bsdfs > 0) integrator.strategy = LightStrategy::kBsdfOnly;
  read_light_sampling(p, integrator);
  read_medium_estimation(p, integrator);
  if (std::max(lights, bsdfs) > 1)
    p.context().note(p.where(),
                     "sample counts per strategy rendered as 1: raise the sampler's sample_count for less noise");
  p.ignore({"strict_normals", "samples_per_pass", "block_size", "timeout"});
}

void read_wrapper(Properties& p, Reader& reader) {
  if (p.type() == "aov" && p.find_string("aovs"))
    p.context().note(p.where(), "'aovs' ignored: choose layers with --aov");
  if (p.type() == "stokes") p.context().note(p.where(), "integrator 'stokes' ignored: polarization is not simulated");
  const std::vector<const XmlElement*> nested = p.objects("integrator");
  if (nested.empty()) p.fail("has no nested <integrator>, expected one", SceneErrorCode::kMissing);
  if (nested.size() > 1 && p.type() != "multichannel")
    p.fail(fmt::format("has {} nested <integrator>, expected one", nested.size()));
  p.ignore_all();
  read_integrator(*nested[0], reader);
}

/// Integrators that only wrap a nested one.
constexpr NameTable<void (*)(Properties&, Reader&)> kWrappers{{{"adaptive", read_wrapper},
                                                               {"aov", read_wrapper},
                                                               {"irrcache", read_wrapper},
                                                               {"moment", read_wrapper},
                                                               {"multichannel", read_wrapper},
                                                               {"stokes", read_wrapper}}};

/// Reads ambient occlusion or average visibility.
void read_visibility(Properties& p, const IntegratorMatch& found) {
  const float length = p.number("length", kInfinity, kPositive);
  p.ignore({"samples_per_pass", "block_size", "timeout"});
  p.reject_unused();
  white_scene(found, length, true, p.context().description);
}

}  // namespace

void read_integrator(const XmlElement& element, Reader& reader) {
  Properties p(element, reader.context);
  IntegratorSettings& integrator = reader.context.description.integrator;
  if (const auto* read = kWrappers.find(p.type())) return (*read)(p, reader);
  const IntegratorMatch found = integrator_or_path(p, kWrappers.names());
  if (found.entry->whitens_scene) return read_visibility(p, found);
  if (found.is_substitute()) {
    read_substitute(p, found, integrator);
  } else if (p.type() == "direct") {
    read_direct(p, found, integrator);
  } else if (traits_of(found.entry->kind).uses_lights()) {
    read_path_like(p, found, integrator);
  } else {
    apply(found, integrator);
    p.ignore({"samples_per_pass", "block_size", "timeout"});
  }
  p.reject_unused();
}

}  // namespace sheaf::mitsuba
