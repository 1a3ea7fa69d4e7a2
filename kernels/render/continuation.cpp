#include "kernels/render/continuation.h"

#include "kernels/passes/photon_mapping.h"
#include "kernels/render/sample_layout.h"
#include "kernels/training/train_guiding.h"

namespace sheaf {

namespace {

/// Whether a sampler gives the same numbers for sets of any size.
bool is_sequence(SamplerKind kind) { return kind == SamplerKind::kSobol || kind == SamplerKind::kIndependent; }

std::string count_text(std::uint32_t samples) { return std::to_string(samples) + " samples"; }

/// Why the samples of the checkpoint are not the first ones of the layout; empty if they are.
std::string sampling_problem(const Scene& scene, const SampleLayout& layout, const RenderState& state) {
  const SampleDivision& before = state.division;
  const SamplerKind sampler = scene.sampler().kind;
  const bool is_one_set = before.replicate_samples >= before.spp;
  if (layout.replicate_samples != before.replicate_samples && !is_sequence(sampler))
    return is_one_set ? "the sampler distributes all samples of a pixel over one grid or sequence"
                      : "the sampler distributes sets of " + count_text(before.replicate_samples) +
                            ", but the new sets have " + count_text(layout.replicate_samples);
  const std::uint32_t end = state.tiles.empty() ? state.first_sample : state.first_sample + 1;
  if (begins_with(layout, before, end)) return "";
  if (before.half_samples > 0) return "the layer half holds the first half of the samples";
  if (!is_one_set)
    return "its samples form sets of " + count_text(before.replicate_samples) + ", but the new sets have " +
           count_text(layout.replicate_samples) + " (choose a multiple of the set size as --spp)";
  if (layout.replicate_samples < layout.spp)
    return "its samples form one set, but the new ones are divided into sets of " +
           count_text(layout.replicate_samples) + " (--replicates 1 keeps one set)";
  return "one set can only be continued from a multiple of " + count_text(before.max_pass_samples);
}

/// Why precomputed data, on which the samples depend, differ for another number of samples; empty if they do not.
std::string precomputation_problem(const Scene& scene, const RenderOptions& options, const SampleLayout& layout,
                                   const RenderState& state) {
  const IntegratorSettings& integrator = scene.integrator();
  if (trains_guide(options.guiding, integrator)) {
    const auto passes = [&](std::uint32_t spp) {
      return training_passes(scene.film().width, scene.film().height, spp, options.guiding);
    };
    if (passes(layout.spp) != passes(state.division.spp))
      return "path guiding trains longer for more samples (--guiding off renders without)";
    const auto has_trial = [&](std::uint32_t spp) {
      return wants_candidate_trial(integrator, scene.film().width, scene.film().height, spp);
    };
    if (has_trial(layout.spp) != has_trial(state.division.spp))
      return "a render of so few samples has one light candidate (--candidates 1 keeps it)";
  }
  if (!integrator.traits().has_photon_maps() || integrator.photons.progressive) return "";
  const auto sets = [&](std::uint32_t spp) { return photon_map_sets(integrator.photons, scene.color(), spp); };
  return sets(layout.spp) == sets(state.division.spp) ? "" : "the photons are divided among more sets of wavelengths";
}

std::string problem_of(const Scene& scene, const RenderOptions& options, const SampleLayout& layout,
                       const RenderState& state) {
  if (layout == state.division) return "";
  if (layout.spp < state.division.spp) return "it is a render of more samples";
  if (layout.adapts || state.adaptive) return "adaptive sampling depends on the maximum number of samples";
  const std::string problem = precomputation_problem(scene, options, layout, state);
  return problem.empty() ? sampling_problem(scene, layout, state) : problem;
}

}  // namespace

Continuation continue_from(const Scene& scene, const RenderOptions& options, const RenderState& state) {
  const SampleLayout layout = make_sample_layout(scene, options);
  Continuation found{layout.spp, options.replicates, problem_of(scene, options, layout, state)};
  const std::uint32_t size = state.division.replicate_samples;
  if (found.problem.empty() || options.replicates != 0 || size >= state.division.spp) return found;
  // Keep the size of the sets
  const std::uint32_t sets = (layout.spp + size - 1) / size;
  RenderOptions same_size = options;
  same_size.replicates = static_cast<int>(sets);
  const std::string problem = problem_of(scene, options, make_sample_layout(scene, same_size), state);
  return {layout.spp, problem.empty() ? same_size.replicates : 0, problem};
}

}  // namespace sheaf
