// Parses spectra in the syntax of scene files and of .spd files.
#pragma once

#include "scene/description/spectrum_check.h"

#include <string_view>

namespace sheaf {

/// Parses one number, three numbers of a color, or "wavelength:value" pairs, separated by commas or white space.
/// Throws SceneError; see check_table().
SpectrumDescription parse_spectrum_text(std::string_view text, const SourceLocation& where);

/// Reads a file of lines "wavelength value", with comments after #. Throws SceneError with the line in that file.
SpectrumDescription::Table read_spd(const std::filesystem::path& file);

/// Parses three numbers in [0, 1] or "#rrggbb" in sRGB encoding, and decodes them. One number is used for all three.
Vec3f parse_srgb(std::string_view text, const SourceLocation& where);
/// Parses three linear numbers or "#rrggbb"; the latter is sRGB-encoded.
Vec3f parse_rgb(std::string_view text, const SourceLocation& where);

}  // namespace sheaf
