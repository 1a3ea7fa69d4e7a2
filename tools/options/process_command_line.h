// The command line of this process.
#pragma once

#include <string>
#include <string_view>

namespace sheaf {

/// Quotes a word so that the shell takes it literally.
std::string shell_quoted(std::string_view word);

/// The words of the command line, separated by spaces. Words that a shell would change are quoted for it. Empty if the
/// system does not provide them.
std::string command_line();

}  // namespace sheaf
