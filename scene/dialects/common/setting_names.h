// Names of samplers, light selectors and medium estimators, shared by all dialects and the command line, and the
// integrator properties that select them.
#pragma once

#include "scene/description.h"
#include "scene/xml/named_values.h"

#include <string>
#include <string_view>

namespace sheaf {

/// Names of samplers. The first name of a kind is its own; similar samplers of Sheaf replace those of Mitsuba and pbrt
/// that have the other names.
inline constexpr NameTable<SamplerKind> kSamplers{{{"independent", SamplerKind::kIndependent},
                                                   {"stratified", SamplerKind::kStratified},
                                                   {"multijitter", SamplerKind::kMultijitter},
                                                   {"sobol", SamplerKind::kSobol},
                                                   {"zsobol", SamplerKind::kZSobol},
                                                   {"ldsampler", SamplerKind::kSobol},
                                                   {"orthogonal", SamplerKind::kSobol},
                                                   {"halton", SamplerKind::kSobol},
                                                   {"hammersley", SamplerKind::kSobol},
                                                   {"paddedsobol", SamplerKind::kSobol},
                                                   {"pmj02bn", SamplerKind::kSobol}}};

/// Returns a note for the user if another sampler replaces the named one; else empty.
std::string sampler_substitution_note(std::string_view name);

/// Returns the sampler kind to render with for a scene file that names `named`, unless the user overrides it. Sobol
/// replaces `independent`, because exporters write `independent` only as the default.
SamplerKind rendered_sampler(SamplerKind named);

/// Returns a note for the user if rendered_sampler() changes the kind; else empty.
std::string rendered_sampler_note(SamplerKind named);

/// Returns a note for the user if this sampler rounds `sample_count` samples per pixel up; else empty.
std::string rounding_note(SamplerKind kind, std::uint32_t sample_count);

inline constexpr NameTable<LightSelector> kLightSelectors{
    {{"uniform", LightSelector::kUniform}, {"power", LightSelector::kPower}, {"bvh", LightSelector::kBvh}}};

/// Reads `light_sampler` (a name) and `candidates` (light samples per vertex; RIS keeps one). Throws SceneError.
void read_light_sampling(NamedValues& p, IntegratorSettings& integrator);

inline constexpr NameTable<MediumEstimator> kMediumEstimators{{{"null_mis", MediumEstimator::kNullMis},
                                                               {"delta", MediumEstimator::kDelta},
                                                               {"ratio", MediumEstimator::kRatio},
                                                               {"marching", MediumEstimator::kMarching}}};

/// Reads `medium_estimator` (a name) and `step_size` (m, positive). Throws SceneError.
void read_medium_estimation(NamedValues& p, IntegratorSettings& integrator);

}  // namespace sheaf
