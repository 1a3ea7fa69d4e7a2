#include "tools/options/verbosity_options.h"

namespace sheaf {

Verbosity VerbosityArguments::verbosity() const {
  if (quiet > 0) return quiet > 1 ? Verbosity::kErrors : Verbosity::kWarnings;
  return verbose ? Verbosity::kVerbose : Verbosity::kNormal;
}

void add_verbosity_options(Command& command, VerbosityArguments& arguments, const std::string& details) {
  if (!details.empty()) command.add_flag("-v,--verbose", arguments.verbose, details).only_for_run();
  command.add_counter("-q,--quiet", arguments.quiet, "Print only warnings and errors; twice (-qq): only errors")
      .only_for_run();
}

}  // namespace sheaf
