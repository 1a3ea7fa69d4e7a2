// Named values of -D and <default>, and their substitution in the text of scene files.
#pragma once

#include "core/io/error.h"

#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sheaf {

/// Whether a text is a name that `$` can refer to: letters, digits and _.
bool is_definition_name(std::string_view name);

/// The location of a text in a file.
struct TextLocation {
  SourceLocation where;
  int column = 0;  ///< of the first character, from 1; 0: unknown
};

/// Defined names with their values, and which of them the scene uses.
class Definitions {
 public:
  /// Receives an error that leaves a part of the text empty. May throw it.
  using OnError = std::function<void(const SceneError& error)>;

  /// `defines`: names and values of -D. The last value of a name counts.
  explicit Definitions(const std::vector<std::pair<std::string, std::string>>& defines = {});

  /// Defines a name unless -D or an earlier <default> did. Either way the name is used.
  void add_default(const std::string& name, const std::string& value);

  /// Replaces every `$(expression)` (scene/xml/expression.h) and `$name`, where the longest defined name counts. As in
  /// names of outputs, `$frame4` is the number `frame` with at least 4 digits (1 to 9), unless `frame4` is defined.
  /// Passes undefined names and errors of expressions to `on_error`. Throws SceneError if all substitutions together
  /// exceed 256 MiB.
  std::string substitute(std::string_view text, const TextLocation& location, const OnError& on_error);
  /// The same, but leaves undefined names after `$` as they are.
  std::string substitute_defined(std::string_view text, const TextLocation& location, const OnError& on_error);

  /// Throws SceneError at `file` for the first define that was never used.
  void reject_unused(const std::string& file) const;

 private:
  using Entry = std::pair<const std::string, std::string>;

  std::string replace(std::string_view text, const TextLocation& location, bool keep_undefined,
                      const OnError& on_error);
  /// The value of the expression in parentheses at `open`; empty after an error. `end`: after the parentheses.
  std::string evaluate(std::string_view text, std::size_t open, std::size_t& end, const TextLocation& location,
                       const OnError& on_error);
  /// The entry with the longest name that is a prefix of `text`, or null.
  const Entry* longest_prefix(std::string_view text) const;
  SceneError undefined(const std::string& name, const SourceLocation& where) const;

  std::vector<std::string> defined_;  ///< names of -D, in order
  std::map<std::string, std::string, std::less<>> values_;
  std::set<std::string, std::less<>> used_;
  std::size_t substituted_ = 0;  ///< bytes
};

}  // namespace sheaf
