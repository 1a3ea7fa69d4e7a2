// Wraps pugixml: parsing, conversion of byte offsets to line numbers, and limits against hostile files.
#include "scene/xml/xml.h"

#include "core/io/byte_order_mark.h"

#include <fmt/format.h>
#include <pugixml.hpp>

#include <algorithm>
#include <fstream>

namespace sheaf {

namespace {

constexpr int kMaxDepth = 100;
constexpr std::size_t kMaxAttributes = 64;
constexpr std::uintmax_t kMaxFileSize = std::uintmax_t{1} << 30;

std::string read_text(const std::filesystem::path& file) {
  const SourceLocation where{file.string(), 0};
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw SceneError(where, "file not found", SceneErrorCode::kMissingFile);
  if (!std::filesystem::is_regular_file(file, error))
    throw SceneError(where, "not a regular file", SceneErrorCode::kMissingFile);
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error) throw SceneError(where, "cannot be read: " + error.message());
  if (size > kMaxFileSize) throw SceneError(where, "scene file is larger than 1 GiB", SceneErrorCode::kTooLarge);
  std::string text(static_cast<std::size_t>(size), '\0');
  std::ifstream stream(file, std::ios::binary);
  if (!stream.read(text.data(), static_cast<std::streamsize>(size))) throw SceneError(where, "cannot be read");
  remove_byte_order_mark(text, file.string());
  return text;
}

/// Converts byte offsets to line numbers. Fast for offsets that increase in small steps.
class LineIndex {
 public:
  explicit LineIndex(std::string_view text) {
    for (std::size_t i = text.find('\n'); i != text.npos; i = text.find('\n', i + 1)) line_ends_.push_back(i);
  }
  int line(std::ptrdiff_t offset) {
    if (offset < 0) return 0;
    const auto at = static_cast<std::size_t>(offset);
    if (before_ > 0 && line_ends_[before_ - 1] >= at)
      before_ =
          static_cast<std::size_t>(std::lower_bound(line_ends_.begin(), line_ends_.end(), at) - line_ends_.begin());
    while (before_ < line_ends_.size() && line_ends_[before_] < at) ++before_;
    return static_cast<int>(before_) + 1;
  }
  int column(std::ptrdiff_t offset) {
    const int before = line(offset) - 1;
    const std::ptrdiff_t start =
        before > 0 ? static_cast<std::ptrdiff_t>(line_ends_[static_cast<std::size_t>(before) - 1]) + 1 : 0;
    return static_cast<int>(offset - start) + 1;
  }

 private:
  std::vector<std::size_t> line_ends_;
  std::size_t before_ = 0;  ///< number of line ends before the offset of the last query
};

std::size_t count_attributes(const pugi::xml_node& node) {
  std::size_t count = 0;
  for (pugi::xml_attribute attribute = node.first_attribute(); attribute; attribute = attribute.next_attribute())
    ++count;
  return count;
}

std::size_t count_children(const pugi::xml_node& node) {
  std::size_t count = 0;
  for (pugi::xml_node child = node.first_child(); child; child = child.next_sibling()) ++count;
  return count;
}

struct Converter {
  FileName file;
  const char* buffer;  ///< the text, parsed in place
  LineIndex lines;
  ErrorSink& errors;

  SourceLocation where(const pugi::xml_node& node) { return {file, lines.line(node.offset_debug())}; }

  void report_text(const pugi::xml_node& node) {
    const std::string_view text = node.value();
    const std::size_t first = std::min(text.find_first_not_of(" \t\r\n"), text.size());
    const std::string_view word = text.substr(first, text.find_first_of(" \t\r\n<", first) - first);
    SourceLocation position = where(node);
    position.line +=
        static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(first), '\n'));
    const std::string element = fmt::format("<{}>", node.parent().name());
    const SceneError error(position, fmt::format("unexpected text {} inside {}", in_quotes(word), element),
                           SceneErrorCode::kSyntax);
    errors.report(error.about(element), "ignored");
  }

  /// Sets the position of a value at this offset if it contains an expression.
  void place_expression(XmlAttribute& attribute, std::ptrdiff_t offset) {
    if (attribute.value.find("$(") == std::string::npos) return;
    const int line = lines.line(offset);
    if (lines.line(offset + static_cast<std::ptrdiff_t>(attribute.value.size())) != line) return;
    attribute.line = line;
    attribute.column = lines.column(offset);
  }

  /// Converts `node` to `element`, which is empty. Removes the children from pugixml's tree meanwhile, so that a large
  /// scene is not in memory twice.
  void convert(pugi::xml_node node, int depth, XmlElement& element) {
    element.name = node.name();
    element.where = where(node);
    if (depth > kMaxDepth)
      throw SceneError(element.where, fmt::format("elements are nested deeper than {} levels", kMaxDepth),
                       SceneErrorCode::kTooLarge);
    // Copy the attributes, each once
    element.attributes.reserve(count_attributes(node));
    for (pugi::xml_attribute attribute = node.first_attribute(); attribute; attribute = attribute.next_attribute()) {
      const std::string_view name = attribute.name();
      if (element.find_attribute(name) != nullptr) {
        const SceneError error(element.where, fmt::format("attribute {} is set twice, expected once", in_quotes(name)),
                               SceneErrorCode::kDuplicate);
        errors.report(error.about(fmt::format("<{}>", element.name)), "the last one is used");
        std::erase_if(element.attributes, [&](const XmlAttribute& a) { return a.name == name; });
      }
      if (element.attributes.size() == kMaxAttributes)
        throw SceneError(element.where, fmt::format("more than {} attributes", kMaxAttributes),
                         SceneErrorCode::kTooLarge);
      const char* const value = attribute.value();
      XmlAttribute& added = element.attributes.emplace_back();
      added.name = name;
      added.value = value;
      place_expression(added, value - buffer);
    }
    // Convert the children, and free their nodes
    element.children.reserve(count_children(node));
    for (pugi::xml_node child; (child = node.first_child()); node.remove_child(child)) {
      if (child.type() == pugi::node_element) {
        convert(child, depth + 1, element.children.emplace_back());
      } else if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata) {
        report_text(child);
      }
    }
  }
};

}  // namespace

const std::string* XmlElement::find_attribute(std::string_view attribute_name) const {
  for (const XmlAttribute& a : attributes)
    if (a.name == attribute_name) return &a.value;
  return nullptr;
}

const std::string& XmlElement::attribute(std::string_view attribute_name) const {
  if (const std::string* value = find_attribute(attribute_name)) return *value;
  std::vector<std::string> present;
  for (const XmlAttribute& a : attributes) present.push_back(a.name);
  std::string message = fmt::format("<{}> needs an attribute '{}'", name, attribute_name);
  const std::string similar = nearest_name(attribute_name, present);
  if (!similar.empty()) message += ", found " + in_quotes(similar);
  throw SceneError(where, message, SceneErrorCode::kMissing).about(fmt::format("<{}>", name));
}

void XmlElement::expect_attributes(std::initializer_list<const char*> allowed) const {
  for (const XmlAttribute& a : attributes) {
    const std::string_view given = a.name;
    if (std::any_of(allowed.begin(), allowed.end(), [&](const char* known) { return given == known; })) continue;
    const std::vector<std::string> names(allowed.begin(), allowed.end());
    throw SceneError(where,
                     fmt::format("<{}> has no attribute {}{}", name, in_quotes(a.name), did_you_mean(a.name, names)),
                     SceneErrorCode::kUnknownName)
        .about(fmt::format("<{}>", name));
  }
}

XmlElement read_xml(const std::filesystem::path& file, ErrorSink& errors) {
  std::string text = read_text(file);
  Converter converter{file.string(), text.data(), LineIndex(text), errors};
  pugi::xml_document document;
  const pugi::xml_parse_result result =
      document.load_buffer_inplace(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
  if (result.status == pugi::status_no_document_element)
    throw SceneError(SourceLocation{converter.file, 1}, "the file has no XML element, expected <scene>",
                     SceneErrorCode::kSyntax);
  if (!result)
    throw SceneError(SourceLocation{converter.file, converter.lines.line(result.offset)},
                     std::string("not well-formed XML: ") + result.description(), SceneErrorCode::kSyntax);
  const pugi::xml_node root = document.document_element();
  for (pugi::xml_node other = root.next_sibling(); other; other = other.next_sibling())
    if (other.type() == pugi::node_element)
      throw SceneError(converter.where(other), fmt::format("a second root element <{}>", other.name()),
                       SceneErrorCode::kSyntax);
  XmlElement element;
  converter.convert(root, 1, element);
  return element;
}

}  // namespace sheaf
