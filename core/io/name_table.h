// Tables that map names in files and options to values: enumerators, settings, readers of plugins.
#pragma once

#include "core/io/error.h"

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// Joins names as "a, b, c".
std::string joined(const std::vector<std::string>& names);

/// Formats a list of names for messages: " (known: a, b, c)".
std::string known_names(const std::vector<std::string>& names);

/// Formats a list of choices for messages: "a, b or c".
std::string one_of(const std::vector<std::string>& names);

/// Message for an unknown name: "unknown WHAT 'NAME'", the nearest name and all known names.
std::string unknown_option(std::string_view what, std::string_view name, const std::vector<std::string>& known);

/// A table of names and their values. Define it `constexpr` in a namespace or `static constexpr` in a function, because
/// the rows live as long as that variable:
///   constexpr NameTable<Wrap> kWraps{{{"repeat", Wrap::kRepeat}, {"clamp", Wrap::kClamp}}};
template <class Value> struct NameTable {
  struct Row {
    const char* name;
    Value value;
  };
  std::initializer_list<Row> rows;

  /// Returns the value of a name, or null.
  constexpr const Value* find(std::string_view name) const {
    for (const Row& row : rows)
      if (name == row.name) return &row.value;
    return nullptr;
  }

  /// Returns the first name of a value: its own name, while the others are synonyms or substitutes. Empty if it has
  /// none.
  constexpr const char* name_of(const Value& value) const {
    for (const Row& row : rows)
      if (value == row.value) return row.name;
    return "";
  }

  /// Returns all names in the order of the table.
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const Row& row : rows) names.emplace_back(row.name);
    return names;
  }

  /// Returns the value of a name that the user gave as an option. Throws Error (usage) for an unknown name; the message
  /// says `what` it should name, and lists the nearest name and all names.
  const Value& option(const char* what, std::string_view name) const {
    if (const Value* value = find(name)) return *value;
    throw Error(ExitCode::kUsage, unknown_option(what, name, names()));
  }
};

}  // namespace sheaf
