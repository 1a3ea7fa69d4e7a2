// Errors with a message for the user, a location in a file, and an exit code.
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

/// A location in a file. `line` counts from 1; 0 stands for the whole file.
struct SourceLocation {
  std::string file;
  int line = 0;
};

/// An error with a message for the user. what() begins with "file:line: " if the location is known.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  Error(ExitCode code, const SourceLocation& where, const std::string& message);
  /// The exit code of the process for this error.
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

/// An error in a scene file or in one of its assets (exit code 3).
class SceneError : public Error {
 public:
  explicit SceneError(const std::string& message) : Error(ExitCode::kScene, message) {}
  SceneError(const SourceLocation& where, const std::string& message) : Error(ExitCode::kScene, where, message) {}
};

/// Prefixes the message of an error with a location, unless it already begins with that location.
SceneError at_place(const SourceLocation& where, const SceneError& error);

/// The candidate most similar to `name` by edit distance, or else the first that begins with it. Returns an empty
/// string if no candidate is similar.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);

/// `text` in single quotes for a message: shortened if long, with control characters replaced.
std::string in_quotes(std::string_view text);

/// ", did you mean 'x'?" for the nearest candidate, or an empty string.
std::string did_you_mean(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace sheaf
