// Where the shared library of Open Image Denoise may be.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace sheaf {

/// The value of an environment variable; empty if it is not set.
using Environment = std::function<std::string(const char* name)>;

/// Folders that come before those of the dynamic linker, and behind them. Those that are not there are left out.
struct OidnFolders {
  std::vector<std::filesystem::path> before, behind;
};

/// Before: those beside the program at `program`. Behind: those of the packages of Python that bring the library (oidn,
/// pyoidn, bpy), in the environment that is active (VIRTUAL_ENV, CONDA_PREFIX), the user's (HOME) and the system's; and
/// that of the program `blender`, if PATH has it.
OidnFolders oidn_folders(const std::filesystem::path& program, const Environment& environment);

/// The files in a folder that are the library by their names, libOpenImageDenoise.so with or without a version: those
/// of the highest version first.
std::vector<std::filesystem::path> oidn_files(const std::filesystem::path& folder);

/// What the dynamic linker is asked for, in order.
std::vector<std::string> oidn_names();

}  // namespace sheaf
