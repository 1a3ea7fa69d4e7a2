// Names of pictures on the command line: which formats there are, and what may not be overwritten.
#pragma once

#include <filesystem>

namespace sheaf {

/// The extension in lower case, with its dot.
std::string extension_of(const std::filesystem::path& path);

/// Throws Error (exit code 2) unless the name ends in .exr or .png.
void check_picture_name(const std::filesystem::path& path);

}  // namespace sheaf
