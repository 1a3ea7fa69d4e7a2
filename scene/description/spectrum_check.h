// Which spectra are legal, and for what.
#pragma once

#include "scene/description/description.h"

#include <string_view>

namespace sheaf {

/// What a spectrum is used for; decides which values are legal.
enum class SpectrumRole {
  kReflectance,  ///< within [0, 1]
  kEmission,     ///< not negative
  kIor,          ///< not negative
};

/// Throws SceneError unless the table has two entries or more, as many values as wavelengths, and its wavelengths
/// increase strictly and are positive.
void check_table(const SpectrumDescription::Table& table, const SourceLocation& where);

/// Throws SceneError if a value is not legal for the role.
void check_role(const SpectrumDescription& spectrum, SpectrumRole role, const SourceLocation& where,
                std::string_view what);

}  // namespace sheaf
