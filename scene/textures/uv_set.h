// Textures at other texture coordinates than the surface's.
#pragma once

#include "scene/textures/texture.h"

#include <string>

namespace sheaf {

/// Data of a uv set's row.
struct UvSetRow {
  std::uint32_t attribute;  ///< the coordinates, into TextureTables::attribute_names
};

/// Looks `input` up at the texture coordinates in a mesh attribute, instead of the uv of the surface. The transform of
/// the input applies; the texture's own does not. On shapes that lack the attribute, uv is (0, 0).
struct UvSetTextureDescription {
  /// Begins with "vertex_" or "face_", e.g. "vertex_uv1". Of its three channels the first two are u and v.
  std::string attribute;
  SpectrumInput input = SpectrumDescription::constant(1);

  static constexpr TextureDomain kDomain = TextureDomain::kMesh;
  static constexpr auto kPlugins = kNoPlugins;
  static constexpr auto fields(auto& s) { return std::tie(s.attribute, s.input); }
  static constexpr auto colors(auto& s) { return std::tie(s.input); }
  static constexpr bool kShowsColors = true;

  void make_row(TextureRowBuilder& row) const {
    row.expect_attribute_name(attribute);
    row.add_inputs(input);
    row.set(UvSetRow{row.attribute(attribute)});
  }
};

}  // namespace sheaf
