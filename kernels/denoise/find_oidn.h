// Search paths of the Open Image Denoise shared library.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace sheaf {

/// Returns the value of an environment variable; empty if it is not set.
using Environment = std::function<std::string(const char* name)>;

/// Folders to search before and after those of the dynamic linker. Omits folders that do not exist.
struct OidnFolders {
  std::vector<std::filesystem::path> before, behind;
};

/// Search folders for the executable `program`. Before: folders next to the executable. After: those of Python packages
/// that ship the library (oidn, pyoidn, bpy), in the active environment (VIRTUAL_ENV, CONDA_PREFIX), the user's (HOME)
/// and the system's; then the library folder of `blender`, if PATH contains it.
OidnFolders oidn_folders(const std::filesystem::path& program, const Environment& environment);

/// Library files in a folder: libOpenImageDenoise.so with or without a version suffix, by descending version.
std::vector<std::filesystem::path> oidn_files(const std::filesystem::path& folder);

/// Library names to try with the dynamic linker, in order.
std::vector<std::string> oidn_names();

}  // namespace sheaf
