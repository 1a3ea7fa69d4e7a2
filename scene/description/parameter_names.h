// Declarations of the names of textures, materials and lights in files, and of their parameters.
#pragma once

#include "scene/description/inputs.h"

#include <array>

namespace sheaf {

/// Names of a parameter in files. kParameters of a model is an array of them, for its first fields, in order: spectra,
/// scalars, numbers and flags that are used as the file gives them. scene/xml/read_declared.h reads them.
struct ParameterName {
  const char* name = nullptr;         ///< null: files don't have the parameter
  const char* also = nullptr;         ///< alternative name
  NumberRange range = kUnitInterval;  ///< of scalars and numbers
};

/// A model that declares names of parameters.
template <class Model>
concept DeclaresParameters = requires {
  Model::kParameters;
};

/// kPlugins of a model that only some dialects know, each by a reader of its own.
inline constexpr std::array<const char*, 0> kNoPlugins{};

}  // namespace sheaf
