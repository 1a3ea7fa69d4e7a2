// The libraries and optional parts of this build, for `sheaf --version -v`.
#pragma once

#include <string>

namespace sheaf {

/// Lines with the versions of the libraries, the image formats, and the files that are loaded or started when needed.
std::string build_details();

}  // namespace sheaf
