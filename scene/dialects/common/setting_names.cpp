#include "scene/dialects/common/setting_names.h"

namespace sheaf {

std::string stand_in_sampler_note(std::string_view name) {
  const SamplerKind* kind = kSamplers.find(name);
  if (kind == nullptr || name == kSamplers.name_of(*kind)) return {};
  return "sampler '" + std::string(name) + "' is rendered with '" + kSamplers.name_of(*kind) + "'";
}

SamplerKind rendered_sampler(SamplerKind named) {
  return named == SamplerKind::kIndependent ? SamplerKind::kSobol : named;
}

std::string rendered_sampler_note(SamplerKind named) {
  const SamplerKind kind = rendered_sampler(named);
  if (kind == named) return {};
  const std::string name = kSamplers.name_of(named);
  return "sampler '" + name + "' is rendered with '" + kSamplers.name_of(kind) + "', which is less noisy; --sampler " +
         name + " keeps it";
}

std::string rounding_note(SamplerKind kind, std::uint32_t sample_count) {
  const std::uint32_t rounded = rounded_sample_count(kind, sample_count);
  if (rounded == sample_count) return {};
  const SampleGrid grid = make_sampler(kind, 0, rounded).grid;
  return "sampler '" + std::string(kSamplers.name_of(kind)) + "': " + std::to_string(sample_count) +
         " samples per pixel become " + std::to_string(rounded) +
         (kind == SamplerKind::kZSobol
              ? std::string(", a power of two")
              : ", a grid of " + std::to_string(grid.columns) + " x " + std::to_string(grid.rows));
}

void read_light_sampling(NamedValues& p, IntegratorSettings& integrator) {
  const int candidates = p.integer("candidates", integrator.candidates.value_or(1), 1, kMaxCandidates);
  if (p.has("candidates")) integrator.candidates = candidates;
  integrator.light_selector = p.choice("light_sampler", kLightSelectors, integrator.light_selector);
}

void read_medium_estimation(NamedValues& p, IntegratorSettings& integrator) {
  integrator.step_size = p.number("step_size", integrator.step_size, kPositive);
  integrator.medium_estimator = p.choice("medium_estimator", kMediumEstimators, integrator.medium_estimator);
}

}  // namespace sheaf
