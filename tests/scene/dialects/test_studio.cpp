// The studio around models without cameras and lights: framing, backdrop and lights.
#include "scene/compile/compile.h"
#include "scene/dialects/read_model.h"
#include "tests/support/files/gltf_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace sheaf::test_studio {

using namespace test;

namespace {

using Points = std::vector<Vec3d>;

/// The vertices of models of several shapes: a cube, a rod, a plate, a flat square, a cone and a segment of a ball.
std::vector<Points> models() {
  const auto block = [](double x, double y, double z) {
    Points points;
    for (int i = 0; i < 8; ++i) points.emplace_back(i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? z : -z);
    return points;
  };
  Points cone{{0, 2, 0}}, ball;
  for (int i = 0; i < 40; ++i) {
    const double a = i * 0.157;
    cone.emplace_back(std::cos(a), 0, std::sin(a));
    for (int j = 0; j < 10; ++j)
      ball.emplace_back(std::cos(a) * std::cos(0.15 * j), std::sin(a) * std::cos(0.15 * j), std::sin(0.15 * j));
  }
  return {block(1, 1, 1), block(0.05, 3, 0.05), block(4, 0.1, 1), block(1, 0, 1), cone, ball};
}

/// The text of a PLY file: a fan of triangles over all vertices, scaled and then moved.
std::string ply_text(const Points& points, double scale = 1, double offset = 0) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      points.size(), points.size() - 2);
  for (const Vec3d p : points)
    text += fmt::format("{} {} {}\n", p.x * scale + offset, p.y * scale + offset, p.z * scale + offset);
  for (std::size_t i = 2; i < points.size(); ++i) text += fmt::format("3 0 {} {}\n", i - 1, i);
  return text;
}

Description read_ply(const std::string& text, const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  return read_scene(write_below(folder, "model.ply", text), options);
}

/// The part of the image that points fill, along x and y, and how far their center is from that of the image.
struct Filled {
  double x, y, shift_x, shift_y;
};

Filled filled(const Points& points, const Description& d, double aspect_ratio) {
  const Matrix4 to_camera = d.camera.to_world.inverse_matrix();
  const double tangent = std::tan(double{d.camera.fov} * 3.14159265358979 / 360);
  const double tx = tangent * std::max(aspect_ratio, 1.0), ty = tangent * std::max(1 / aspect_ratio, 1.0);
  double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
  for (const Vec3d p : points) {
    std::array<double, 3> c{};
    for (std::size_t i = 0; i < 3; ++i)
      c[i] = to_camera.m[i][0] * p.x + to_camera.m[i][1] * p.y + to_camera.m[i][2] * p.z + to_camera.m[i][3];
    REQUIRE(c[2] > 0);
    const double at[2] = {c[0] / c[2] / tx, c[1] / c[2] / ty};
    for (int k = 0; k < 2; ++k) low[k] = std::min(low[k], at[k]), high[k] = std::max(high[k], at[k]);
  }
  return {(high[0] - low[0]) / 2, (high[1] - low[1]) / 2, (high[0] + low[0]) / 2, (high[1] + low[1]) / 2};
}

struct Triangle {
  Vec3d a, b, c;
};

/// Triangles in world space of the added shapes whose names contain `name`.
std::vector<Triangle> added_triangles(const Description& d, const std::string& name) {
  std::vector<Triangle> out;
  for (const ShapeDescription& shape : d.shapes) {
    if (!contains(shape.id, "studio_" + name)) continue;
    const auto at = [&](Vec3d p) { return shape.to_world.precise_point(p); };
    if (const auto* mesh = std::get_if<Mesh>(&shape.geometry)) {
      for (const auto& t : mesh->triangles)
        out.push_back({at(mesh->positions[t[0]]), at(mesh->positions[t[1]]), at(mesh->positions[t[2]])});
    } else {
      REQUIRE(std::holds_alternative<RectangleShape>(shape.geometry));
      out.push_back({at({-1, -1, 0}), at({1, -1, 0}), at({1, 1, 0})});
      out.push_back({at({-1, -1, 0}), at({1, 1, 0}), at({-1, 1, 0})});
    }
  }
  return out;
}

/// Distance to the first triangle along a ray, in units of the direction's length (Moeller and Trumbore 1997).
std::optional<double> hit(const std::vector<Triangle>& triangles, Vec3d origin, Vec3d direction) {
  std::optional<double> nearest;
  for (const Triangle& t : triangles) {
    const Vec3d e1 = t.b - t.a, e2 = t.c - t.a, p = cross(direction, e2), s = origin - t.a, q = cross(s, e1);
    const double determinant = dot(e1, p);
    if (determinant == 0) continue;
    const double u = dot(s, p) / determinant, v = dot(direction, q) / determinant, far = dot(e2, q) / determinant;
    if (u >= -1e-9 && v >= -1e-9 && u + v <= 1 + 1e-9 && far > 0 && (!nearest || far < *nearest)) nearest = far;
  }
  return nearest;
}

/// The direction to a position in the image, each coordinate from -1 to 1.
Vec3d ray_direction(const Description& d, double aspect_ratio, double x, double y) {
  const double tangent = std::tan(double{d.camera.fov} * 3.14159265358979 / 360);
  const Matrix4& m = d.camera.to_world.matrix();
  const double at[3] = {x * tangent * std::max(aspect_ratio, 1.0), y * tangent * std::max(1 / aspect_ratio, 1.0), 1};
  const auto row = [&](std::size_t i) { return m.m[i][0] * at[0] + m.m[i][1] * at[1] + m.m[i][2] * at[2]; };
  return {row(0), row(1), row(2)};
}

ReadOptions view_options(ModelView::Up up, float azimuth, float elevation, float fov, double aspect_ratio) {
  ReadOptions options;
  options.view = {up, azimuth, elevation, fov, aspect_ratio};
  return options;
}

const char* const kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

Description read_triangle(const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  return read_scene(write_below(folder, "model.obj", kTriangle), options);
}

Description read_document(const GltfBuilder& gltf, const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  return read_scene(write_below(folder, "model.gltf", gltf.text()), options);
}

std::vector<std::string> added_names(const Description& d) {
  std::vector<std::string> names;
  for (const ShapeDescription& shape : d.shapes)
    if (shape.id.starts_with("studio_")) names.push_back(shape.id);
  for (const LightDescription& light : d.lights) names.push_back(light.id);
  return names;
}

}  // namespace

TEST_CASE("studio: models of any shape fill two thirds of the image along one axis, in the middle") {
  for (const Points& points : models())
    for (const double aspect_ratio : {4.0 / 3, 21.0 / 9, 0.5})
      for (const float fov : {5.0f, 35.0f, 50.0f})
        for (const float elevation : {-60.0f, 0.0f, 20.0f, 90.0f}) {
          CAPTURE(points.size());
          CAPTURE(aspect_ratio);
          CAPTURE(fov);
          CAPTURE(elevation);
          const Description d =
              read_ply(ply_text(points), view_options(ModelView::Up::kY, 40, elevation, fov, aspect_ratio));
          const Filled part = filled(points, d, aspect_ratio);
          CHECK(std::max(part.x, part.y) == near(2.0 / 3, 1e-3));
          const bool is_wide = part.x > part.y;
          CHECK(std::abs(is_wide ? part.shift_x : part.shift_y) < 1e-3);
          CHECK(std::abs(is_wide ? part.shift_y : part.shift_x) < 0.25);
        }
}

TEST_CASE("studio: the picture does not depend on the size and the place of a model") {
  const Points cube = models()[0];
  const Description d = read_ply(ply_text(cube));
  const double scale = length(d.camera.to_world.translation());
  for (const auto& placed : {std::pair{1e-3, 0.0}, {1e5, 0.0}, {1.0, 1e4}, {1e-3, 0.5}, {1e5, 1e7}}) {
    const double size = placed.first, offset = placed.second;
    CAPTURE(size);
    CAPTURE(offset);
    const Description other = read_ply(ply_text(cube, size, offset));
    CHECK(compile_scene(other)->info().triangles == compile_scene(d)->info().triangles);
    REQUIRE(other.shapes.size() == d.shapes.size());
    // Positions of single precision limit the accuracy
    const double tolerance = 1e-5 + 1e-6 * offset / size;
    const auto check = [&](const Transform& to_world, const Transform& expected) {
      const Vec3d place = (to_world.translation() - Vec3d{offset, offset, offset}) * (1 / size);
      CHECK(length(place - expected.translation()) < tolerance * scale);
    };
    check(other.camera.to_world, d.camera.to_world);
    for (std::size_t i = 1; i < d.shapes.size(); ++i) { check(other.shapes[i].to_world, d.shapes[i].to_world); }
  }
}

TEST_CASE("studio: from every direction the backdrop covers the image, behind the model, and no light is seen") {
  const std::vector<Points> shapes = models();
  std::size_t turn = 0;
  for (const auto up : {ModelView::Up::kX, ModelView::Up::kY, ModelView::Up::kZ})
    for (const float elevation : {-90.0f, -30.0f, 0.0f, 20.0f, 55.0f, 90.0f})
      for (const float fov : {2.0f, 35.0f, 100.0f, 165.0f})
        for (const double aspect_ratio : {4.0 / 3, 3.0, 0.4}) {
          const Points& points = shapes[turn++ % shapes.size()];
          CAPTURE(elevation);
          CAPTURE(fov);
          CAPTURE(aspect_ratio);
          CAPTURE(points.size());
          const Description d =
              read_ply(ply_text(points), view_options(up, static_cast<float>(turn) * 17, elevation, fov, aspect_ratio));
          const std::vector<Triangle> backdrop = added_triangles(d, "backdrop"), all = added_triangles(d, "");
          REQUIRE(all.size() == backdrop.size() + 6);
          const Vec3d eye = d.camera.to_world.translation();
          for (int i = -5; i <= 5; ++i)
            for (int k = -5; k <= 5; ++k) {
              const Vec3d direction = ray_direction(d, aspect_ratio, i * 0.2, k * 0.2);
              const std::optional<double> wall = hit(backdrop, eye, direction);
              REQUIRE(wall);
              CHECK(*hit(all, eye, direction) == *wall);
            }
          for (const Vec3d p : points) {
            const std::optional<double> covered = hit(all, eye, p - eye);
            REQUIRE(covered);
            CHECK(*covered > 1);
          }
        }
}

TEST_CASE("studio: instances are framed as copies of their meshes") {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"translation", {3, 1, 0}}}};
  gltf.json["scenes"][0]["nodes"] = {0, 1};
  const Description d = read_document(gltf);
  REQUIRE(d.instances.size() == 2);
  const Points points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {3, 1, 0}, {4, 1, 0}, {3, 2, 0}};
  const Filled part = filled(points, d, 4.0 / 3);
  CHECK(std::max(part.x, part.y) == near(2.0 / 3, 1e-3));
}

TEST_CASE("studio: each studio adds its lights, and environments and missing floors choose another one") {
  using Names = std::vector<std::string>;
  const Names soft{"studio_backdrop", "studio_key", "studio_fill", "studio_rim", "studio_sky"};
  const Names sun{"studio_floor", "studio_sky", "studio_sun"}, none{"studio_sky", "studio_sun"};
  ReadOptions options;
  CHECK(added_names(read_triangle(options)) == soft);
  CHECK(has_studio(read_triangle(options)));
  options.surroundings.default_studio = Studio::kSun;
  CHECK(added_names(read_triangle(options)) == sun);
  for (const auto& [studio, names] : {std::pair{Studio::kSoft, soft}, {Studio::kSun, sun}, {Studio::kNone, none}}) {
    options.surroundings.studio = studio;
    CHECK(added_names(read_triangle(options)) == names);
  }
  options.surroundings = {};
  options.surroundings.floor = false;
  CHECK(added_names(read_triangle(options)) == none);
  options.surroundings = {};
  options.surroundings.environment = "sky.exr";
  CHECK(added_names(read_triangle(options)) == Names{"studio_floor", "studio_sky"});
  options.surroundings.environment = ModelEnvironment::kNoEnvironment;
  CHECK(added_names(read_triangle(options)) == Names{"studio_floor"});
  // A floor would hide the model from below
  options.surroundings = {};
  options.surroundings.studio = Studio::kSun;
  options.view.elevation = -10;
  CHECK(added_names(read_triangle(options)) == none);
}

TEST_CASE("studio: models with cameras or lights of their own keep them") {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}}};
  gltf.json["nodes"].push_back({{"camera", 0}, {"translation", {0, 0, 5}}});
  gltf.json["scenes"][0]["nodes"].push_back(1);
  const Description d = read_document(gltf);
  CHECK_FALSE(has_studio(d));
  CHECK(d.shapes.size() == 1);
  CHECK(d.notes.empty());
  ReadOptions options;
  options.surroundings.studio = Studio::kSoft;
  const Description also = read_document(gltf, options);
  CHECK(dump(also) == dump(d));
  REQUIRE(also.notes.size() == 1);
  CHECK(contains(also.notes[0], "has a camera or lights of its own (--studio ignored)"));
}

}  // namespace sheaf::test_studio
