// A COLLADA document (1.4.1) whose elements are found by their ids.
#pragma once

#include "tools/importer/parts.h"

#include <pugixml.hpp>

#include <string>
#include <unordered_map>
#include <vector>

namespace sheaf::importer {

struct ColladaDocument {
  pugi::xml_document xml = {};
  std::unordered_map<std::string, pugi::xml_node> by_id = {};
  std::vector<pugi::xml_node> nodes = {};  ///< all <node> elements, in the order of the file; each has an id

  /// Returns the element that an attribute with a URL refers to (#id), or a null node.
  pugi::xml_node target(const pugi::xml_attribute& url) const;

  /// Returns an id that no element has, and reserves it. It begins with `stem`.
  std::string unique_id(const std::string& stem);
};

/// The numbers in the text of an element, up to the first other word.
std::vector<double> numbers_of(const pugi::xml_node& element);

/// A source of numbers or names, by its accessor.
struct ColladaSource {
  std::vector<double> numbers;
  std::vector<std::string> names;
  std::size_t count = 0, stride = 1, offset = 0;

  /// Number k of element i; 0 if it does not exist.
  double number(std::size_t i, std::size_t k) const;
};

/// Reads a <source>, which may be a null node.
ColladaSource read_source(const ColladaDocument& document, const pugi::xml_node& source);

/// Moves the cameras and lights of all nodes to `out`.
void take_optics(ColladaDocument& document, FileParts& out);

/// Moves the animations of transforms to `out`, and divides their nodes such that each animated element has its own.
void take_animations(ColladaDocument& document, FileParts& out);

/// Joins the holes of polygons to their outlines, by two coinciding edges each. Adds a note about holes that are left
/// out.
void join_holes(ColladaDocument& document, FileParts& out);

}  // namespace sheaf::importer
