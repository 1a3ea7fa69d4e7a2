// The edges of a mesh's triangles as a texture.
#pragma once

#include "scene/textures/texture.h"

namespace sheaf {

/// Names of the mesh attributes that wireframes read; invalid as names in files. The values of a triangle are the
/// distances of its corners from the opposite edges, in meters or in tenths of the mesh's mean edge length.
inline constexpr const char *kEdgeDistances = "face_ edge distances",
                            *kRelativeEdgeDistances = "face_ relative edge distances";

/// Data of a wireframe's row.
struct WireframeRow {
  std::uint32_t attribute;  ///< the distances, into TextureTables::attribute_names
  /// In the unit of the distances. Up to `inner` only the edge shows, from `outer` on only the interior;
  /// inner <= outer.
  float inner, outer;
};

/// Edges of a mesh's triangles: `edge` within `line_width` of an edge, `interior` elsewhere. Distances are measured in
/// the space in which the shape is compiled. A smooth step blends the two over the outer `step_width` (a fraction) of
/// that distance. Shapes other than meshes show `interior`.
struct WireframeDescription {
  SpectrumInput interior = SpectrumDescription::constant(0.5f), edge = SpectrumDescription::constant(0.1f);
  float line_width = 0;  ///< meters; 0: 1/10 of the mean edge length of each mesh
  float step_width = 0.5f;

  static constexpr TextureDomain kDomain = TextureDomain::kMesh;
  static constexpr std::array kPlugins = {"wireframe"};
  static constexpr ParameterName kParameters[] = {
      {"interior_color"}, {"edge_color"}, {"line_width", nullptr, kNotNegative}, {"step_width"}};
  static constexpr auto fields(auto& s) { return std::tie(s.interior, s.edge, s.line_width, s.step_width); }
  static constexpr auto colors(auto& s) { return std::tie(s.interior, s.edge); }
  static constexpr bool kShowsColors = true;

  void make_row(TextureRowBuilder& row) const {
    if (!(line_width >= 0)) throw row.error("'line_width' is negative or not a number");
    if (!(step_width >= 0 && step_width <= 1)) throw row.error("'step_width' is not within [0, 1]");
    const bool relative = line_width == 0;
    const float outer = relative ? 1.0f : line_width;
    row.add_inputs(interior, edge);
    row.set(WireframeRow{row.attribute(relative ? kRelativeEdgeDistances : kEdgeDistances), outer * (1 - step_width),
                         outer});
  }
};

}  // namespace sheaf
