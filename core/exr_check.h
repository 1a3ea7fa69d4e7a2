// The sizes that headers of OpenEXR files claim.
#pragma once

#include <filesystem>

namespace sheaf {

/// Throws SceneError unless each attribute of the file's headers has the size of its type, and lies in the file. The
/// library takes memory for what an attribute claims, up to 2 GB, before it reads what is not there. Of headers that
/// end too early it tells itself.
void check_exr_headers(const std::filesystem::path& file);

}  // namespace sheaf
