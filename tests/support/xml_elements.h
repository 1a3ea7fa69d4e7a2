// Elements of scene files as text.
#pragma once

#include <string>

namespace sheaf::test {

inline std::string bsdf(const std::string& type, const std::string& inside = "") {
  return "<bsdf type='" + type + "'>" + inside + "</bsdf>";
}

/// A property of type float.
inline std::string number(const std::string& name, const std::string& value) {
  return "<float name='" + name + "' value='" + value + "'/>";
}

inline std::string integer(const std::string& name, const std::string& value) {
  return "<integer name='" + name + "' value='" + value + "'/>";
}

/// A property of type string.
inline std::string word(const std::string& name, const std::string& value) {
  return "<string name='" + name + "' value='" + value + "'/>";
}

/// A property of type boolean that is true.
inline std::string flag(const std::string& name) { return "<boolean name='" + name + "' value='true'/>"; }

}  // namespace sheaf::test
