#include "tools/importer/collada_document.h"

#include "tools/importer/collada.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <string_view>

namespace sheaf::importer {

namespace {

/// Lists all elements in the order of the file.
class Elements : public pugi::xml_tree_walker {
 public:
  std::vector<pugi::xml_node> list;

  bool for_each(pugi::xml_node& node) override {
    if (node.type() == pugi::node_element) list.push_back(node);
    return true;
  }
};

/// Indexes the document. Nodes without an id get one, by their sid or name.
void index_elements(ColladaDocument& document) {
  Elements elements;
  document.xml.traverse(elements);
  for (const pugi::xml_node& element : elements.list) {
    if (const pugi::xml_attribute id = element.attribute("id")) document.by_id.try_emplace(id.value(), element);
    if (std::string_view(element.name()) == "node") document.nodes.push_back(element);
  }
  for (pugi::xml_node& node : document.nodes) {
    if (*node.attribute("id").value() != '\0') continue;
    const pugi::xml_attribute sid = node.attribute("sid"), name = node.attribute("name");
    const std::string id = document.unique_id(sid ? sid.value() : name ? name.value() : "node");
    node.remove_attribute("id");
    node.append_attribute("id") = id.c_str();
    document.by_id[id] = node;
  }
}

}  // namespace

pugi::xml_node ColladaDocument::target(const pugi::xml_attribute& url) const {
  const std::string_view text = url.value();
  if (!text.starts_with('#')) return {};
  const auto found = by_id.find(std::string(text.substr(1)));
  return found == by_id.end() ? pugi::xml_node() : found->second;
}

std::string ColladaDocument::unique_id(const std::string& stem) {
  std::string id = stem;
  // The number of ids grows with each one; the first try after `stem` is therefore usually free.
  for (std::size_t i = by_id.size(); id.empty() || by_id.contains(id); ++i) id = fmt::format("{}${}", stem, i);
  by_id.try_emplace(id);
  return id;
}

std::vector<double> numbers_of(const pugi::xml_node& element) {
  std::vector<double> out;
  for (const char* text = element.child_value();;) {
    char* end = nullptr;
    const double value = std::strtod(text, &end);
    if (end == text) return out;
    out.push_back(value);
    text = end;
  }
}

double ColladaSource::number(std::size_t i, std::size_t k) const {
  const std::size_t at = offset + i * stride + k;
  return at < numbers.size() ? numbers[at] : 0;
}

ColladaSource read_source(const ColladaDocument& document, const pugi::xml_node& source) {
  ColladaSource out;
  const pugi::xml_node accessor = source.child("technique_common").child("accessor");
  pugi::xml_node array = document.target(accessor.attribute("source"));
  if (!array) array = source.child("float_array");
  if (std::string_view(array.name()) == "Name_array") {
    std::istringstream words(array.child_value());
    for (std::string word; words >> word;) out.names.push_back(word);
  } else {
    out.numbers = numbers_of(array);
  }
  out.stride = accessor.attribute("stride").as_uint(1);
  out.offset = accessor.attribute("offset").as_uint(0);
  if (out.stride == 0) out.stride = 1;
  const std::size_t size = out.numbers.size() + out.names.size();
  const std::size_t available = size > out.offset ? (size - out.offset) / out.stride : 0;
  out.count = std::min<std::size_t>(accessor.attribute("count").as_uint(0), available);
  return out;
}

FileParts take_collada_parts(std::string& bytes) {
  FileParts out;
  ColladaDocument document;
  if (!document.xml.load_buffer(bytes.data(), bytes.size())) return out;
  index_elements(document);
  join_holes(document, out);
  take_optics(document, out);
  take_animations(document, out);
  std::ostringstream text;
  document.xml.save(text, "", pugi::format_raw | pugi::format_no_declaration);
  bytes = std::move(text).str();
  return out;
}

}  // namespace sheaf::importer
