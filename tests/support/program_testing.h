// Runs the command-line program in a shell, as a user does.
#pragma once

#include "tests/support/contains.h"
#include "tests/support/temporary_folder.h"

#include <sys/wait.h>

#include <cstdlib>

namespace sheaf {

/// Result of a run: exit code, or -1 if a signal ended it, and the contents of both output streams.
struct Outcome {
  int code = -1;
  std::string out, err;
};

/// Runs the program in `folder` with `arguments` (shell words), after the shell commands in `before`.
inline Outcome run(const TemporaryFolder& folder, const std::string& arguments, const std::string& before = "") {
  const std::string streams = " >'" + (folder / "out.txt").string() + "' 2>'" + (folder / "err.txt").string() + "'";
  const std::string command = "cd '" + folder.path().string() + "' && " + before + "'" SHEAF_EXECUTABLE "' " +
                              arguments + streams + " </dev/null";
  const int status = std::system(command.c_str());
  Outcome outcome;
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  outcome.out = read_bytes(folder / "out.txt");
  outcome.err = read_bytes(folder / "err.txt");
  std::filesystem::remove(folder / "out.txt");
  std::filesystem::remove(folder / "err.txt");
  return outcome;
}

using test::contains;

}  // namespace sheaf
