// The pbrt dialect: integrators and samplers, replaced by Sheaf's with the same expected image.
#include "scene/dialects/common/frame_limits.h"
#include "scene/dialects/common/integrator_name.h"
#include "scene/dialects/common/setting_names.h"
#include "scene/dialects/common/visibility_integrators.h"
#include "scene/dialects/pbrt/reader.h"

#include <algorithm>
#include <cmath>

namespace sheaf::pbrt {

namespace {

/// Sheaf's integrator in place of one of pbrt.
struct Counterpart {
  const char* name;
  bool alike;  ///< same expected image by another algorithm
};
constexpr NameTable<Counterpart> kIntegrators{{{"volpath", {"path", false}},
                                               {"path", {"path", false}},
                                               {"simplevolpath", {"path", false}},
                                               {"bdpt", {"path", true}},
                                               {"simplepath", {"path", false}},
                                               {"mlt", {"path", true}},
                                               {"sppm", {"sppm", false}},
                                               {"lightpath", {"ptracer", false}},
                                               {"randomwalk", {"path", true}}}};

constexpr int kMaxDepth = 1'000'000;

void read_progressive(Parameters& p, PhotonMappingSettings& photons) {
  const FilmSettings& film = p.reader().description.film;
  const int pixels = static_cast<int>(std::min(std::int64_t{film.width} * film.height, std::int64_t{100'000'000}));
  const int count = p.integer("photonsperiteration", -1, -1, 100'000'000);
  photons.global = {static_cast<std::uint64_t>(count > 0 ? count : pixels), p.number("radius", 1, kPositive), 0};
  p.ignore({"seed"});
}

/// Reads ambient occlusion, under pbrt's name or Sheaf's, or average visibility. The scene is made white after reading.
void read_visibility(Parameters& p, Visibility visibility, Reader& reader) {
  const bool average = visibility == Visibility::kAverage;
  const float length = p.number(average ? "length" : "maxdistance", kInfinity, kPositive);
  if (!average && std::isfinite(length))
    p.unsupported("ambient occlusion within 'maxdistance'", "rendered without a maximum distance");
  p.ignore({"cossample"});
  reader.visibility = {visibility, length};
}

/// Finds an integrator by its name in pbrt or in the other dialects. Throws SceneError for an unknown name.
Counterpart find_counterpart(Parameters& p, const Entity& entity) {
  const std::string& type = entity.type;
  if (const Counterpart* found = kIntegrators.find(type)) return *found;
  if (type == "function") {
    p.unsupported("integrators of this kind", "rendered with 'path'");
    p.ignore({"function", "filename", "skipbad"});
    return {"path", false};
  }
  if (const char* const* ours = kStandInIntegrators.find(type)) return {*ours, true};
  if (find_integrator(type) != nullptr) return {type.c_str(), false};
  std::vector<std::string> known = integrator_names();
  known.emplace_back("function");
  throw SceneError(entity.where, "unknown integrator '" + type + "'" + did_you_mean(type, known) + known_names(known));
}

}  // namespace

void read_integrator(Reader& reader, Entity entity) {
  Parameters p(reader, "Integrator '" + entity.type + "'", entity.where, std::move(entity.parameters));
  if (const Visibility* visibility = kVisibilityIntegrators.find(entity.type)) {
    read_visibility(p, *visibility, reader);
    return p.reject_unused();
  }
  IntegratorSettings& integrator = reader.description.integrator;
  const Counterpart found = find_counterpart(p, entity);
  // In pbrt depth 0 is emission only, here depth 1.
  integrator.max_depth = p.integer("maxdepth", 5, 0, kMaxDepth) + 1;
  apply(*find_integrator(found.name), integrator);
  if (integrator.kind == IntegratorKind::kPhotonMapper && integrator.photons.progressive)
    read_progressive(p, integrator.photons);
  if (found.alike)
    reader.note(entity.where, "integrator '" + entity.type + "' is rendered with '" + found.name +
                                  "', which has the same expectation");
  static constexpr NameTable<LightSelector> kSelectors{{{"bvh", LightSelector::kBvh},
                                                        {"exhaustive", LightSelector::kBvh},
                                                        {"power", LightSelector::kPower},
                                                        {"uniform", LightSelector::kUniform}}};
  integrator.light_selector = p.choice("lightsampler", kSelectors, LightSelector::kBvh);
  p.ignore({"regularize", "samplebsdf", "samplelights", "visualizestrategies", "visualizeweights", "bootstrapsamples",
            "chains", "mutationsperpixel", "largestepprobability", "sigma"});
  p.reject_unused();
}

void read_sampler(Reader& reader, Entity entity) {
  Parameters p(reader, "Sampler '" + entity.type + "'", entity.where, std::move(entity.parameters));
  SamplerSettings& sampler = reader.description.sampler;
  const std::string& type = entity.type;
  sampler.kind = plugin(kSamplers, "sampler", type, entity.where);
  const bool is_own = type == "halton" || type == "paddedsobol" || type == "pmj02bn";
  if (const std::string note = stand_in_sampler_note(type); !is_own && !note.empty()) reader.note(entity.where, note);
  int count = 0;
  if (type == "stratified") {
    constexpr int kMaxPerSide = 1 << 12;
    static_assert(kMaxPerSide * kMaxPerSide == kMaxSampleCount);
    count = p.integer("xsamples", 4, 1, kMaxPerSide) * p.integer("ysamples", 4, 1, kMaxPerSide);
    p.ignore({"jitter"});
  } else {
    count = p.integer("pixelsamples", 16, 1, kMaxSampleCount);
  }
  sampler.sample_count = static_cast<std::uint32_t>(count);
  if (p.has("seed"))
    sampler.seed = static_cast<std::uint32_t>(p.integer("seed", 0, 0, std::numeric_limits<int>::max()));
  p.ignore({"randomization"});
  p.reject_unused();
}

}  // namespace sheaf::pbrt
