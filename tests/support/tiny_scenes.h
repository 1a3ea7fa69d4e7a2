// Scenes of a few shapes, built in memory, for tests of kernels and estimators.
#pragma once

#include "scene/description.h"

#include <optional>

namespace sheaf {

/// An empty scene with a camera at the origin that looks along +z with +y up (field of view 90 degrees across x), a box
/// filter, one sample per pixel and unlimited depth.
Description empty_scene(int width, int height);

/// Moves the camera.
void look_at(Description& d, Vec3f origin, Vec3f target, Vec3f up = {0, 1, 0}, float fov = 90);

MaterialId add_material(Description& d, const decltype(MaterialDescription::model)& model);

MaterialId add_diffuse(Description& d, float reflectance);

MaterialId add_diffuse_rgb(Description& d, float r, float g, float b);

/// A perfect mirror that reflects on the side of the normal.
MaterialId add_mirror(Description& d, float reflectance = 1);

/// A smooth dielectric with index `int_ior` inside and `ext_ior` outside.
MaterialId add_glass(Description& d, float int_ior = 1.5f, float ext_ior = 1);

/// The same material on both sides.
MaterialId add_two_sided(Description& d, MaterialId side);

/// A checkerboard texture of two RGB colors.
TextureId add_checkerboard(Description& d, Vec3f first, Vec3f second);

/// Adds a shape and returns it for further changes. The reference is valid until the next shape is added.
ShapeDescription& add_shape(Description& d, const decltype(ShapeDescription::geometry)& geometry,
                            const Transform& to_world, std::optional<MaterialId> material = {});

ShapeDescription& add_sphere(Description& d, Vec3f center, float radius, std::optional<MaterialId> material = {});

/// [-1, 1]^2 in the xy plane with normal +z, placed by `to_world`.
ShapeDescription& add_rectangle(Description& d, const Transform& to_world, std::optional<MaterialId> material = {});

/// Turns a shape into an area light of constant radiance, emitting on the side of its normals.
ShapeDescription& emit(ShapeDescription& shape, float radiance);

/// A rectangle, placed as by add_rectangle(), that emits on the side of its normal and reflects nothing.
ShapeDescription& add_area_light_rectangle(Description& d, const Transform& to_world, float radiance);

/// A sphere that emits outwards and reflects nothing.
ShapeDescription& add_area_light_sphere(Description& d, Vec3f center, float radius, float radiance);

void add_point_light(Description& d, Vec3f position, float intensity);

void add_constant_light(Description& d, float radiance);

}  // namespace sheaf
