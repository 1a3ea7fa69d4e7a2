// The names of samplers, in all dialects and on the command line.
#pragma once

#include "core/sampler.h"

#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// What a name stands for.
struct NamedSampler {
  const char* name;
  SamplerKind kind;
  bool alike;  ///< another sampler of the same purpose stands in for the one of this name
};

/// The sampler of this name, or null.
const NamedSampler* find_sampler(std::string_view name);

/// All names.
std::vector<std::string> sampler_names();

/// The name of a kind.
const char* sampler_name(SamplerKind kind);

/// The kind that `name` stands for: independent, stratified, multijitter, sobol, zsobol, and the other samplers of
/// Mitsuba and pbrt, for which sobol stands in. Throws Error (usage) for an unknown name, with the nearest known one
/// and all others.
SamplerKind sampler_from_name(std::string_view name);

/// What to tell the user if another sampler stands in for the one of this name; else empty.
std::string stand_in_sampler_note(std::string_view name);

/// The kind with which to render a scene whose file names `named`, unless the user asks for it. Exporters write
/// `independent` because readers have it as default, not because somebody wants its noise: it becomes sobol.
SamplerKind rendered_sampler(SamplerKind named);

/// What to tell the user if that is another kind; empty if it is not.
std::string rendered_sampler_note(SamplerKind named);

/// What to tell the user if `sample_count` samples per pixel become more with this sampler; empty if they do not.
std::string rounding_note(SamplerKind kind, std::uint32_t sample_count);

}  // namespace sheaf
