// Resolves the elements <include>, <default>, <path>, <alias> and <ref>, and $name parameters. The result is one tree
// of plain objects and properties, for any dialect.
#pragma once

#include "scene/xml/xml.h"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

namespace sheaf {

/// A scene file with its includes inserted and every `$name` replaced. Pointers into `root` remain valid for the
/// object's lifetime, also when it is moved.
class ExpandedScene {
 public:
  /// Reads `file`. Each define is a name and its value; it overrides the <default> of that name. Throws SceneError for
  /// XML errors, an include or path that is not found, includes nested deeper than 15 or more than 10,000 of them, an
  /// undefined `$name`, a define that the scene does not use, and a duplicate id. `lenient`: drops what can be dropped;
  /// see substitutions(). `folder`: to which relative paths refer; default: that of the file.
  ExpandedScene(const std::filesystem::path& file, const std::vector<std::pair<std::string, std::string>>& defines,
                bool lenient = false, const std::optional<std::filesystem::path>& folder = {});

  /// The scene of a program, as a tree without directives. Relative paths refer to `folder`. Throws SceneError for a
  /// duplicate id.
  ExpandedScene(XmlElement root, const std::filesystem::path& folder, bool lenient = false);
  /// The scene `original` with another tree; its elements find the same files and ids. Throws SceneError for a
  /// duplicate id.
  ExpandedScene(XmlElement root, const ExpandedScene& original);

  const XmlElement& root() const { return root_; }
  /// Messages, with file and line, about what was dropped or replaced because it could not be read.
  const std::vector<std::string>& substitutions() const { return substitutions_; }
  /// Another name for an element.
  struct ElementSynonym {
    std::string_view old, now;
  };
  /// Another name for a plugin of the objects with an element name.
  struct PluginSynonym {
    std::string_view element, old, now;
  };
  /// Renames elements and plugins from their old names, in one pass over the tree.
  void rename(std::span<const ElementSynonym> elements, std::span<const PluginSynonym> plugins = {}) {
    rename(root_, elements, plugins);
  }
  /// The element to which `<ref id="...">` at `where` refers. Throws SceneError if it does not exist.
  const XmlElement& find(const std::string& id, const SourceLocation& where) const;
  /// Whether a <ref> refers to this element.
  bool is_referenced(const XmlElement& element) const { return referenced_.count(&element) != 0; }
  /// Finds the file `name`, used by an element at `where`. It is absolute, or relative to a declared path (the last
  /// declared first), to the folder of the scene, or to the folder of the file that names it. Throws SceneError if
  /// it does not exist or is not a regular file.
  std::filesystem::path find_file(const std::string& name, const SourceLocation& where) const;
  /// The scene file, its includes, and all other files found by find_file() so far.
  const std::vector<std::filesystem::path>& files() const { return files_; }

 private:
  struct Expansion;
  static void rename(XmlElement& element, std::span<const ElementSynonym> elements,
                     std::span<const PluginSynonym> plugins);
  /// Resolves ids after the expansion.
  void resolve_ids(ErrorSink& errors);
  /// Enters the ids in the element. `references`: receives the ids of <ref>s.
  void index(const XmlElement& element, ErrorSink& errors, std::vector<const std::string*>& references);
  void apply_aliases(ErrorSink& errors);

  XmlElement root_;
  bool lenient_ = false;
  std::vector<std::string> substitutions_;
  std::vector<std::filesystem::path> search_;         ///< in order of search
  mutable std::vector<std::filesystem::path> files_;  ///< see files(); a record that does not affect the scene
  std::unordered_map<std::string, const XmlElement*> ids_;
  std::unordered_set<const XmlElement*> referenced_;
  std::vector<XmlElement> aliases_;
};

}  // namespace sheaf
