// What is said of files that are not there.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sheaf {

/// The message for a file that a scene names as `name` and that lies in none of `folders`. Beside a folder on the way
/// to it there may be a text file of that folder's name with ".txt": its first line says where the folder's files come
/// from, and is part of the message. So "generated.txt" may say what makes "generated/knot.ply".
std::string missing_file(const std::string& name, const std::vector<std::filesystem::path>& folders);

}  // namespace sheaf
