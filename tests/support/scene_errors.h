// Checks of tables of malformed scenes and their error messages.
#pragma once

#include "tests/support/files/scene_files.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

namespace sheaf::test {

/// A malformed scene, or a part of one, and a part of its error message.
struct ErrorCase {
  std::string text;
  const char* expected;
};

/// Checks that every message names the scene file and contains the expected part. `error` reads a text and returns the
/// message, as error_of_text().
template <class Error> void check_errors(const std::vector<ErrorCase>& cases, Error error) {
  for (const ErrorCase& c : cases) {
    CAPTURE(c.text);
    const std::string message = error(c.text);
    CHECK_MESSAGE(contains(message, c.expected), message);
    CHECK(message.starts_with("scene.xml:"));
  }
}
inline void check_errors(const std::vector<ErrorCase>& cases) {
  check_errors(cases, [](const std::string& text) { return error_of_text(text); });
}

}  // namespace sheaf::test
