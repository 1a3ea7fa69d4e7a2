// The words of pbrt scene files.
#pragma once

#include "core/error.h"

#include <string>
#include <string_view>

namespace sheaf::pbrt {

/// A piece of a scene file.
struct Token {
  enum class Kind {
    kEnd,     ///< of the file
    kWord,    ///< a directive, a number, true or false
    kString,  ///< what stands between double quotes, escapes resolved
    kOpen,    ///< [
    kClose    ///< ]
  } kind = Kind::kEnd;
  std::string_view text;  ///< valid until the next token
  int line = 1;           ///< on which it begins
};

/// A text cut into tokens, one at a time. Comments go from # to the end of the line.
class Tokens {
 public:
  /// `file` is for messages. Throws SceneError as advance() does.
  Tokens(std::string text, std::string file);

  const Token& current() const { return token_; }
  SourceLocation where() const { return {file_, token_.line}; }
  /// Goes on to the next token. Throws SceneError for a string that does not end on its line, and unknown escapes.
  void advance();

 private:
  void skip_space();
  void read_string();

  std::string text_, file_, string_;
  std::size_t at_ = 0;
  int line_ = 1;
  Token token_;
};

/// The token as messages show it: in quotes, its beginning if it is long.
std::string shown(const Token& token);

/// The number that a word is. Throws SceneError, naming what is `expected`, if it is none, not finite or no word.
double number_of(const Token& token, const SourceLocation& where, std::string_view expected);

}  // namespace sheaf::pbrt
