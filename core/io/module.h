// Shared libraries of Sheaf that are loaded when they are needed.
#pragma once

#include <filesystem>
#include <string>

namespace sheaf {

/// A file that is shipped with the program: next to it or, if it is not there, in ../lib/sheaf. Empty if it is missing.
std::filesystem::path shipped_file(const std::string& name);

/// Loads a library for the life of the process, and returns the function that it exports. Throws Error (exit code 1) if
/// it is missing or cannot be loaded; the message begins with `failure`, for example "cannot read TIFF files".
void* load_module(const std::string& name, const char* function, const std::string& failure);

}  // namespace sheaf
