#include "scene/dialects/common/setting_names.h"

namespace sheaf {

std::string sampler_substitution_note(std::string_view name) {
  const SamplerKind* kind = kSamplers.find(name);
  if (kind == nullptr || name == kSamplers.name_of(*kind)) return {};
  return fmt::format("sampler '{}' is rendered with '{}'", name, kSamplers.name_of(*kind));
}

SamplerKind rendered_sampler(SamplerKind named) {
  return named == SamplerKind::kIndependent ? SamplerKind::kSobol : named;
}

std::string rendered_sampler_note(SamplerKind named) {
  const SamplerKind kind = rendered_sampler(named);
  if (kind == named) return {};
  const std::string name = kSamplers.name_of(named);
  return fmt::format("sampler '{}' is rendered with '{}', which is less noisy; --sampler {} keeps it", name,
                     kSamplers.name_of(kind), name);
}

std::string rounding_note(SamplerKind kind, std::uint32_t sample_count) {
  const std::uint32_t rounded = rounded_sample_count(kind, sample_count);
  if (rounded == sample_count) return {};
  const SampleGrid grid = make_sampler(kind, 0, rounded).grid;
  return fmt::format("sampler '{}': {} samples per pixel become {}{}", kSamplers.name_of(kind), sample_count, rounded,
                     kind == SamplerKind::kZSobol ? std::string(", a power of two")
                                                  : fmt::format(", a grid of {} x {}", grid.columns, grid.rows));
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
