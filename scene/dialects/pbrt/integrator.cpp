// The pbrt dialect: integrators and samplers, replaced by Sheaf's with the same expected image.
#include "scene/dialects/common/frame_limits.h"
#include "scene/dialects/common/integrators.h"
#include "scene/dialects/common/setting_names.h"
#include "scene/dialects/pbrt/reader.h"

#include <algorithm>
#include <cmath>

namespace sheaf::pbrt {

namespace {

constexpr int kMaxDepth = 1'000'000;

void read_progressive(Parameters& p, PhotonMappingSettings& photons) {
  const FilmSettings& film = p.reader().description.film;
  const int pixels = static_cast<int>(std::min(std::int64_t{film.width} * film.height, std::int64_t{100'000'000}));
  const int count = p.integer("photonsperiteration", -1, -1, 100'000'000);
  photons.global = {static_cast<std::uint64_t>(count > 0 ? count : pixels), p.number("radius", 1, kPositive), 0};
  p.ignore({"seed"});
}

/// Reads ambient occlusion, under pbrt's name or Sheaf's, or average visibility. The scene is made white after reading.
void read_visibility(Parameters& p, const IntegratorMatch& found, Reader& reader) {
  const bool average = traits_of(found.entry->kind).measures_visibility;
  const float length = p.number(average ? "length" : "maxdistance", kInfinity, kPositive);
  if (!average && std::isfinite(length))
    p.unsupported("ambient occlusion within 'maxdistance'", "rendered without a maximum distance");
  p.ignore({"cossample"});
  reader.visibility = {found, length};
}

/// Finds an integrator by its name in pbrt or in the other dialects. Throws SceneError for an unknown name.
IntegratorMatch find_entity(Parameters& p, const DirectiveArguments& entity) {
  if (const auto found = find_integrator(entity.type, true)) return *found;
  if (entity.type == "function") {
    p.unsupported("integrators of this kind", "rendered with 'path'");
    p.ignore({"function", "filename", "skipbad"});
    return *find_integrator("path");
  }
  std::vector<std::string> known = integrator_names();
  known.emplace_back("function");
  throw SceneError(
      entity.where,
      fmt::format("unknown integrator '{}'{}{}", entity.type, did_you_mean(entity.type, known), known_names(known)),
      SceneErrorCode::kUnknownName);
}

}  // namespace

void read_integrator(Reader& reader, DirectiveArguments entity) {
  Parameters p(reader, fmt::format("Integrator '{}'", entity.type), entity.where, std::move(entity.parameters));
  const IntegratorMatch found = find_entity(p, entity);
  if (found.entry->whitens_scene) {
    read_visibility(p, found, reader);
    return p.reject_unused();
  }
  IntegratorSettings& integrator = reader.description.integrator;
  // In pbrt depth 0 is emission only, here depth 1.
  integrator.max_depth = p.integer("maxdepth", 5, 0, kMaxDepth) + 1;
  apply(found, integrator);
  if (integrator.photons.progressive) read_progressive(p, integrator.photons);
  report_substitution(entity.where, entity.type, found, reader.description);
  static constexpr NameTable<LightSelector> kSelectors{{{"bvh", LightSelector::kBvh},
                                                        {"exhaustive", LightSelector::kBvh},
                                                        {"power", LightSelector::kPower},
                                                        {"uniform", LightSelector::kUniform}}};
  integrator.light_selector = p.choice("lightsampler", kSelectors, LightSelector::kBvh);
  p.ignore({"regularize", "samplebsdf", "samplelights", "visualizestrategies", "visualizeweights", "bootstrapsamples",
            "chains", "mutationsperpixel", "largestepprobability", "sigma"});
  p.reject_unused();
}

void read_sampler(Reader& reader, DirectiveArguments entity) {
  Parameters p(reader, fmt::format("Sampler '{}'", entity.type), entity.where, std::move(entity.parameters));
  SamplerSettings& sampler = reader.description.sampler;
  const std::string& type = entity.type;
  sampler.kind = plugin(kSamplers, "sampler", type, entity.where);
  const bool is_own = type == "halton" || type == "paddedsobol" || type == "pmj02bn";
  if (const std::string note = sampler_substitution_note(type); !is_own && !note.empty())
    reader.note(entity.where, note);
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
