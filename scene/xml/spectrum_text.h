// Spectra as scene files and .spd files write them.
#pragma once

#include "scene/description/spectrum_check.h"

#include <string_view>

namespace sheaf {

/// One number, or "wavelength:value" pairs separated by commas or white space. Throws SceneError: see check_table.
SpectrumDescription parse_spectrum_text(std::string_view text, const SourceLocation& where);

/// A file of lines "wavelength value"; # begins a comment. Throws SceneError with the line in that file.
SpectrumDescription::Table read_spd(const std::filesystem::path& file);

/// Three numbers in [0, 1] or "#rrggbb" in the sRGB encoding, to linear. One number stands for all three.
Vec3f parse_srgb(std::string_view text, const SourceLocation& where);
/// Three linear numbers or "#rrggbb"; the latter is in the sRGB encoding.
Vec3f parse_rgb(std::string_view text, const SourceLocation& where);

}  // namespace sheaf
