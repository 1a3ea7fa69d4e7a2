// Validation of spectra by their use.
#pragma once

#include "core/io/error.h"
#include "scene/description/inputs.h"

#include <string_view>

namespace sheaf {

/// Throws SceneError unless the table has at least two entries and as many values as wavelengths, and its wavelengths
/// are positive and strictly increasing.
void check_table(const SpectrumDescription::Table& table, const SourceLocation& where);

/// Throws SceneError if a value is invalid for the role.
void check_role(const SpectrumDescription& spectrum, SpectrumRole role, const SourceLocation& where,
                std::string_view what);

}  // namespace sheaf
