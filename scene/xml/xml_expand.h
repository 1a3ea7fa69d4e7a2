// What the words <include>, <default>, <path>, <alias>, <ref> and $name mean: a scene file becomes one tree of plain
// objects and properties, whichever dialect they are written in.
#pragma once

#include "scene/xml/xml.h"

#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

namespace sheaf {

/// A scene file with its includes spliced in and every `$name` replaced. Pointers into `root` stay valid as long as
/// the object lives, and when it is moved.
class ExpandedScene {
 public:
  /// Reads `file`. Each define is a name and its value; it overrides the <default> of that name. Throws SceneError:
  /// XML errors, an include or path that is not found, includes nested deeper than 15 or more than 10,000 of them, an
  /// undefined `$name`, a define that the scene never reads, an id given twice. `lenient`: what can be left out is left
  /// out; see left_out().
  ExpandedScene(const std::filesystem::path& file, const std::vector<std::pair<std::string, std::string>>& defines,
                bool lenient = false);

  const XmlElement& root() const { return root_; }
  /// What was left out or replaced because it could not be read: messages with file and line.
  const std::vector<std::string>& left_out() const { return left_out_; }
  /// Gives all elements of a name another one: two names for one thing.
  void rename(std::string_view name, std::string_view other) { rename(root_, name, other); }
  /// Gives all objects of an element's name and a plugin's another plugin: two names for one thing.
  void rename_plugin(std::string_view element, std::string_view plugin, std::string_view other) {
    rename_plugin(root_, element, plugin, other);
  }
  /// The element that `<ref id="...">` at `where` means. Throws SceneError if there is none.
  const XmlElement& find(const std::string& id, const SourceLocation& where) const;
  /// Whether some <ref> means this element.
  bool is_referenced(const XmlElement& element) const { return referenced_.count(&element) != 0; }
  /// A file that an element at `where` names: absolute, or below a declared path (the last declared first), below the
  /// folder of the scene file, or below the folder of the file that names it. Throws SceneError if it is not there or
  /// not a regular file.
  std::filesystem::path find_file(const std::string& name, const SourceLocation& where) const;
  /// The scene file, its includes, and what else find_file() has found so far.
  const std::vector<std::filesystem::path>& files() const { return files_; }

 private:
  struct Expansion;
  static void rename(XmlElement& element, std::string_view name, std::string_view other);
  static void rename_plugin(XmlElement& at, std::string_view element, std::string_view plugin, std::string_view other);
  void index(const XmlElement& element);
  void apply_aliases();
  void mark_references(const XmlElement& element);
  /// Throws the error, or makes a note of it if it is not to stop the reading.
  void fail(const SceneError& error, const char* instead = "left out");

  XmlElement root_;
  bool lenient_ = false;
  std::vector<std::string> left_out_;
  std::vector<std::filesystem::path> search_;         ///< in order of search
  mutable std::vector<std::filesystem::path> files_;  ///< see files(): a record, no part of what the scene means
  std::unordered_map<std::string, const XmlElement*> ids_;
  std::unordered_set<const XmlElement*> referenced_;
  std::vector<XmlElement> aliases_;
};

}  // namespace sheaf
