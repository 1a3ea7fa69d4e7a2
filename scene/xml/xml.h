// The XML tree of a scene file, with the line of every element. All XML parsing goes through this file.
#pragma once

#include "scene/description/error_sink.h"
#include "scene/xml/array_value.h"

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

struct XmlAttribute {
  std::string name, value;
  /// Position of a value that contains "$(" and lies on one line: line and column of its first character, from 1. Else
  /// 0.
  int line = 0, column = 0;
};

/// One element, without comments, processing instructions and white space. Other text inside elements is an error.
struct XmlElement {
  std::string name;
  std::vector<XmlAttribute> attributes;  ///< in file order, names unique
  std::vector<XmlElement> children;      ///< in file order
  SourceLocation where;
  std::shared_ptr<const ArrayValue> array = {};  ///< the value of an <array>, which no file contains; else null

  /// The value of an attribute, or null.
  const std::string* find_attribute(std::string_view attribute_name) const;
  /// The value of an attribute. Throws SceneError if it is missing.
  const std::string& attribute(std::string_view attribute_name) const;
  /// Throws SceneError for the first attribute that is not in the list.
  void expect_attributes(std::initializer_list<const char*> allowed) const;
};

/// Reads a file into a tree of at most 100 levels. Entities of a DTD are not expanded. Throws SceneError if the file
/// cannot be read, is not well-formed UTF-8 XML, or does not have exactly one root element. Reports text inside
/// elements, which is ignored, and duplicate attributes, of which the last is used.
XmlElement read_xml(const std::filesystem::path& file, ErrorSink& errors);

}  // namespace sheaf
