// Values stored with meshes as textures.
#pragma once

#include "scene/textures/texture.h"

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
  static MeshAttributeDescription read(Properties& p);
  static constexpr auto fields(auto& s) { return std::tie(s.name, s.scale); }
  static constexpr auto colors(auto&) { return std::tie(); }
  void scale_by(float by) { scale *= by; }

  void make_row(TextureRowBuilder& row) const {
    row.expect_attribute_name(name);
    row.expect_finite(scale, "scale");
    row.set(MeshAttributeRow{row.require_attribute(name), scale});
  }
};

}  // namespace sheaf
