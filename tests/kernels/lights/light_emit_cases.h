// Lights of every kind in small scenes, with receivers on which their emission is compared.
#pragma once

#include "core/image/exr.h"
#include "tests/support/light_testing.h"
#include "tests/support/media_testing.h"
#include "tests/support/records_testing.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_scenes.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

namespace sheaf::test_light_emit {

/// A one-sided disk that receives light.
struct Receiver {
  Vec3f center, normal;
  float radius;
};

/// A scene with lights, and the receivers on which their emission is compared.
struct Case {
  std::string name;
  Description scene;
  Receiver receivers[2];
  double power_error = 1e-4;  ///< relative error of light_power(): quadrature over areas, cones and textures
  bool convex = false;        ///< a single convex area light, whose photons hit nothing
  std::uint32_t photons = 150000;
};

inline SpectrumDescription rgb(Vec3f value) { return SpectrumDescription{SpectrumDescription::Rgb{value}}; }

inline const Transform kTilt = Transform::translate({0.3f, -0.2f, 3}) * Transform::rotate({1, 2, 0.5f}, 155);
/// For lights around kTilt: one receiver in front and one far to the side.
inline const Receiver kBelow{{0, 0, 0.2f}, normalize(Vec3f{0.1f, -0.3f, 1}), 1.5f};
inline const Receiver kAside{{2.5f, -1, 1}, normalize(Vec3f{-1, 0.2f, 0.3f}), 1.5f};

/// Triangles of very different areas in different planes.
inline Mesh uneven_mesh() {
  Mesh mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0.2f}, {-1, 1, 0.1f}, {1.5f, 1.2f, -0.6f}, {1.6f, 1.0f, -0.6f}};
  mesh.triangles = {{0, 1, 2}, {2, 1, 3}, {3, 1, 4}};
  return mesh;
}

template <class Geometry>
inline Case area_case(const std::string& name, Geometry geometry, const Transform& to_world, bool convex = false) {
  Case c{name, empty_scene(4, 4), {kBelow, kAside}, 1e-4, convex};
  add_shape(c.scene, std::move(geometry), to_world).radiance = rgb({1, 2, 0.5f});
  return c;
}

inline Case flipped(Case c) {
  c.name += ", flipped";
  c.scene.shapes[0].flip_normals = true;
  c.convex = false;
  return c;
}

inline Case textured(Case c) {
  c.name += ", textured";
  c.scene.shapes[0].radiance = add_checkerboard(c.scene, {6, 1, 0}, {2, 3, 1});
  c.power_error = 1e-2;
  return c;
}

/// Spheres, rectangles, cylinders and a textured disk in a group, with a stretched and a mirrored instance.
inline Case instanced_case() {
  Case c{"instances", empty_scene(4, 4), {kBelow, kAside}, 1e-2};
  ShapeGroup group;
  Description shapes;
  emit(add_sphere(shapes, {0.4f, 0, 0}, 0.2f), 3);
  emit(add_rectangle(shapes, Transform::translate({0, 0.6f, 0}) * Transform::scale({0.3f, 0.2f, 1})), 5);
  emit(add_shape(shapes, CylinderShape{{-0.5f, 0, 0}, {-0.4f, 0.3f, 0.1f}, 0.1f}, Transform()), 2);
  add_shape(shapes, DiskShape{}, Transform::translate({0, -0.5f, 0}) * Transform::scale({0.3f, 0.3f, 1})).radiance =
      add_checkerboard(c.scene, {8, 1, 1}, {2, 3, 1});
  group.shapes = shapes.shapes;
  c.scene.groups.push_back(group);
  for (const Transform& transform : {kTilt, Transform::translate({1, 0, 3}) * Transform::rotate({1, 1, 0}, 150) *
                                                Transform::scale({-1.2f, 0.7f, 0.9f})}) {
    InstanceDescription instance;
    for (std::size_t i = 0; i < 12; ++i) instance.to_world[i] = transform.matrix().m[i / 4][i % 4];
    c.scene.instances.push_back(instance);
  }
  return c;
}

inline std::vector<Case> area_cases() {
  const Transform stretched = kTilt * Transform::scale({0.5f, 1, 0.8f});
  const auto cylinder = CylinderShape{{0, -0.5f, 0}, {0, 0.7f, 0}, 0.5f};
  const Receiver inside[2] = {{{0.3f, 0, 3}, {0, 0, 1}, 0.4f},
                              {{0.3f, -0.4f, 2.8f}, normalize(Vec3f{1, -1, 0.5f}), 0.5f}};
  std::vector<Case> cases = {
      area_case("rectangle", RectangleShape{}, stretched, true),
      area_case("mirrored rectangle", RectangleShape{}, kTilt * Transform::scale({-1, 1, 1}), true),
      area_case("mesh", uneven_mesh(), kTilt),
      area_case("cube", CubeShape{}, kTilt * Transform::rotate({1, 1, 0}, 35), true),
      area_case("disk", DiskShape{}, stretched, true),
      area_case("cylinder", cylinder, stretched, true),
      area_case("sphere", SphereShape{{0.1f, 0, 0}, 0.8f}, kTilt, true),
      area_case("ellipsoid", SphereShape{}, stretched, true),
      flipped(area_case("rectangle", RectangleShape{}, kTilt * Transform::rotate({1, 0, 0}, 180))),
      flipped(area_case("sphere", SphereShape{{0, 0, 0}, 1.2f}, kTilt)),
      flipped(area_case("mirrored cylinder", cylinder, kTilt * Transform::scale({-2, 2, 2}))),
      textured(area_case("cube", CubeShape{}, kTilt)),
      textured(area_case("sphere", SphereShape{}, kTilt)),
      textured(area_case("ellipsoid", SphereShape{}, stretched)),
      textured(area_case("disk", DiskShape{}, stretched)),
      textured(area_case("cylinder", cylinder, kTilt)),
      instanced_case()};
  for (const std::size_t k : {9, 10}) std::copy_n(inside, 2, cases[k].receivers);
  return cases;
}

template <class Model> Case placed_case(const std::string& name, Model model, double power_error = 1e-4) {
  Case c{name, empty_scene(4, 4), {kBelow, kAside}, power_error};
  add_sphere(c.scene, {0.2f, 0.3f, 0.5f}, 3);  // a bounding sphere that contains the receivers
  c.scene.lights.push_back({std::move(model), {"scene.xml", 9}});
  return c;
}

using Falloff = SpotLightDescription::Falloff;

inline SpotLightDescription spot_of(Falloff falloff, const Transform& to_world, float cutoff, float beam) {
  SpotLightDescription spot;
  spot.falloff = falloff;
  spot.to_world = to_world;
  spot.intensity = rgb({3, 1, 2});
  spot.cutoff_angle = cutoff;
  spot.beam_width = beam;
  return spot;
}

inline std::vector<Case> spot_cases() {
  using enum SpotLightDescription::Falloff;
  const Transform stretched = kTilt * Transform::scale({-2, 0.6f, 1});
  std::vector<Case> cases = {placed_case("spot", spot_of(kLinear, kTilt, 50, 20)),
                             placed_case("narrow spot", spot_of(kLinear, kTilt * Transform::scale({2, 2, 2}), 5, 3)),
                             placed_case("wide spot", spot_of(kLinear, kTilt, 180, 30)),
                             placed_case("smooth spot", spot_of(kSmooth, kTilt, 50, 20)),
                             placed_case("wide smooth spot", spot_of(kSmooth, kTilt, 140, 20)),
                             // light_power() does not support stretched spot lights.
                             placed_case("stretched spot", spot_of(kLinear, stretched, 50, 30), 1)};
  const Vec3f axis = kTilt.vector({0, 0, -1});
  cases[1].receivers[0] = {kTilt.point({0, 0, 2}), normalize(axis + Vec3f{0.5f, 0, 0}), 0.1f};
  cases[1].receivers[1] = {kTilt.point({0.1f, 0, 1.5f}), axis, 0.15f};
  Case c = placed_case("textured spot", spot_of(kLinear, kTilt, 40, 20), 1e-2);
  std::get<SpotLightDescription>(c.scene.lights[0].model).texture = add_checkerboard(c.scene, {6, 1, 0}, {2, 3, 1});
  cases.push_back(c);
  return cases;
}

inline ProjectorDescription projector_of() {
  ProjectorDescription projector;
  projector.to_world = kTilt * Transform::scale({-2, 2, 2});
  projector.irradiance = rgb({3, 1, 2});
  projector.fov = 70;
  return projector;
}

inline EnvmapDescription envmap_of(const TemporaryFolder& folder, bool compensated) {
  Image image(12, 8, {"R", "G", "B"});
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 12; ++x) {
      image.at(x, y, 0) = x == 4 && y == 2 ? 20.0f : 0.2f * static_cast<float>(x % 4);
      image.at(x, y, 1) = x > 6 && y > 3 ? 0.0f : 0.5f;
      image.at(x, y, 2) = 0.1f * static_cast<float>(y);
    }
  write_exr(folder / "map.exr", image, {});
  return {folder / "map.exr", 1.5f, Transform::rotate({1, 2, 3}, 70) * Transform::scale({-2, 2, 2}), compensated};
}

inline SunDescription sun_of(float radius) {
  SunDescription sun;
  sun.direction = normalize(Vec3f{-0.4f, 0.5f, 1});
  sun.scale = 1e-3f;
  sun.radius = radius;
  return sun;
}

/// A goniometric light whose image differs along all axes.
inline Case goniometric_case() {
  GoniometricLightDescription light;
  light.to_world = kTilt * Transform::scale({-2, 2, 2});
  light.intensity = rgb({3, 1, 2});
  Case c = placed_case("goniometric", light, 1e-2);
  auto image = std::make_shared<Image>(4, 4, std::vector<std::string>{"Y"});
  for (std::size_t i = 0; i < 16; ++i) image->data[i] = 0.1f + 0.3f * static_cast<float>((5 * i) % 16);
  BitmapDescription bitmap;
  bitmap.made = image;
  bitmap.filter = TextureFilter::kNearest;
  c.scene.textures.push_back({bitmap, {1, 0, 0, 0, 1, 0}, {}, {}});
  return c;
}

/// Two-sided area lights; the second receiver faces their back.
inline std::vector<Case> two_sided_cases() {
  const Receiver behind{{0.6f, -0.4f, 6}, normalize(Vec3f{0.1f, -0.3f, -1}), 1.5f};
  std::vector<Case> cases = {area_case("two-sided rectangle", RectangleShape{}, kTilt),
                             area_case("two-sided mesh", uneven_mesh(), kTilt),
                             textured(area_case("two-sided disk", DiskShape{}, kTilt))};
  for (Case& c : cases) {
    c.scene.shapes[0].emits_on_both_sides = true;
    c.receivers[1] = behind;
  }
  return cases;
}

/// Lights that are not shapes. Environment maps read their file when the scene is compiled.
inline std::vector<Case> placed_cases(const TemporaryFolder& folder) {
  const auto color = rgb({3, 1, 2});
  std::vector<Case> cases = {placed_case("point", PointLightDescription{{0.3f, -0.2f, 3}, color}),
                             placed_case("projector", projector_of()),
                             placed_case("directional", DirectionalLightDescription{{0.4f, 0.1f, -1}, color}),
                             placed_case("sun", sun_of(8)),
                             placed_case("constant", ConstantLightDescription{color}),
                             placed_case("envmap", envmap_of(folder, false), 1e-3),
                             placed_case("compensated envmap", envmap_of(folder, true), 1e-3)};
  for (std::size_t k = 2; k < 7; ++k) cases[k].photons = 500000;
  cases[6].photons = 2000000;  // few photons carry much flux
  Case c = placed_case("textured projector", projector_of(), 1e-2);
  std::get<ProjectorDescription>(c.scene.lights[0].model).irradiance = add_checkerboard(c.scene, {6, 1, 0}, {2, 3, 1});
  cases.push_back(c);
  ProjectorDescription even = projector_of();
  even.constant_intensity = true;
  cases.push_back(placed_case("even projector", even, 1e-3));
  c.name = "textured even projector";
  std::get<ProjectorDescription>(c.scene.lights[0].model).constant_intensity = true;
  cases.push_back(c);
  cases.push_back(goniometric_case());
  for (Case& spot : spot_cases()) cases.push_back(std::move(spot));
  return cases;
}

/// An emissive medium that fills the cubes to which `transforms` transform [-1, 1]^3, and so their bounding boxes.
inline Case medium_case(const std::string& name, MediumDescription medium, const std::vector<Transform>& transforms) {
  Case c{name, empty_scene(4, 4), {kBelow, kAside}, 1e-4};
  medium.emission = VolumeInput(rgb({1, 2, 0.5f}));
  const MediumId id = add_medium(c.scene, std::move(medium));
  for (const Transform& transform : transforms) fill(c.scene, add_shape(c.scene, CubeShape{}, transform), id);
  return c;
}

inline const Transform kBox = Transform::translate({0.3f, -0.2f, 3}) * Transform::scale({0.5f, 1, 0.8f});

/// A medium whose extinction increases along all axes of kBox.
inline MediumDescription uneven_fog(const TemporaryFolder& folder) {
  MediumDescription medium = fog(2, 0.25f);
  const auto density = [](Vec3f p, int) { return 0.1f + p.x + 3 * p.y * p.z; };
  medium.density = vol(write_vol(folder / "density.vol", 6, 1, density),
                       kBox * Transform::translate({-1, -1, -1}) * Transform::scale({2, 2, 2}));
  return medium;
}

inline std::vector<Case> medium_cases(const TemporaryFolder& folder) {
  const Transform aside = Transform::translate({-1.5f, 0.5f, 2.5f}) * Transform::scale({0.3f, 0.3f, 0.3f});
  return {medium_case("homogeneous medium", fog(2, 0.25f), {kBox}),
          medium_case("homogeneous medium in two places", fog(2, 0.25f), {kBox, aside}),
          medium_case("heterogeneous medium", uneven_fog(folder), {kBox})};
}

/// Lights of every kind in one scene.
inline Case mixed_case(const TemporaryFolder& folder) {
  Case c = instanced_case();
  c.name = "many";
  c.photons = 500000;
  c.scene.shapes = area_case("", uneven_mesh(), kTilt * Transform::translate({0, 1, 0})).scene.shapes;
  add_sphere(c.scene, {0.2f, 0.3f, 0.5f}, 3);  // as in placed_case()
  for (const Case& other : spot_cases()) c.scene.lights.push_back(other.scene.lights[0]);
  std::get<SpotLightDescription>(c.scene.lights.back().model).texture = TextureId{0};
  c.scene.lights.push_back({projector_of(), {}});
  add_point_light(c.scene, {0, 1, 2}, 3);
  c.scene.lights.push_back({DirectionalLightDescription{{0.4f, 0.1f, -1}, SpectrumDescription::constant(0.2f)}, {}});
  c.scene.lights.push_back({sun_of(5), {}});
  c.scene.lights.push_back({envmap_of(folder, true), {}});
  const Case medium = medium_cases(folder).back();
  c.scene.media = medium.scene.media;
  fill(c.scene, add_shape(c.scene, CubeShape{}, kBox), MediumId{0});
  return c;
}

}  // namespace sheaf::test_light_emit
