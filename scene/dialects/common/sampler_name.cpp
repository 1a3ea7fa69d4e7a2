// Table of sampler names, including those that a similar sampler replaces.
#include "scene/dialects/common/sampler_name.h"

#include "core/error.h"
#include "scene/dialects/common/known_names.h"

namespace sheaf {

namespace {

/// The first entry of a kind is its own name.
constexpr NamedSampler kSamplers[] = {
    {"independent", SamplerKind::kIndependent, false},
    {"stratified", SamplerKind::kStratified, false},
    {"multijitter", SamplerKind::kMultijitter, false},
    {"sobol", SamplerKind::kSobol, false},
    {"zsobol", SamplerKind::kZSobol, false},
    {"ldsampler", SamplerKind::kSobol, true},
    {"orthogonal", SamplerKind::kSobol, true},
    {"halton", SamplerKind::kSobol, true},
    {"hammersley", SamplerKind::kSobol, true},
    {"paddedsobol", SamplerKind::kSobol, true},
    {"pmj02bn", SamplerKind::kSobol, true},
};

}  // namespace

const NamedSampler* find_sampler(std::string_view name) {
  for (const NamedSampler& named : kSamplers)
    if (name == named.name) return &named;
  return nullptr;
}

std::vector<std::string> sampler_names() {
  std::vector<std::string> names;
  for (const NamedSampler& named : kSamplers) names.emplace_back(named.name);
  return names;
}

const char* sampler_name(SamplerKind kind) {
  for (const NamedSampler& named : kSamplers)
    if (kind == named.kind) return named.name;
  return "";
}

SamplerKind sampler_from_name(std::string_view name) {
  const NamedSampler* named = find_sampler(name);
  if (named == nullptr)
    throw Error(ExitCode::kUsage, "unknown sampler '" + std::string(name) + "'" + did_you_mean(name, sampler_names()) +
                                      known_names(sampler_names()));
  return named->kind;
}

std::string stand_in_sampler_note(std::string_view name) {
  const NamedSampler* named = find_sampler(name);
  if (named == nullptr || !named->alike) return {};
  return "sampler '" + std::string(name) + "' is rendered with '" + sampler_name(named->kind) + "'";
}

SamplerKind rendered_sampler(SamplerKind named) {
  return named == SamplerKind::kIndependent ? SamplerKind::kSobol : named;
}

std::string rendered_sampler_note(SamplerKind named) {
  const SamplerKind kind = rendered_sampler(named);
  if (kind == named) return {};
  const std::string name = sampler_name(named);
  return "sampler '" + name + "' is rendered with '" + sampler_name(kind) + "', which is less noisy; --sampler " +
         name + " keeps it";
}

std::string rounding_note(SamplerKind kind, std::uint32_t sample_count) {
  const std::uint32_t rounded = rounded_sample_count(kind, sample_count);
  if (rounded == sample_count) return {};
  const SampleGrid grid = make_sampler(kind, 0, rounded).grid;
  return "sampler '" + std::string(sampler_name(kind)) + "': " + std::to_string(sample_count) +
         " samples per pixel become " + std::to_string(rounded) +
         (kind == SamplerKind::kZSobol
              ? std::string(", a power of two")
              : ", a grid of " + std::to_string(grid.columns) + " x " + std::to_string(grid.rows));
}

}  // namespace sheaf
