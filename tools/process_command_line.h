// The command line of this process.
#pragma once

#include <string>

namespace sheaf {

/// The words of the command line, separated by spaces. Words that a shell would change are quoted for it. Empty if the
/// system does not provide them.
std::string command_line();

}  // namespace sheaf
