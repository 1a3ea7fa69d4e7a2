// Errors that reach a user: what went wrong, where in which file, and the exit code it means.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// Exit codes of the command line.
enum class ExitCode : int {
  kDone = 0,
  kRuntime = 1,
  kUsage = 2,
  kScene = 3,
  kOutput = 4,
  kCheckpoint = 5,
  kInterrupted = 130,
  kTerminated = 143
};

/// A place in a file. `line` counts from 1; 0 means the file as a whole.
struct SourceLocation {
  std::string file;
  int line = 0;
};

/// An error with a message for the user. what() begins with "file:line: " where a place is known.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  Error(ExitCode code, const SourceLocation& where, const std::string& message);
  /// The process's exit code that this error calls for.
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

/// An error in a scene file or in an asset that it names (exit code 3).
class SceneError : public Error {
 public:
  explicit SceneError(const std::string& message) : Error(ExitCode::kScene, message) {}
  SceneError(const SourceLocation& where, const std::string& message) : Error(ExitCode::kScene, where, message) {}
};

/// The same error with a place before its message, unless it begins with that place.
SceneError at_place(const SourceLocation& where, const SceneError& error);

/// The candidate that is most like `name` (smallest edit distance), or an empty string if none is at all alike.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);

/// ", did you mean 'x'?" for the nearest candidate, or an empty string.
std::string did_you_mean(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace sheaf
