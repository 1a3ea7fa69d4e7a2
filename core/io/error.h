// Errors with a message for the user, a location in a file, and an exit code.
#pragma once

#include <fmt/format.h>  // also for files that throw: messages are formatted

#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
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

/// The name of a file, shared by all locations in it: a scene has one for each of its elements.
class FileName {
 public:
  FileName() = default;
  FileName(std::string name) : name_(name.empty() ? nullptr : std::make_shared<const std::string>(std::move(name))) {}
  FileName(const char* name) : FileName(std::string(name)) {}

  const std::string& string() const;
  bool empty() const { return name_ == nullptr; }
  bool operator==(const FileName& other) const { return name_ == other.name_ || string() == other.string(); }

 private:
  std::shared_ptr<const std::string> name_;  ///< null: empty
};

/// A location in a file. `line` counts from 1; 0 means the whole file.
struct SourceLocation {
  FileName file;
  int line = 0;

  bool operator==(const SourceLocation&) const = default;
};

/// An error with a message for the user. what() begins with "file:line: " if the location is known.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), exit_code_(code) {}
  Error(ExitCode code, const SourceLocation& where, const std::string& message);
  /// The exit code of the process for this error.
  ExitCode exit_code() const { return exit_code_; }
  /// The location; its file is empty if unknown.
  const SourceLocation& where() const { return where_; }

 protected:
  /// An error with the location of another one, and its own message.
  Error(const Error& other, const std::string& message)
      : std::runtime_error(message), exit_code_(other.exit_code_), where_(other.where_) {}

 private:
  ExitCode exit_code_;
  SourceLocation where_;
};

/// What is wrong with a scene or an asset.
enum class SceneErrorCode {
  kInvalid,      ///< malformed content, or values that contradict each other
  kSyntax,       ///< text that the syntax of the file does not allow
  kUnknownName,  ///< of an element, plugin, property, object or choice
  kWrongType,    ///< a value of another type than expected
  kOutOfRange,   ///< a value outside of its range
  kMissing,      ///< a required element, property or attribute is absent
  kDuplicate,    ///< set or defined twice, or together with an alternative
  kMissingFile,  ///< a file that does not exist or is not a regular file
  kUnsupported,  ///< a feature that Sheaf does not have
  kTooLarge,     ///< more than Sheaf accepts
};

/// An error in a scene file or in one of its assets (exit code 3).
class SceneError : public Error {
 public:
  using Code = SceneErrorCode;

  explicit SceneError(const std::string& message, Code code = Code::kInvalid)
      : Error(ExitCode::kScene, message), code_(code) {}
  SceneError(const SourceLocation& where, const std::string& message, Code code = Code::kInvalid)
      : Error(ExitCode::kScene, where, message), code_(code) {}
  /// The error `cause` as one at `where`: the message begins with both locations.
  SceneError(const SourceLocation& where, const SceneError& cause)
      : Error(ExitCode::kScene, where, cause.what()), element_(cause.element_), code_(cause.code_) {}

  /// The object, property or parameter that is wrong, as in messages: "property 'radius' of shape 'sphere'". Empty if
  /// unknown.
  const std::string& element() const { return element_; }
  Code code() const { return code_; }

  /// The same error with an element, unless it has one.
  SceneError about(const std::string& element) const;

 protected:
  /// An error like `other` with another message.
  SceneError(const SceneError& other, const std::string& message)
      : Error(other, message), element_(other.element_), code_(other.code_) {}

 private:
  std::string element_;
  Code code_;
};

/// The error as one at `where`, unless that is its location.
SceneError at_location(const SourceLocation& where, const SceneError& error);

/// The candidate most similar to `name` by edit distance, or else the first that begins with it. Returns an empty
/// string if no candidate is similar.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);

/// `text` in single quotes for a message: shortened if long, with control characters replaced.
std::string in_quotes(std::string_view text);

/// ", did you mean 'x'?" for the nearest candidate, or an empty string.
std::string did_you_mean(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace sheaf
