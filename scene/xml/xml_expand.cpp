// Expansion of a scene file: includes, parameters, search paths, and ids.
#include "scene/xml/xml_expand.h"

#include "scene/xml/definitions.h"
#include "scene/xml/missing_file.h"

#include <fmt/format.h>

#include <algorithm>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

constexpr int kMaxIncludeDepth = 15;
constexpr int kMaxIncludes = 10'000;
constexpr std::size_t kMaxElements = 20'000'000;
constexpr std::size_t kMaxParameterLength = std::size_t{1} << 20;

/// Whether an element is a directive that is replaced by its meaning.
bool is_directive(const XmlElement& element) {
  const std::string_view name = element.name;  // whose comparison starts with the length
  return name == "default" || name == "path" || name == "alias" || name == "include";
}

/// `base / name` if that exists, otherwise with backslashes replaced by slashes; empty if neither exists.
fs::path existing(const fs::path& base, const std::string& name) {
  std::error_code error;
  if (fs::path candidate = base / name; fs::exists(candidate, error)) return candidate;
  std::string forward = name;
  std::replace(forward.begin(), forward.end(), '\\', '/');
  if (fs::path candidate = base / forward; forward != name && fs::exists(candidate, error)) return candidate;
  return {};
}

fs::path find_existing(const std::string& name, const std::vector<fs::path>& search, const SourceLocation& where) {
  if (name.empty()) throw SceneError(where, "empty file name", SceneErrorCode::kMissingFile);
  if (fs::path(name).is_absolute()) {
    if (fs::path found = existing({}, name); !found.empty()) return found;
    throw SceneError(where, missing_file(name, {}), SceneErrorCode::kMissingFile);
  }
  std::vector<fs::path> folders = search;
  if (fs::path own = fs::path(where.file.string()).parent_path();
      std::find(search.begin(), search.end(), own) == search.end())
    folders.push_back(own);
  for (const fs::path& folder : folders)
    if (fs::path found = existing(folder, name); !found.empty()) return found;
  throw SceneError(where, missing_file(name, folders), SceneErrorCode::kMissingFile);
}

}  // namespace

/// The state of one expansion: definitions and limits.
struct ExpandedScene::Expansion {
  ExpandedScene& scene;
  ErrorSink& errors;
  Definitions definitions;
  int includes = 0;
  std::size_t elements = 0;

  void substitute(XmlAttribute& attribute, const SourceLocation& where) {
    if (attribute.value.find('$') == std::string::npos) return;
    TextLocation location{where, attribute.column};
    if (attribute.line > 0) location.where.line = attribute.line;
    attribute.value = definitions.substitute(attribute.value, location,
                                             [&](const SceneError& error) { errors.report(error, "left empty"); });
  }

  void define_default(const XmlElement& element) {
    element.expect_attributes({"name", "value"});
    const std::string& name = element.attribute("name");
    if (!is_definition_name(name))
      throw SceneError(element.where, in_quotes(name) + " is not a parameter name, expected letters, digits and _");
    if (element.attribute("value").size() > kMaxParameterLength)
      throw SceneError(element.where, "the default value is longer than 1 MiB");
    definitions.add_default(name, element.attribute("value"));
  }

  void add_path(const XmlElement& element) {
    element.expect_attributes({"value"});
    const std::string& value = element.attribute("value");
    const fs::path own = fs::path(element.where.file.string()).parent_path();
    fs::path folder = fs::path(value).is_absolute() ? existing({}, value) : existing(own, value);
    if (folder.empty()) folder = find_existing(value, scene.search_, element.where);
    if (!fs::is_directory(folder))
      throw SceneError(element.where, in_quotes(value) + " is not a folder", SceneErrorCode::kMissingFile);
    scene.search_.insert(scene.search_.begin(), folder);
  }

  void include(const XmlElement& element, int include_depth, std::vector<XmlElement>& out) {
    element.expect_attributes({"filename"});
    if (include_depth >= kMaxIncludeDepth)
      throw SceneError(element.where, fmt::format("includes are nested deeper than {} levels; does {} include itself?",
                                                  kMaxIncludeDepth, in_quotes(element.attribute("filename"))));
    if (++includes > kMaxIncludes) throw SceneError(element.where, "more than 10000 includes");
    XmlElement included = read_xml(scene.find_file(element.attribute("filename"), element.where), errors);
    std::vector<XmlElement> children;
    if (included.name == "scene") {
      children = std::move(included.children);
    } else {
      children.push_back(std::move(included));
    }
    expand(children, include_depth + 1);
    out.reserve(out.size() + children.size());
    std::move(children.begin(), children.end(), std::back_inserter(out));
  }

  /// Calls look(), which searches a file. Its errors end strict reading, because they would cause further ones.
  template <class Look> void omit_if_missing(Look&& look) {
    try {
      look();
    } catch (const SceneError& error) {
      if (!errors.is_lenient()) throw;
      errors.report(error, "ignored");
    }
  }

  /// Expands the children of an element in place.
  void expand(std::vector<XmlElement>& children, int include_depth) {
    const bool in_place = std::none_of(children.begin(), children.end(), is_directive);
    std::vector<XmlElement> out;
    for (XmlElement& child : children) {
      if (++elements > kMaxElements) throw SceneError(child.where, "more than 20 million elements");
      for (XmlAttribute& attribute : child.attributes) substitute(attribute, child.where);
      if (in_place) {
        expand(child.children, include_depth);
      } else if (child.name == "default") {
        define_default(child);
      } else if (child.name == "path") {
        omit_if_missing([&] { add_path(child); });
      } else if (child.name == "alias") {
        scene.aliases_.push_back(std::move(child));
      } else if (child.name == "include") {
        omit_if_missing([&] { include(child, include_depth, out); });
      } else {
        expand(child.children, include_depth);
        out.push_back(std::move(child));
      }
    }
    if (!in_place) children = std::move(out);
  }
};

ExpandedScene::ExpandedScene(const fs::path& file, const std::vector<std::pair<std::string, std::string>>& defines,
                             bool lenient, const std::optional<fs::path>& folder)
    : lenient_(lenient) {
  search_.push_back(folder.value_or(file.parent_path()));
  files_.push_back(file);
  ErrorSink errors(lenient, substitutions_);
  errors.run([&] {
    root_ = read_xml(file, errors);
    Expansion expansion{*this, errors, Definitions(defines)};
    expansion.expand(root_.children, 0);
    expansion.definitions.reject_unused(file.string());
    resolve_ids(errors);
  });
}

ExpandedScene::ExpandedScene(XmlElement root, const fs::path& folder, bool lenient)
    : root_(std::move(root)), lenient_(lenient), search_{folder} {
  ErrorSink errors(lenient_, substitutions_);
  resolve_ids(errors);
  errors.throw_errors();
}

ExpandedScene::ExpandedScene(XmlElement root, const ExpandedScene& original)
    : root_(std::move(root)),
      lenient_(original.lenient_),
      substitutions_(original.substitutions_),
      search_(original.search_),
      files_(original.files_),
      aliases_(original.aliases_) {
  ErrorSink errors(lenient_, substitutions_);
  resolve_ids(errors);
  errors.throw_errors();
}

void ExpandedScene::resolve_ids(ErrorSink& errors) {
  std::vector<const std::string*> references;
  for (const XmlElement& child : root_.children) index(child, errors, references);
  apply_aliases(errors);
  for (const std::string* id : references)
    if (const auto found = ids_.find(*id); found != ids_.end()) referenced_.insert(found->second);
}

void ExpandedScene::index(const XmlElement& element, ErrorSink& errors, std::vector<const std::string*>& references) {
  const std::string* id = element.find_attribute("id");
  if (id != nullptr && element.name == "ref") {
    references.push_back(id);
  } else if (id != nullptr) {
    const auto [it, inserted] = ids_.emplace(*id, &element);
    if (!inserted) {
      const SourceLocation& first = it->second->where;
      const SceneError error(element.where,
                             fmt::format("id {} is already taken by <{}> in {}:{}", in_quotes(*id), it->second->name,
                                         first.file.string(), first.line),
                             SceneErrorCode::kDuplicate);
      errors.report(error.about(fmt::format("<{}>", element.name)), "the first one is used");
    }
  }
  for (const XmlElement& child : element.children) index(child, errors, references);
}

void ExpandedScene::apply_aliases(ErrorSink& errors) {
  for (const XmlElement& alias : aliases_) {
    try {
      alias.expect_attributes({"id", "as"});
      const XmlElement& target = find(alias.attribute("id"), alias.where);
      if (!ids_.emplace(alias.attribute("as"), &target).second)
        throw SceneError(alias.where, fmt::format("id {} is already taken", in_quotes(alias.attribute("as"))),
                         SceneErrorCode::kDuplicate);
    } catch (const SceneError& error) { errors.report(error.about("<alias>"), "ignored"); }
  }
}

void ExpandedScene::rename(XmlElement& element, std::span<const ElementSynonym> elements,
                           std::span<const PluginSynonym> plugins) {
  for (const ElementSynonym& synonym : elements)
    if (element.name == synonym.old) element.name = synonym.now;
  for (const PluginSynonym& synonym : plugins) {
    if (element.name != synonym.element) continue;
    for (XmlAttribute& attribute : element.attributes)
      if (attribute.name == "type" && attribute.value == synonym.old) attribute.value = synonym.now;
  }
  for (XmlElement& child : element.children) rename(child, elements, plugins);
}

const XmlElement& ExpandedScene::find(const std::string& id, const SourceLocation& where) const {
  if (auto it = ids_.find(id); it != ids_.end()) return *it->second;
  std::vector<std::string> known;
  for (const auto& entry : ids_) known.push_back(entry.first);
  std::sort(known.begin(), known.end());
  throw SceneError(where, fmt::format("no object has the id {}{}", in_quotes(id), did_you_mean(id, known)),
                   SceneErrorCode::kUnknownName);
}

fs::path ExpandedScene::find_file(const std::string& name, const SourceLocation& where) const {
  fs::path found = find_existing(name, search_, where);
  std::error_code error;
  if (!fs::is_regular_file(found, error))
    throw SceneError(where, in_quotes(found.string()) + " is not a regular file", SceneErrorCode::kMissingFile);
  // Many instances may name the same file, mostly consecutively.
  found = found.lexically_normal();
  if (files_.empty() || files_.back() != found) files_.push_back(found);
  return found;
}

}  // namespace sheaf
