// The errors of a scene whose broken elements can be replaced.
#pragma once

#include "core/io/error.h"

#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

namespace sheaf {

/// Errors of one scene that lenient reading accepts. what() has a line for each; place and code are those of the first.
class SceneErrors : public SceneError {
 public:
  /// `all`: at least one.
  explicit SceneErrors(std::vector<SceneError> all);

  const std::vector<SceneError>& all() const { return all_; }

 private:
  std::vector<SceneError> all_;
};

/// Receives errors from readers, which replace or drop the broken element and continue. In strict mode, the errors are
/// thrown in the end; in lenient mode, they become warnings. Reports each message once.
class ErrorSink {
 public:
  /// Errors after which strict reading ends.
  static constexpr std::size_t kMaxErrors = 20;

  /// `substitutions`: receives a message for each error in lenient mode, unless it already has it. Must outlive the
  /// sink.
  ErrorSink(bool lenient, std::vector<std::string>& substitutions);
  ErrorSink(const ErrorSink&) = delete;
  ErrorSink& operator=(const ErrorSink&) = delete;

  bool is_lenient() const { return lenient_; }
  /// Reports an error. `substitute`: what the reader does about it, such as "ignored". Throws SceneErrors in strict
  /// mode once there are kMaxErrors; handlers of SceneError may report those too.
  void report(const SceneError& error, std::string_view substitute);
  /// The errors so far, in order.
  const std::vector<SceneError>& errors() const { return errors_; }

  /// Calls read(). In strict mode, throws the errors that it reports, together with an error that ends it.
  template <class Read> void run(Read&& read) {
    try {
      read();
    } catch (const SceneErrors&) { throw; } catch (const SceneError& error) {
      if (lenient_ || errors_.empty()) throw;
      report(error, "");
    }
    throw_errors();
  }
  /// Throws SceneErrors in strict mode if errors have been reported.
  void throw_errors() const;

 private:
  void throw_if_full() const;

  bool lenient_;
  std::vector<std::string>& substitutions_;
  std::vector<SceneError> errors_;
  std::unordered_set<std::string> reported_;  ///< messages
};

/// Reports an error; throws it if `errors` is null.
inline void report_to(ErrorSink* errors, const SceneError& error, std::string_view substitute) {
  if (errors == nullptr) throw error;
  errors->report(error, substitute);
}

}  // namespace sheaf
