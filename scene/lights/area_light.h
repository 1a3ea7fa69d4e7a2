// Area lights of shapes and of instances of shapes.
#pragma once

#include "core/sampling/alias_table.h"
#include "scene/lights/list.h"
#include "scene/tables/motion.h"
#include "scene/tables/shape_rows.h"

namespace sheaf {

/// The tables from which area lights are made.
struct ShapeTables {
  const VertexRow* vertices;
  const std::uint32_t* triangles;
  const QuadricRow* quadrics;
  const DeformationRow* deformations;  ///< null: no shape deforms
};

/// Future positions of a light's parts in the scene's tables.
struct LightTableOffsets {
  std::uint32_t first_triangle;  ///< in light_triangles and triangle_alias
  std::uint32_t first_uv;        ///< in light_uvs
  std::uint32_t quadric;         ///< that of the shape; for an instance, the one to be appended
};

/// Emission of an area light.
struct AreaEmission {
  Vec3f radiance;  ///< multiplied by the texture, if any
  std::uint32_t texture = kNone;
  SpectrumRow spectrum = {};        ///< spectrum of `radiance`, in spectral mode
  bool along_normal = false;        ///< see kEmitsAlongNormal
  bool two_sided = false;           ///< see kEmitsOnBothSides
  bool missed_by_rays = false;      ///< see kMissedByRays
  LightCoatRow coat = {};           ///< strength 0 and no texture: none
  std::optional<float> power = {};  ///< see ShapeDescription::power
};

/// Number of sides of the surface that emit.
inline float sides_of(const LightRow& light) { return light.is_two_sided() ? 2.0f : 1.0f; }

/// Radiant exitance of an area light over its radiance.
inline float exitance_factor(const LightRow& light) { return (light.is_along_normal() ? 1.0f : kPi) * sides_of(light); }

/// An area light with its triangles and the alias table over them (meshes only).
struct AreaLight {
  LightRow row;
  std::vector<AliasEntry> alias;            ///< repeated for each step of a mesh that deforms
  std::vector<LightTriangleRow> triangles;  ///< at each step of a mesh that deforms
  std::vector<LightUvRow> uvs;              ///< if it has a texture
  std::optional<QuadricRow> quadric;        ///< in world space, for an instance
  float area = 0;                           ///< in world space, m^2; mean over the steps
};

/// An instance of a shape that emits.
struct LightInstance {
  InstanceRow rest;  ///< rest pose of the light
  /// If it moves: the transforms from the group's space at some times over the shutter, with the changes of their
  /// entries over the whole interval if they always changed as then.
  struct Step {
    InstanceRow placed;
    std::array<float, 12> speed;
  };
  std::vector<Step> steps = {};

  /// Ray offset of a point in the group's space, so that it covers rounding errors at all times. In units of the
  /// resting instance along its normal; see place_instance(). `ng`, `offset`: in the group's space.
  float offset(Vec3f p, Vec3f ng, float offset) const;
};

/// Makes the light of the shape with index `shape_index`, or of an instance of it if `instance` is not null.
AreaLight make_area_light(const ShapeRow& shape, std::uint32_t shape_index, const ShapeTables& tables,
                          const AreaEmission& emission, const LightTableOffsets& offsets,
                          const LightInstance* instance);

/// Sets the members of `light` that depend on the kind of shape.
void complete_mesh_light(AreaLight& light, const ShapeRow& shape, std::uint32_t shape_index, const ShapeTables& tables,
                         const LightTableOffsets& offsets, const LightInstance* instance);
/// Makes a mesh light a rectangle light if its triangles form a rectangle.
void complete_rectangle_light(AreaLight& light);
void complete_quadric_light(AreaLight& light, const ShapeRow& shape, std::uint32_t shape_index,
                            const ShapeTables& tables, const LightTableOffsets& offsets, const LightInstance* instance);

}  // namespace sheaf
