// Lights as rows of tables.
#pragma once

#include "scene/scene.h"

namespace sheaf {

/// The tables that area lights are made from.
struct ShapeTables {
  const VertexRow* vertices;
  const std::uint32_t* triangles;
  const QuadricRow* quadrics;
};

/// Where a light's parts will stand in the scene's tables.
struct LightPlaces {
  std::uint32_t first_triangle;  ///< of light_triangles and triangle_alias
  std::uint32_t first_uv;        ///< of light_uvs
  std::uint32_t quadric;         ///< that of the shape, or for an instance the one to be appended
};

/// What an area light emits.
struct AreaEmission {
  Vec3f radiance;                 ///< with a texture what it is multiplied by
  std::uint32_t texture = kNone;
  SpectrumRow spectrum = {};      ///< the same as `radiance`, in spectral mode
};

/// An area light with its triangles and the alias table over them (meshes only).
struct AreaLight {
  LightRow row;
  std::vector<AliasEntry> alias;
  std::vector<LightTriangleRow> triangles;
  std::vector<LightUvRow> uvs;          ///< if it has a texture
  std::optional<QuadricRow> quadric;    ///< in world space, for an instance
};

/// The light of a shape, of index `shape_index`, or of an instance of it if that is not null.
AreaLight make_area_light(const ShapeRow& shape, std::uint32_t shape_index, const ShapeTables& tables,
                          const AreaEmission& emission, const LightPlaces& places, const InstanceRow* instance);

/// A light that is not on a shape, with its frame if the kind has one.
struct PlacedLight {
  LightRow row;
  std::optional<LightFrameRow> frame;
  SpectrumRow spectrum = {};  ///< what LightRow::radiance is, in spectral mode
};
PlacedLight make_point_light(Vec3f intensity, Vec3f position);
PlacedLight make_constant_light(Vec3f radiance);
/// Throws SceneError at `where` for angles out of order, and a texture on a cone of 180 degrees and more.
PlacedLight make_spot_light(const SpotLightDescription& spot, const SourceLocation& where);
PlacedLight make_directional_light(const DirectionalLightDescription& light, const SourceLocation& where);
/// `aspect`: width over height of the picture. Throws SceneError at `where` if the transform stretches.
PlacedLight make_projector(const ProjectorDescription& projector, double aspect, const SourceLocation& where);
/// The row of an environment map.
PlacedLight make_envmap_light(const Envmap& map);
/// The part of the transform that turns directions from world space to the map's. Throws SceneError at `where` if it
/// stretches.
void set_rotation(Envmap& map, const Transform& to_world, const SourceLocation& where);

/// Whether a light shines from outside of the scene: environments and directions.
bool is_infinite(const LightRow& light);

/// The power that a light gives off, W in R, G and B. Of lights outside of the scene that which reaches the scene's
/// bounding sphere. Textures are averaged over the surface by a few thousand points.
Vec3f light_power(const SceneView& scene, std::uint32_t light);

}  // namespace sheaf
