// Validation of attribute sizes in the headers of OpenEXR files.
#pragma once

#include <filesystem>

namespace sheaf {

/// Throws SceneError unless each attribute in the headers has the size of its type and lies within the file. The
/// library would allocate the size that an attribute claims, up to 2 GB, before it reads the value. Truncated headers
/// are accepted here, because the library reports them itself.
void check_exr_headers(const std::filesystem::path& file);

}  // namespace sheaf
