// A record of the names that readers query, with types and default values. Tests compare it with the documentation.
#pragma once

#include "scene/description/inputs.h"

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// One query of a named value or nested object.
struct ValueQuery {
  std::string object;         ///< NamedValues::title() of the object
  std::string name;           ///< as spelled in the code
  std::string type;           ///< such as "float"; "ignored" for names without effect; empty if only looked for
  std::string default_value;  ///< text of the value that replaces an absent one; empty if it is not a single value
};

/// Records all queries of named values while it exists. At most one recorder exists at a time, in programs that read
/// scenes with one thread.
class QueryRecorder {
 public:
  QueryRecorder();
  ~QueryRecorder();
  QueryRecorder(const QueryRecorder&) = delete;
  QueryRecorder& operator=(const QueryRecorder&) = delete;

  /// The existing recorder, or null.
  static QueryRecorder* active() { return current; }

  std::vector<ValueQuery> queries;
  std::set<std::string> finished;                        ///< titles of objects that were read without error
  std::map<std::string, std::set<std::string>> plugins;  ///< known names by element, from errors about unknown ones

 private:
  static QueryRecorder* current;
};

/// Texts of default values in ValueQuery: numbers without trailing zeros, "true", "(1, 2, 3)", plain
/// strings; empty for tables and textures.
std::string default_text(bool value);
std::string default_text(float value);
std::string default_text(int value);
std::string default_text(Vec2f value);
std::string default_text(Vec3f value);
std::string default_text(const std::string& value);
std::string default_text(const SpectrumDescription& value);
std::string default_text(const SpectrumInput& value);
std::string default_text(const ScalarInput& value);

}  // namespace sheaf
