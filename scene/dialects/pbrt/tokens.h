// Tokens of pbrt scene files.
#pragma once

#include "core/error.h"

#include <string>
#include <string_view>

namespace sheaf::pbrt {

/// A token of a scene file.
struct Token {
  enum class Kind {
    kEnd,     ///< end of file
    kWord,    ///< directive, number, true or false
    kString,  ///< text between double quotes, with escapes resolved
    kOpen,    ///< [
    kClose    ///< ]
  } kind = Kind::kEnd;
  std::string_view text;  ///< valid until the next token
  int line = 1;           ///< where it begins
};

/// Splits a text into tokens, one at a time. Comments start at # and end with the line.
class Tokens {
 public:
  /// `file` is used in messages. Throws SceneError as advance() does.
  Tokens(std::string text, std::string file);

  const Token& current() const { return token_; }
  SourceLocation where() const { return {file_, token_.line}; }
  /// Advances to the next token. Throws SceneError for a string that does not end on its line, and for unknown escapes.
  void advance();

 private:
  void skip_space();
  void read_string();

  std::string text_, file_, string_;
  std::size_t at_ = 0;
  int line_ = 1;
  Token token_;
};

/// Returns the token for messages: quoted, and truncated if long.
std::string shown(const Token& token);

/// Parses a word as a number. Throws SceneError, naming what was `expected`, if it is not a word or not a finite
/// number.
double number_of(const Token& token, const SourceLocation& where, std::string_view expected);

}  // namespace sheaf::pbrt
