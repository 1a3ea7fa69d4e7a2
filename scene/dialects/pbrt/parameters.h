// Parameters of pbrt scene files ("type name" value) with typed access. Records which names are requested, so that
// unused ones can be reported.
#pragma once

#include "core/vec.h"
#include "scene/dialects/pbrt/tokens.h"
#include "scene/xml/properties.h"

#include <optional>
#include <vector>

namespace sheaf::pbrt {

struct Reader;

/// One parameter as written in the file.
struct Parameter {
  std::string type, name;
  SourceLocation where;
  std::vector<double> numbers;       ///< also booleans, as 0 and 1
  std::vector<std::string> strings;  ///< also texture names
  bool optional = false;             ///< default from the directive Attribute; may stay unused
  bool used = false;
};

/// Reads parameters up to the next directive. Throws SceneError for unknown types, values of another type and duplicate
/// parameters.
std::vector<Parameter> read_parameters(Tokens& tokens);

/// The parameters of one object. All functions throw SceneError for values of the wrong type, count or range.
class Parameters {
 public:
  /// `title` names the object in messages: "Shape 'sphere'". The first of several parameters with the same name counts.
  Parameters(Reader& reader, std::string title, SourceLocation where, std::vector<Parameter> list);

  Reader& reader() const { return reader_; }
  const SourceLocation& where() const { return where_; }
  const std::string& title() const { return title_; }

  /// Returns the parameter of this name and marks it as used; null if absent.
  const Parameter* find(const char* name);
  bool has(const char* name);
  std::optional<float> find_number(const char* name, NumberRange range = kAnyNumber);
  float number(const char* name, float default_value, NumberRange range = kAnyNumber);
  /// Also accepts a float with an integral value.
  int integer(const char* name, int default_value, int low, int high);
  bool boolean(const char* name, bool default_value);
  std::optional<std::string> find_string(const char* name);
  std::string string(const char* name, const std::string& default_value);
  Vec3f vec3(const char* name, Vec3f default_value);
  /// Returns all numbers of a parameter; their count is a multiple of `stride`. Empty if the parameter is absent.
  std::vector<float> numbers(const char* name, std::size_t stride);
  /// Returns the regular file that a string names. Throws SceneError if the file or the parameter is missing.
  std::filesystem::path file(const char* name);

  /// Accepts parameters that have no effect, with any value.
  void ignore(std::initializer_list<const char*> names);
  /// Throws SceneError for unused parameters; reports them instead if the reader is lenient.
  void reject_unused();

  /// Throws SceneError located at the object.
  [[noreturn]] void fail(const std::string& message) const;
  /// Throws SceneError located at the parameter, or at the object if the parameter is absent.
  [[noreturn]] void fail_at(const char* name, const std::string& message) const;
  /// Throws SceneError that `what` is not supported; if the reader is lenient, reports it and the replacement.
  void unsupported(const std::string& what, const std::string& instead) const;

 private:
  const Parameter* look(const char* name) const;
  const Parameter& expect(const char* name, std::initializer_list<const char*> types, std::size_t values);

  Reader& reader_;
  std::string title_;
  SourceLocation where_;
  std::vector<Parameter> list_;
  std::vector<std::string> asked_;
};

}  // namespace sheaf::pbrt
