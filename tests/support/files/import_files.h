// Models of COLLADA and FBX that tests compose of their own parts.
#pragma once

#include "tests/support/files/model_files.h"

#include <array>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace sheaf::test {

/// A <source> of numbers: `stride` per element, with unnamed parameters.
inline std::string collada_source(const std::string& id, const std::vector<double>& numbers, std::size_t stride) {
  const std::string count = std::to_string(numbers.size());
  std::string params;
  for (std::size_t i = 0; i < stride; ++i)
    params += std::string("<param name='") + (stride > 4 ? "M" : std::string(1, "XYZW"[i])) + "' type='float'/>";
  return "<source id='" + id + "'><float_array id='" + id + "-array' count='" + count + "'>" + joined(numbers, " ") +
         "</float_array><technique_common><accessor source='#" + id + "-array' count='" +
         std::to_string(numbers.size() / stride) + "' stride='" + std::to_string(stride) + "'>" + params +
         "</accessor></technique_common></source>";
}

/// A square of side 1 around the origin, in the plane z = 0: the geometry 'square'.
inline std::string collada_square() {
  return "<geometry id='square'><mesh>" +
         collada_source("square-p", {-0.5, -0.5, 0, 0.5, -0.5, 0, 0.5, 0.5, 0, -0.5, 0.5, 0}, 3) +
         "<vertices id='square-v'><input semantic='POSITION' source='#square-p'/></vertices><polylist count='1'><input "
         "semantic='VERTEX' source='#square-v' offset='0'/><vcount>4</vcount><p>0 1 2 "
         "3</p></polylist></mesh></geometry>";
}

/// A file with these geometries, nodes and other libraries.
inline std::string collada_file(const std::string& geometries, const std::string& nodes,
                                const std::string& libraries = {}) {
  return "<?xml version='1.0'?>\n<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>\n"
         "<asset><unit name='u' meter='1'/><up_axis>Y_UP</up_axis></asset>\n" +
         libraries + "<library_geometries>" + geometries +
         "</library_geometries>\n<library_visual_scenes><visual_scene id='s'>" + nodes +
         "</visual_scene></library_visual_scenes>\n<scene><instance_visual_scene url='#s'/></scene></COLLADA>\n";
}

/// The name of an object of FBX with its class.
struct FbxName {
  std::string name, kind;
};
/// A value of an element of FBX. Numbers in files are 32-bit integers, ids (64 bits), doubles, or arrays.
using FbxItem = std::variant<std::int32_t, std::int64_t, double, std::string, FbxName, std::vector<double>,
                             std::vector<std::int32_t>>;
/// An element of FBX.
struct FbxBlock {
  std::string name;
  std::vector<FbxItem> values = {};
  std::vector<FbxBlock> children = {};
};

/// A property of an object.
inline FbxBlock fbx_property(const std::string& name, const std::string& type, const FbxItem& value) {
  return {"P", {name, type, std::string(), std::string("A"), value}, {}};
}
inline FbxBlock fbx_property(const std::string& name, const std::string& type, const std::array<double, 3>& v) {
  return {"P", {name, type, std::string(), std::string("A"), v[0], v[1], v[2]}, {}};
}

/// Squares, cameras and lights of FBX, in centimeters.
class FbxFile {
 public:
  /// Adds a model and returns its id. `parent` 0: the root.
  std::int64_t add_model(const std::string& name, const std::string& kind, std::vector<FbxBlock> properties,
                         std::int64_t parent = 0) {
    return add("Model", name, "Model", kind, std::move(properties), parent);
  }
  /// Adds a mesh of one square of side 2 m.
  std::int64_t add_square(const std::string& name, std::vector<FbxBlock> properties, std::int64_t parent = 0) {
    const std::int64_t model = add_model(name, "Mesh", std::move(properties), parent);
    add_polygon({-100, -100, 0, 100, -100, 0, 100, 100, 0, -100, 100, 0}, model);
    return model;
  }
  /// Adds a polygon to a model, by its coordinates.
  void add_polygon(const std::vector<double>& vertices, std::int64_t model) {
    std::vector<std::int32_t> corners;
    for (std::size_t i = 0; i < vertices.size() / 3; ++i) corners.push_back(static_cast<std::int32_t>(i));
    corners.back() = -corners.back() - 1;
    const std::int64_t id = add("Geometry", "shape", "Geometry", "Mesh", {}, model);
    (void)id;
    objects_.back().children = {{"Vertices", {vertices}, {}},
                                {"PolygonVertexIndex", {corners}, {}},
                                {"GeometryVersion", {std::int32_t{124}}, {}}};
  }
  /// Adds a camera or a light with its model.
  std::int64_t add_attribute(const std::string& name, const std::string& kind, std::vector<FbxBlock> properties,
                             std::vector<FbxBlock> model_properties = {}) {
    const std::int64_t model = add_model(name, kind, std::move(model_properties));
    add("NodeAttribute", name, "NodeAttribute", kind, std::move(properties), model);
    return model;
  }
  /// Adds a layer with one model.
  void add_layer(std::vector<FbxBlock> properties, std::int64_t model) {
    connect(model, add("CollectionExclusive", "layer", "DisplayLayer", "DisplayLayer", std::move(properties), 0));
  }
  /// Adds the default properties of a class of objects, such as FbxCamera.
  void add_template(const std::string& type, const std::string& name, std::vector<FbxBlock> properties) {
    const FbxBlock list{"Properties70", {}, std::move(properties)};
    templates_.push_back({"ObjectType", {type}, {{"PropertyTemplate", {name}, {list}}}});
  }
  void connect(std::int64_t child, std::int64_t parent, const std::string& property = {}) {
    if (property.empty())
      connections_.push_back({"C", {std::string("OO"), child, parent}, {}});
    else
      connections_.push_back({"C", {std::string("OP"), child, parent, property}, {}});
  }

  std::string text() const {
    std::string out = "; FBX 7.4.0 project file\n";
    for (const FbxBlock& block : blocks()) out += text_of(block);
    return out;
  }
  /// `version`: 7400 (offsets of 32 bits) or 7500 (of 64 bits).
  std::string binary(std::uint32_t version) const {
    std::string out = std::string("Kaydara FBX Binary  \0\x1a\0", 23) + bytes_of(version);
    for (const FbxBlock& block : blocks()) out += binary_of(block, out.size(), version >= 7500);
    return out + std::string(version >= 7500 ? 25 : 13, '\0');
  }

 private:
  std::int64_t add(const std::string& element, const std::string& name, const std::string& kind,
                   const std::string& type, std::vector<FbxBlock> properties, std::int64_t parent) {
    const std::int64_t id = ++last_id_;
    std::vector<FbxBlock> children = {{"Version", {std::int32_t{232}}, {}}};
    children.push_back({"Properties70", {}, std::move(properties)});
    objects_.push_back({element, {id, FbxName{name, kind}, type}, std::move(children)});
    connect(id, parent);
    return id;
  }

  std::vector<FbxBlock> blocks() const {
    std::vector<FbxBlock> settings;
    for (const auto& [name, value] : {std::pair{"UpAxis", 1},
                                      {"UpAxisSign", 1},
                                      {"FrontAxis", 2},
                                      {"FrontAxisSign", 1},
                                      {"CoordAxis", 0},
                                      {"CoordAxisSign", 1}})
      settings.push_back(fbx_property(name, "int", std::int32_t{value}));
    settings.push_back(fbx_property("UnitScaleFactor", "double", 1.0));
    return {{"FBXHeaderExtension",
             {},
             {{"FBXHeaderVersion", {std::int32_t{1003}}, {}}, {"FBXVersion", {std::int32_t{7400}}, {}}}},
            {"GlobalSettings", {}, {{"Properties70", {}, settings}}},
            {"Definitions", {}, templates_},
            {"Objects", {}, objects_},
            {"Connections", {}, connections_}};
  }

  struct Text {
    std::string operator()(std::int32_t v) const { return std::to_string(v); }
    std::string operator()(std::int64_t v) const { return std::to_string(v); }
    std::string operator()(double v) const { return std::to_string(v); }
    std::string operator()(const std::string& v) const { return '"' + v + '"'; }
    std::string operator()(const FbxName& v) const { return '"' + v.kind + "::" + v.name + '"'; }
    template <class T> std::string operator()(const std::vector<T>& v) const {
      return "*" + std::to_string(v.size()) + " {\na: " + joined(v, ",") + "\n}";
    }
  };
  static std::string text_of(const FbxBlock& block) {
    std::string out = block.name + ": ";
    for (std::size_t i = 0; i < block.values.size(); ++i)
      out += (i > 0 ? "," : "") + std::visit(Text{}, block.values[i]);
    if (block.children.empty()) return out + (block.values.empty() ? " {\n}\n" : "\n");
    out += " {\n";
    for (const FbxBlock& child : block.children) out += text_of(child);
    return out + "}\n";
  }

  struct Binary {
    std::string operator()(std::int32_t v) const { return "I" + bytes_of(v); }
    std::string operator()(std::int64_t v) const { return "L" + bytes_of(v); }
    std::string operator()(double v) const { return "D" + bytes_of(v); }
    std::string operator()(const std::string& v) const {
      return "S" + bytes_of(static_cast<std::uint32_t>(v.size())) + v;
    }
    std::string operator()(const FbxName& v) const { return (*this)(v.name + std::string("\0\1", 2) + v.kind); }
    template <class T> std::string operator()(const std::vector<T>& v) const {
      std::string bytes;
      for (const T number : v) bytes += bytes_of(number);
      return std::string(std::is_same_v<T, double> ? "d" : "i") + bytes_of(static_cast<std::uint32_t>(v.size())) +
             bytes_of(0u) + bytes_of(static_cast<std::uint32_t>(bytes.size())) + bytes;
    }
  };
  /// The record of a block at an offset of the file.
  static std::string binary_of(const FbxBlock& block, std::size_t at, bool is_long) {
    const auto offset = [&](std::size_t v) {
      return is_long ? bytes_of(std::uint64_t{v}) : bytes_of(static_cast<std::uint32_t>(v));
    };
    std::string values;
    for (const FbxItem& value : block.values) values += std::visit(Binary{}, value);
    const std::size_t header = (is_long ? 24 : 12) + 1 + block.name.size();
    std::string inside;
    for (const FbxBlock& child : block.children)
      inside += binary_of(child, at + header + values.size() + inside.size(), is_long);
    if (!block.children.empty() || block.values.empty()) inside += std::string(is_long ? 25 : 13, '\0');
    return offset(at + header + values.size() + inside.size()) + offset(block.values.size()) + offset(values.size()) +
           static_cast<char>(block.name.size()) + block.name + values + inside;
  }

  std::vector<FbxBlock> objects_, connections_, templates_;
  std::int64_t last_id_ = 1000;
};

}  // namespace sheaf::test
