// The lights of shapes, and of instances of them.
#pragma once

#include "scene/compile/light.h"

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
  Vec3f radiance;  ///< with a texture what it is multiplied by
  std::uint32_t texture = kNone;
  SpectrumRow spectrum = {};        ///< the same as `radiance`, in spectral mode
  bool along_normal = false;        ///< see LightRecord::is_along_normal()
  bool two_sided = false;           ///< see LightRecord::is_two_sided()
  std::optional<float> power = {};  ///< see ShapeDescription::power
};

/// How many sides of the surface shine.
inline float sides_of(const LightRow& light) { return light.is_two_sided() ? 2.0f : 1.0f; }

/// The flux per area that an area light emits, over its radiance.
inline float exitance_factor(const LightRow& light) { return (light.is_along_normal() ? 1.0f : kPi) * sides_of(light); }

/// An area light with its triangles and the alias table over them (meshes only).
struct AreaLight {
  LightRow row;
  std::vector<AliasEntry> alias;
  std::vector<LightTriangleRow> triangles;
  std::vector<LightUvRow> uvs;        ///< if it has a texture
  std::optional<QuadricRow> quadric;  ///< in world space, for an instance
};

/// The light of a shape, of index `shape_index`, or of an instance of it if that is not null.
AreaLight make_area_light(const ShapeRow& shape, std::uint32_t shape_index, const ShapeTables& tables,
                          const AreaEmission& emission, const LightPlaces& places, const InstanceRow* instance);

/// What depends on the kind of shape: fills the rest of `light`.
void complete_mesh_light(AreaLight& light, const ShapeRow& shape, const ShapeTables& tables, const LightPlaces& places,
                         const InstanceRow* instance);
void complete_quadric_light(AreaLight& light, const ShapeRow& shape, const ShapeTables& tables,
                            const LightPlaces& places, const InstanceRow* instance);

/// The offset of a point of an instance; see place_instance().
float instance_offset(const InstanceRow& instance, Vec3f p, Vec3f ng, float offset);

}  // namespace sheaf
