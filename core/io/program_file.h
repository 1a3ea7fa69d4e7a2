// The file that contains Sheaf's code, next to which its plugins and helper programs lie.
#pragma once

#include <filesystem>

namespace sheaf {

/// The absolute path of the running program, or of the shared library that contains this code, such as the Python
/// module. Empty if it cannot be determined.
std::filesystem::path program_file();

}  // namespace sheaf
