#include "kernels/render/continuation.h"

#include "kernels/passes/photon_mapping.h"

namespace sheaf {

namespace {

/// Whether a sampler gives the same numbers for sets of any size.
bool is_sequence(SamplerKind kind) { return kind == SamplerKind::kSobol || kind == SamplerKind::kIndependent; }

std::string count_text(std::uint32_t samples) { return fmt::format("{} samples", samples); }

/// Why the samples of the checkpoint are not the first ones of the layout; empty if they are.
std::string sampling_problem(const RenderSettings& settings, const RenderState& state) {
  const SampleDivision& before = state.division;
  const bool is_one_set = before.replicate_samples >= before.spp;
  if (settings.replicate_samples != before.replicate_samples && !is_sequence(settings.sampler.kind))
    return is_one_set ? "the sampler distributes all samples of a pixel over one grid or sequence"
                      : fmt::format("the sampler distributes sets of {}, but the new sets have {}",
                                    count_text(before.replicate_samples), count_text(settings.replicate_samples));
  const std::uint32_t end = state.tiles.empty() ? state.first_sample : state.first_sample + 1;
  if (begins_with(settings, before, end)) return "";
  if (before.half_samples > 0) return "the layer half holds the first half of the samples";
  if (!is_one_set)
    return fmt::format(
        "its samples form sets of {}, but the new sets have {} (choose a multiple of the set size as --spp)",
        count_text(before.replicate_samples), count_text(settings.replicate_samples));
  if (settings.replicate_samples < settings.spp)
    return fmt::format(
        "its samples form one set, but the new ones are divided into sets of {} (--replicates 1 keeps one set)",
        count_text(settings.replicate_samples));
  return "one set can only be continued from a multiple of " + count_text(before.max_pass_samples);
}

/// Why precomputed data, on which the samples depend, differ for another number of samples; empty if they do not.
std::string precomputation_problem(const RenderSettings& settings, const RenderState& state) {
  const IntegratorSettings& integrator = settings.integrator;
  const int width = settings.film.width, height = settings.film.height;
  const std::uint32_t before = state.division.spp;
  if (trains_guide(settings.guiding, integrator)) {
    if (settings.training != training_passes(width, height, before, settings.guiding))
      return "path guiding trains longer for more samples (--guiding off renders without)";
    if (settings.compares_candidates != wants_candidate_comparison(integrator, width, height, before))
      return "a render of so few samples has one light candidate (--candidates 1 keeps it)";
  }
  if (!integrator.traits().has_photon_maps() || integrator.photons.progressive) return "";
  const auto sets = [&](std::uint32_t spp) { return photon_map_sets(integrator.photons, settings.color, spp); };
  return sets(settings.spp) == sets(before) ? "" : "the photons are divided among more sets of wavelengths";
}

std::string problem_of(const RenderSettings& settings, const RenderState& state) {
  if (settings.adapts && !state.adaptive)
    return "--time-limit now, not in the checkpoint: renders with a time limit divide their samples in another way";
  if (!settings.adapts && state.adaptive)
    return fmt::format(
        "--time-limit in the checkpoint, not now: give it again, or --spp {} to take all samples that remain",
        state.division.spp);
  if (settings == state.division) return "";
  if (settings.spp < state.division.spp) return "it is a render of more samples";
  if (settings.adapts || state.adaptive) return "adaptive sampling depends on the maximum number of samples";
  const std::string problem = precomputation_problem(settings, state);
  return problem.empty() ? sampling_problem(settings, state) : problem;
}

}  // namespace

Continuation continue_from(const RenderSettings& requested, const RenderState& state) {
  // Without its time limit, a render takes the samples that remain
  const bool keeps_adapting = state.adaptive && !requested.adapts && requested.spp == state.division.spp;
  const RenderSettings settings = keeps_adapting ? with_adaptive_sampling(requested) : requested;
  const std::string problem = problem_of(settings, state);
  const std::uint32_t size = state.division.replicate_samples;
  if (problem.empty() || settings.requests_replicates || size >= state.division.spp) return {settings, problem};
  // Keep the size of the sets
  const RenderSettings same_size = with_replicates(settings, (settings.spp + size - 1) / size);
  const std::string remaining = problem_of(same_size, state);
  return {remaining.empty() ? same_size : settings, remaining};
}

}  // namespace sheaf
