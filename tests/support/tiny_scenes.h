// Scenes of a few shapes, built in memory: what tests of kernels and estimators render.
#pragma once

#include "scene/description/description.h"

#include <utility>

namespace sheaf {

/// Nothing but a camera at the origin that looks along +z with +y up (field of view 90 degrees across x), a box
/// filter, one sample per pixel and unlimited depth.
inline Description empty_scene(int width, int height) {
  Description d;
  d.camera.fov = 90;
  d.film.width = width;
  d.film.height = height;
  d.sampler.sample_count = 1;
  return d;
}

/// Moves the camera.
inline void look_at(Description& d, Vec3f origin, Vec3f target, Vec3f up = {0, 1, 0}, float fov = 90) {
  d.camera.to_world = Transform::look_at(origin, target, up);
  d.camera.fov = fov;
}

template <class Model> MaterialId add_material(Description& d, Model model) {
  MaterialDescription material;
  material.model = std::move(model);
  d.materials.push_back(std::move(material));
  return static_cast<MaterialId>(d.materials.size() - 1);
}

inline MaterialId add_diffuse(Description& d, float reflectance) {
  return add_material(d, DiffuseDescription{SpectrumDescription::constant(reflectance)});
}

inline MaterialId add_diffuse_rgb(Description& d, float r, float g, float b) {
  return add_material(d, DiffuseDescription{SpectrumDescription::rgb(r, g, b)});
}

/// A perfect mirror on the side of the normal.
inline MaterialId add_mirror(Description& d, float reflectance = 1) {
  ConductorDescription mirror;
  mirror.specular_reflectance = SpectrumDescription::constant(reflectance);
  return add_material(d, mirror);
}

/// A smooth dielectric of index `int_ior` in a surrounding of index `ext_ior`.
inline MaterialId add_glass(Description& d, float int_ior = 1.5f, float ext_ior = 1) {
  DielectricDescription glass;
  glass.int_ior = int_ior;
  glass.ext_ior = ext_ior;
  return add_material(d, glass);
}

/// The same material on both sides.
inline MaterialId add_two_sided(Description& d, MaterialId side) {
  return add_material(d, TwoSidedDescription{side, side});
}

/// Adds a shape and returns it for further changes; the reference holds until the next shape.
template <class Geometry>
ShapeDescription& add_shape(Description& d, Geometry geometry, const Transform& to_world,
                            std::optional<MaterialId> material = {}) {
  ShapeDescription shape;
  shape.geometry = std::move(geometry);
  shape.to_world = to_world;
  shape.material = material;
  d.shapes.push_back(std::move(shape));
  return d.shapes.back();
}

inline ShapeDescription& add_sphere(Description& d, Vec3f center, float radius,
                                    std::optional<MaterialId> material = {}) {
  return add_shape(d, SphereShape{center, radius}, Transform(), material);
}

/// [-1, 1]^2 in the xy plane with normal +z, placed by `to_world`.
inline ShapeDescription& add_rectangle(Description& d, const Transform& to_world,
                                       std::optional<MaterialId> material = {}) {
  return add_shape(d, RectangleShape{}, to_world, material);
}

/// Turns a shape into an area light of constant radiance, emitting on the side of its normals.
inline ShapeDescription& emit(ShapeDescription& shape, float radiance) {
  shape.radiance = SpectrumDescription::constant(radiance);
  return shape;
}

/// A rectangle, placed as by add_rectangle, that emits on the side of its normal and reflects nothing.
inline ShapeDescription& add_area_light_rectangle(Description& d, const Transform& to_world, float radiance) {
  const MaterialId black = add_diffuse(d, 0);
  return emit(add_rectangle(d, to_world, black), radiance);
}

/// A sphere that emits outwards and reflects nothing.
inline ShapeDescription& add_area_light_sphere(Description& d, Vec3f center, float radius, float radiance) {
  const MaterialId black = add_diffuse(d, 0);
  return emit(add_sphere(d, center, radius, black), radiance);
}

inline void add_point_light(Description& d, Vec3f position, float intensity) {
  d.lights.push_back({PointLightDescription{position, SpectrumDescription::constant(intensity)}, {}});
}

inline void add_constant_light(Description& d, float radiance) {
  d.lights.push_back({ConstantLightDescription{SpectrumDescription::constant(radiance)}, {}});
}

}  // namespace sheaf
