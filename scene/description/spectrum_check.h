// Validation of spectra by their use.
#pragma once

#include "scene/description/description.h"

#include <string_view>

namespace sheaf {

/// The use of a spectrum; determines which values are valid.
enum class SpectrumRole {
  kReflectance,  ///< within [0, 1]
  kEmission,     ///< not negative
  kIor,          ///< not negative
};

/// Throws SceneError unless the table has at least two entries and as many values as wavelengths, and its wavelengths
/// are positive and strictly increasing.
void check_table(const SpectrumDescription::Table& table, const SourceLocation& where);

/// Throws SceneError if a value is invalid for the role.
void check_role(const SpectrumDescription& spectrum, SpectrumRole role, const SourceLocation& where,
                std::string_view what);

}  // namespace sheaf
