// Names of samplers, shared by all dialects and the command line.
#pragma once

#include "core/sampler.h"

#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// A name and its sampler kind.
struct NamedSampler {
  const char* name;
  SamplerKind kind;
  bool alike;  ///< a similar sampler of Sheaf replaces the named one
};

/// Returns the sampler of this name, or null.
const NamedSampler* find_sampler(std::string_view name);

/// Returns all sampler names.
std::vector<std::string> sampler_names();

/// Returns the name of a kind.
const char* sampler_name(SamplerKind kind);

/// Returns the kind of `name`: independent, stratified, multijitter, sobol, zsobol, or sobol in place of other samplers
/// of Mitsuba and pbrt. Throws Error (usage) for an unknown name; the message lists the nearest name and all names.
SamplerKind sampler_from_name(std::string_view name);

/// Returns a note for the user if another sampler replaces the named one; else empty.
std::string stand_in_sampler_note(std::string_view name);

/// Returns the sampler kind to render with for a scene file that names `named`, unless the user overrides it. Sobol
/// replaces `independent`, because exporters write `independent` only as the default.
SamplerKind rendered_sampler(SamplerKind named);

/// Returns a note for the user if rendered_sampler() changes the kind; else empty.
std::string rendered_sampler_note(SamplerKind named);

/// Returns a note for the user if this sampler rounds `sample_count` samples per pixel up; else empty.
std::string rounding_note(SamplerKind kind, std::uint32_t sample_count);

}  // namespace sheaf
