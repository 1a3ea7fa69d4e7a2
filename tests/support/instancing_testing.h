// Instances of shape groups, built in memory: placement transforms and shapes of every kind.
#pragma once

#include "tests/support/tiny_scenes.h"

#include <string>
#include <vector>

namespace sheaf {

/// Shears each axis along another.
inline Transform shear() {
  Matrix4 m;
  m.m[0][1] = 0.7;
  m.m[1][2] = -0.4;
  m.m[2][0] = 0.3;
  return Transform(m);
}

struct NamedTransform {
  std::string name;
  Transform to_world;
};
/// One transform of each class.
inline const NamedTransform kPlacements[] = {
    {"identity", Transform()},
    {"moved", Transform::translate({2, -1, 5}) * Transform::rotate({1, 2, 3}, 70)},
    {"scaled", Transform::translate({-1, 0.5f, 2}) * Transform::scale({3, 3, 3})},
    {"stretched",
     Transform::rotate({3, 1, -2}, 40) * Transform::scale({2, 0.4f, 1.1f}) * Transform::rotate({1, 0, 1}, 25)},
    {"mirrored", Transform::translate({1, 2, 3}) * Transform::rotate({1, 1, 0}, 30) * Transform::scale({-1, 1, 1})},
    {"mirrored thrice", Transform::scale({-1.5f, -0.7f, -1})},
    {"sheared", Transform::translate({0, 1, 0}) * shear()},
    {"sheared and mirrored", shear() * Transform::scale({1, 1, -2})},
};

/// A bent square with vertex normals and texture coordinates.
inline Mesh smooth_mesh() {
  Mesh mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0.3f}, {1, 1, 0}, {-1, 1, -0.2f}};
  mesh.normals = {{-0.3f, -0.3f, 1}, {0.4f, -0.2f, 1}, {0.1f, 0.3f, 1}, {-0.2f, 0.3f, 1}};
  mesh.uvs = {{0.1f, 0.1f}, {0.9f, 0.2f}, {1, 1.3f}, {-0.2f, 0.8f}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

/// Every kind of shape, at different positions around the origin, with `materials` in turn. All meshes have vertex
/// normals, which decide the side of their triangles. Without them the vertex order decides, which mirrored copies
/// keep.
inline std::vector<ShapeDescription> every_kind(const std::vector<MaterialId>& materials) {
  const auto at = [](float x, float y, float z) {
    return Transform::translate({x, y, z}) * Transform::rotate({1, 2, -1}, 35) * Transform::scale({0.9f, 0.6f, 0.8f});
  };
  Description all;
  add_shape(all, SphereShape{}, at(-1.5f, -1.5f, 0));
  add_shape(all, DiskShape{}, at(1.5f, -1.5f, 0));
  add_shape(all, CylinderShape{}, at(0, -1.5f, 1.5f));
  add_shape(all, RectangleShape{}, at(-1.5f, 1.5f, 0));
  add_shape(all, CubeShape{}, at(1.5f, 1.5f, 0));
  add_shape(all, smooth_mesh(), at(0, 1.5f, -1.5f));
  add_shape(all, SphereShape{{0.2f, 0, 0}, 0.5f}, at(0, 0, 0)).flip_normals = true;
  add_shape(all, smooth_mesh(), at(0, 1.5f, 1.5f)).flip_normals = true;
  for (std::size_t i = 0; i < all.shapes.size() && !materials.empty(); ++i)
    all.shapes[i].material = materials[i % materials.size()];
  return all.shapes;
}

/// Adds an instance of the group with this index.
inline void add_instance(Description& d, std::uint32_t group, const Transform& to_world) {
  InstanceDescription instance;
  instance.group = group;
  for (std::size_t i = 0; i < 12; ++i) instance.to_world[i] = to_world.matrix().m[i / 4][i % 4];
  d.instances.push_back(instance);
}

/// Adds a group and returns its index.
inline std::uint32_t add_group(Description& d, std::vector<ShapeDescription> shapes) {
  d.groups.push_back({std::move(shapes), {}, {}});
  return static_cast<std::uint32_t>(d.groups.size() - 1);
}

/// Adds `shapes` transformed by `to_world`, which look like an instance of their group.
inline void add_copies(Description& d, const std::vector<ShapeDescription>& shapes, const Transform& to_world) {
  for (ShapeDescription shape : shapes) {
    shape.to_world = to_world * shape.to_world;
    d.shapes.push_back(shape);
  }
}

}  // namespace sheaf
