// Typed access to the named values of one object of a scene file: the properties of an XML element, or the parameters
// of a pbrt directive. It records the names that the code queries. So the code itself is the list of known names, and
// unused values can be reported.
#pragma once

#include "core/io/name_table.h"
#include "core/math/vec3d.h"
#include "scene/description/error_sink.h"
#include "scene/description/inputs.h"
#include "scene/xml/query_recorder.h"

#include <filesystem>
#include <initializer_list>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace sheaf {

/// Formats a number without trailing zeros for messages.
std::string number_text(double number);

/// One named value. The syntax of a dialect derives from it.
struct NamedValue {
  std::string name;      ///< as in the file
  bool used = false;     ///< whether the reader has taken the value
  bool dropped = false;  ///< whether an error has been reported at the value, which then counts as absent
};

/// The named values of an object. Values of the wrong type or out of their range are reported to errors() and count as
/// absent.
class NamedValues {
 public:
  NamedValues() = default;
  virtual ~NamedValues() = default;
  NamedValues(const NamedValues&) = delete;
  NamedValues& operator=(const NamedValues&) = delete;

  /// The object in messages: "shape 'sphere'".
  virtual std::string title() const = 0;
  /// A value in messages: "property 'radius' of shape 'sphere'".
  std::string subject(const NamedValue& value) const;

  /// Whether the value exists. Marks its name as known, but not the value as used.
  bool has(const char* name);
  std::optional<float> find_number(const char* name, NumberRange range = kAnyNumber);
  float number(const char* name, float default_value, NumberRange range = kAnyNumber);
  /// Also accepts a floating-point number of integral value.
  int integer(const char* name, int default_value, int low, int high);
  bool boolean(const char* name, bool default_value);
  std::optional<std::string> find_string(const char* name);
  std::string string(const char* name, const std::string& default_value);
  /// Throws SceneError if the string is missing.
  std::string required_string(const char* name);
  std::optional<Vec3f> find_vec3(const char* name);
  Vec3f vec3(const char* name, Vec3f default_value);
  /// A position, in double precision.
  std::optional<Vec3d> find_point(const char* name);
  Vec3d point(const char* name, Vec3d default_value);
  /// The value that a string names in a table. Reports a name that is not in the table.
  template <class Value> Value choice(const char* name, const NameTable<Value>& table, Value default_value) {
    if (QueryRecorder::active() != nullptr) record(name, "string", std::string(table.name_of(default_value)));
    const std::optional<std::string> text = find_string(name);
    if (!text) return default_value;
    if (const Value* found = table.find(*text)) return *found;
    report_at(name, choice_message(*text, table.names()), SceneErrorCode::kUnknownName);
    return default_value;
  }
  /// The file named by a string, resolved to a regular file. Throws SceneError if the file or the string is missing.
  std::filesystem::path file(const char* name);

  /// Accepts any value of documented names that have no effect.
  void ignore(std::initializer_list<const char*> names);

  /// Throws SceneError at the object; the message starts with its title.
  [[noreturn]] void fail(const std::string& message, SceneErrorCode code = SceneErrorCode::kInvalid) const;
  /// Throws SceneError at the value, or at the object if the value is absent.
  [[noreturn]] void fail_at(const char* name, const std::string& message,
                            SceneErrorCode code = SceneErrorCode::kInvalid);
  /// Throws SceneError: the text of a string is not one of `known`.
  [[noreturn]] void fail_choice(const char* name, std::string_view text, const std::vector<std::string>& known);
  /// Reports an error at the value, which then counts as absent. Throws the error if the value is absent already.
  void report_at(const char* name, const std::string& message, SceneErrorCode code = SceneErrorCode::kInvalid);
  /// Reports that a value is set together with an alternative; see report_at(). `others`: "'from' and 'to'".
  void report_conflict(const char* name, const std::string& others) {
    report_at(name, fmt::format("is set together with {}, expected one of them", others), SceneErrorCode::kDuplicate);
  }
  /// Calls read(), which takes the value. Reports its error at the value, which then counts as absent; returns nothing.
  template <class Read> auto attempt(const char* name, Read&& read) -> std::optional<decltype(read())> {
    NamedValue* value = find_value(name);
    return value != nullptr ? attempt(*value, read) : std::optional<decltype(read())>(read());
  }

 protected:
  /// A number and its text for messages.
  struct Number {
    double value;
    std::string text;
  };

  /// Returns the value of this name, or null if it is absent or dropped.
  virtual NamedValue* find_value(const char* name) = 0;
  /// The term for a value in messages: "property" or "parameter".
  virtual const char* value_kind() const = 0;
  /// Returns the form of a name by which names are compared.
  virtual std::string key_of(std::string_view name) const { return std::string(name); }
  virtual Number read_number(const NamedValue& value) const = 0;
  virtual Number read_integer(const NamedValue& value) const = 0;
  virtual bool read_boolean(const NamedValue& value) const = 0;
  virtual std::string read_string(const NamedValue& value) const = 0;
  virtual Vec3d read_vec3(const NamedValue& value) const = 0;
  /// Returns the regular file of this name. Throws SceneError if it does not exist.
  virtual std::filesystem::path find_file(const std::string& file, const NamedValue& value) const = 0;
  /// The location of the value, or of the object if it is null.
  virtual const SourceLocation& position_of(const NamedValue* value) const = 0;
  virtual ErrorSink& errors() const = 0;

  /// An error at the value, or at the object if it is null.
  SceneError make_error(const NamedValue* value, const std::string& message, SceneErrorCode code) const;
  /// Throws make_error().
  [[noreturn]] void raise(const NamedValue* value, const std::string& message,
                          SceneErrorCode code = SceneErrorCode::kInvalid) const {
    throw make_error(value, message, code);
  }
  /// Reports an error of a value, which then counts as absent.
  void drop(NamedValue& value, const SceneError& error) const;
  /// Calls read() for a value; after an error, drops the value and returns nothing.
  template <class Read> auto attempt(NamedValue& value, Read&& read) const -> std::optional<decltype(read())> {
    try {
      return read();
    } catch (const SceneError& error) {
      drop(value, error);
      return std::nullopt;
    }
  }

  /// Returns the value of this name and marks it as used; null if absent. Marks the name as known.
  NamedValue* use(const char* name);
  /// Throws SceneError at the value; the message starts with its subject().
  [[noreturn]] void fail_value(const NamedValue& value, const std::string& message,
                               SceneErrorCode code = SceneErrorCode::kInvalid) const;
  /// Throws SceneError at the value unless the number is in the range.
  void check_range(const NamedValue& value, const Number& number, NumberRange range) const;
  /// Adds a query to the active recorder.
  void record(const char* name, const char* type, std::string default_value) const;
  /// Records a query with a default value, if there is a recorder.
  template <class Value> void note_query(const char* name, const char* type, const Value& default_value) const {
    if (QueryRecorder::active() != nullptr) record(name, type, default_text(default_value));
  }
  /// Records a query without a default value, if there is a recorder.
  void note_query(const char* name, const char* type) const {
    if (QueryRecorder::active() != nullptr) record(name, type, {});
  }
  /// Reports a value that is not used, so its name is unknown.
  void reject(NamedValue& value) const;

 private:
  static std::string choice_message(std::string_view text, const std::vector<std::string>& known);

  std::vector<std::string> queried_;  ///< queried names, as spelled in the code
};

}  // namespace sheaf
