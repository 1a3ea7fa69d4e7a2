// Error messages for missing files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sheaf {

/// The message for a file `name` that was not found in `folders`. A text file next to a folder of the path, with the
/// folder's name plus ".txt", may explain how to obtain the folder's files. Its first line is appended to the message.
/// For example, "generated.txt" explains how to make "generated/knot.ply".
std::string missing_file(const std::string& name, const std::vector<std::filesystem::path>& folders);

}  // namespace sheaf
