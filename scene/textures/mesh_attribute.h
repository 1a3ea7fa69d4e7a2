// Values stored with meshes as textures.
#pragma once

#include "scene/textures/texture.h"

#include <cmath>
#include <string>

namespace sheaf {

/// Data of a mesh attribute's row.
struct MeshAttributeRow {
  std::uint32_t attribute;  ///< into TextureTables::attribute_names
  float scale;
};

/// Values stored with a mesh's vertices or faces, e.g. "vertex_color". Zero on shapes that lack them.
struct MeshAttributeDescription {
  std::string name;  ///< begins with "vertex_" or "face_"
  float scale = 1;

  static constexpr TextureDomain kDomain = TextureDomain::kMesh;
  static constexpr std::array kPlugins = {"mesh_attribute", "vertexcolors"};
  static MeshAttributeDescription read(auto& p) {
    if (p.type() == "vertexcolors") return {"vertex_color"};
    const std::string name = p.required_string("name");
    if (!is_attribute_name(name))
      p.fail_at("name", "is " + in_quotes(name) + ", expected a name that begins with vertex_ or face_");
    return {name, p.number("scale", 1)};
  }
  static constexpr auto fields(auto& s) { return std::tie(s.name, s.scale); }
  static constexpr auto colors(auto&) { return std::tie(); }
  void scale_by(float by) { scale *= by; }

  void make_row(auto& row) const {
    check_attribute_name(row, name);
    if (!std::isfinite(scale)) throw row.error("'scale' is not finite");
    row.set(MeshAttributeRow{row.require_attribute(name), scale});
  }
};

}  // namespace sheaf
