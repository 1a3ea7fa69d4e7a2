// Parameters of pbrt scene files, "type name" value, and typed access to them. It records which names the code asks
// for, so that whatever is left over can be reported.
#pragma once

#include "core/vec.h"
#include "scene/dialects/pbrt_tokens.h"
#include "scene/xml/properties.h"

#include <optional>
#include <vector>

namespace sheaf::pbrt {

struct Reader;

/// One parameter as the file has it.
struct Parameter {
  std::string type, name;
  SourceLocation where;
  std::vector<double> numbers;       ///< also truth values, as 0 and 1
  std::vector<std::string> strings;  ///< also names of textures
  bool optional = false;             ///< a default for whatever wants it: nobody need ask for it
  bool used = false;
};

/// Reads parameters up to the next directive. Throws SceneError for unknown types, values of another type and
/// parameters given twice.
std::vector<Parameter> read_parameters(Tokens& tokens);

/// The parameters of one object. All functions throw SceneError for values of the wrong type, in the wrong number or
/// out of range.
class Parameters {
 public:
  /// `title` names the object in messages: "Shape 'sphere'". Of parameters of one name the first counts.
  Parameters(Reader& reader, std::string title, SourceLocation where, std::vector<Parameter> list);

  Reader& reader() const { return reader_; }
  const SourceLocation& where() const { return where_; }
  const std::string& title() const { return title_; }

  /// The parameter of this name, which counts as used, or null.
  const Parameter* find(const char* name);
  bool has(const char* name);
  std::optional<float> find_number(const char* name, NumberRange range = kAnyNumber);
  float number(const char* name, float default_value, NumberRange range = kAnyNumber);
  /// Also a float of integral value.
  int integer(const char* name, int default_value, int low, int high);
  bool boolean(const char* name, bool default_value);
  std::optional<std::string> find_string(const char* name);
  std::string string(const char* name, const std::string& default_value);
  Vec3f vec3(const char* name, Vec3f default_value);
  /// All numbers of a parameter, a multiple of `stride` of them; empty if it is absent.
  std::vector<float> numbers(const char* name, std::size_t stride);
  /// The file that a string names, found and regular. Throws SceneError if it or the parameter is missing.
  std::filesystem::path file(const char* name);

  /// Parameters that mean nothing here: any value is accepted.
  void ignore(std::initializer_list<const char*> names);
  /// Throws SceneError for what nobody asked for; notes it instead if the reader is lenient.
  void reject_unused();

  /// Throws SceneError at the object.
  [[noreturn]] void fail(const std::string& message) const;
  /// Throws SceneError at the parameter, or at the object if it is absent.
  [[noreturn]] void fail_at(const char* name, const std::string& message) const;
  /// Throws SceneError that `what` is not supported; if the reader is lenient, notes it and what is done instead.
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
