// The options -q and -v, which select the messages of a command.
#pragma once

#include "tools/console/messages.h"
#include "tools/options/options.h"

#include <string>

namespace sheaf {

/// Command-line options for the verbosity.
struct VerbosityArguments {
  int quiet = 0;  ///< number of -q
  bool verbose = false;

  Verbosity verbosity() const;
};

/// Adds -q and, if there is a text about the details that it adds, -v.
void add_verbosity_options(Command& command, VerbosityArguments& arguments, const std::string& details = "");

}  // namespace sheaf
