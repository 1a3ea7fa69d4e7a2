#include "tests/support/tiny_scenes.h"

#include <utility>

namespace sheaf {

Description empty_scene(int width, int height) {
  Description d;
  d.camera.fov = 90;
  d.film.width = width;
  d.film.height = height;
  d.sampler.sample_count = 1;
  return d;
}

void look_at(Description& d, Vec3f origin, Vec3f target, Vec3f up, float fov) {
  d.camera.to_world = Transform::look_at(origin, target, up);
  d.camera.fov = fov;
}

MaterialId add_material(Description& d, const decltype(MaterialDescription::model)& model) {
  MaterialDescription material;
  material.model = model;
  d.materials.push_back(std::move(material));
  return static_cast<MaterialId>(d.materials.size() - 1);
}

TextureId add_checkerboard(Description& d, Vec3f first, Vec3f second) {
  const auto rgb = [](Vec3f v) { return SpectrumDescription{SpectrumDescription::Rgb{v}}; };
  TextureDescription texture;
  texture.model = CheckerboardDescription{rgb(first), rgb(second)};
  d.textures.push_back(texture);
  return static_cast<TextureId>(d.textures.size() - 1);
}

ShapeDescription& add_shape(Description& d, const decltype(ShapeDescription::geometry)& geometry,
                            const Transform& to_world, std::optional<MaterialId> material) {
  ShapeDescription shape;
  shape.geometry = geometry;
  shape.to_world = to_world;
  shape.material = material;
  d.shapes.push_back(std::move(shape));
  return d.shapes.back();
}

MaterialId add_diffuse(Description& d, float reflectance) {
  return add_material(d, DiffuseDescription{SpectrumDescription::constant(reflectance)});
}

MaterialId add_diffuse_rgb(Description& d, float r, float g, float b) {
  return add_material(d, DiffuseDescription{SpectrumDescription::rgb(r, g, b)});
}

MaterialId add_mirror(Description& d, float reflectance) {
  ConductorDescription mirror;
  mirror.specular_reflectance = SpectrumDescription::constant(reflectance);
  return add_material(d, mirror);
}

MaterialId add_glass(Description& d, float int_ior, float ext_ior) {
  DielectricDescription glass;
  glass.int_ior = int_ior;
  glass.ext_ior = ext_ior;
  return add_material(d, glass);
}

MaterialId add_two_sided(Description& d, MaterialId side) { return add_material(d, TwoSidedDescription{side, side}); }

ShapeDescription& add_sphere(Description& d, Vec3f center, float radius, std::optional<MaterialId> material) {
  return add_shape(d, SphereShape{center, radius}, Transform(), material);
}

ShapeDescription& add_rectangle(Description& d, const Transform& to_world, std::optional<MaterialId> material) {
  return add_shape(d, RectangleShape{}, to_world, material);
}

ShapeDescription& emit(ShapeDescription& shape, float radiance) {
  shape.radiance = SpectrumDescription::constant(radiance);
  return shape;
}

ShapeDescription& add_area_light_rectangle(Description& d, const Transform& to_world, float radiance) {
  const MaterialId black = add_diffuse(d, 0);
  return emit(add_rectangle(d, to_world, black), radiance);
}

ShapeDescription& add_area_light_sphere(Description& d, Vec3f center, float radius, float radiance) {
  const MaterialId black = add_diffuse(d, 0);
  return emit(add_sphere(d, center, radius, black), radiance);
}

void add_point_light(Description& d, Vec3f position, float intensity) {
  d.lights.push_back({PointLightDescription{position, SpectrumDescription::constant(intensity)}, {}});
}

void add_constant_light(Description& d, float radiance) {
  d.lights.push_back({ConstantLightDescription{SpectrumDescription::constant(radiance)}, {}});
}

}  // namespace sheaf
