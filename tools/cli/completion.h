// Completion of command lines for shells, derived from the declared commands and options.
#pragma once

#include "tools/options/help.h"

#include <string>

namespace sheaf {

/// A script for bash: completes commands, options, words, and names of files.
std::string bash_completion(const CommandHelp& program);
/// A script for zsh, to be stored as _sheaf in a folder of $fpath. Also describes each option.
std::string zsh_completion(const CommandHelp& program);
/// A script for fish. Also describes each option.
std::string fish_completion(const CommandHelp& program);

}  // namespace sheaf
