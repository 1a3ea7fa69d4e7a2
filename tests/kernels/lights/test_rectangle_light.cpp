// Rectangle lights: which meshes become one, and directions against the pdf that MIS uses, with and without a normal
// at the receiver.
#include "scene/lights/rectangle_light.h"

#include "kernels/stages/light_sample_context.h"
#include "scene/compile/compile.h"
#include "tests/support/chi_square.h"
#include "tests/support/light_testing.h"
#include "tests/support/near.h"
#include "tests/support/records_testing.h"
#include "tests/support/tiny_scenes.h"
#include "tests/support/trace_testing.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace sheaf::test_rectangle_light {

namespace {

/// Two triangles of the given corners.
Mesh two_triangles(const std::array<Vec3f, 4>& p, std::array<std::uint32_t, 3> a, std::array<std::uint32_t, 3> b) {
  Mesh mesh;
  mesh.positions.assign(p.begin(), p.end());
  mesh.triangles = {a, b};
  return mesh;
}

std::unique_ptr<Scene> lone_light(Mesh mesh, const Transform& to_world = {}) {
  Description d = empty_scene(4, 4);
  emit(add_shape(d, std::move(mesh), to_world), 1);
  return compile_scene(d);
}

bool is_rectangle(const Scene& scene) { return scene.view().lights.rows[0].is(kLightKind<RectangleLightKind>); }

constexpr std::array<Vec3f, 4> kCorners = {{{-1, -0.5f, 0}, {1, -0.5f, 0}, {1, 0.5f, 0}, {-1, 0.5f, 0}}};

/// Both triangles, with their vertices in any order.
constexpr std::array<std::uint32_t, 3> kFirst[] = {{0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
constexpr std::array<std::uint32_t, 3> kSecond[] = {{0, 3, 2}, {3, 2, 0}, {2, 0, 3}};

/// The pdf with which sample_given_light() returns a point of the light.
float pdf_at(const SceneView& scene, const LightSampleContext<Scalar>& from, Vec3f point) {
  const LightRow& light = scene.lights.rows[0];
  const Vec3f to = point - from.p, ng = scene.lights.triangles[light.data<MeshLightData>().first_triangle].normal;
  return light_pdf_solid_angle<Scalar>(scene, 0u, light, true, {from.p, normalize(to), length(to), ng, 0u, from.n},
                                       0.0f);
}

/// Where the light is seen from.
struct Receiver {
  const char* name;
  LightSampleContext<Scalar> at;
};

/// The light spans [-1, 1] x [-0.5, 0.5] at z = 0 and emits towards -z.
const std::vector<Receiver> kReceivers = {{"in front, without a normal", {{0.2f, 0.1f, -1}, {}}},
                                          {"in front", {{0.2f, 0.1f, -1}, {0, 0, 1}}},
                                          {"on a wall beside it", {{1.2f, 0, -0.3f}, {-1, 0, 0}}},
                                          {"on a wall that it intersects", {{0.3f, 0.2f, -0.4f}, {0.6f, 0.8f, 0}}},
                                          {"facing away", {{0.2f, 0.1f, -1}, {0.36f, 0.48f, -0.8f}}},
                                          {"very near", {{0.9f, -0.45f, -0.01f}, {0.6f, 0, 0.8f}}},
                                          {"far away", {{3, 2, -40}, {0, 0.6f, 0.8f}}}};

}  // namespace

TEST_CASE("rectangle lights: two triangles that form a rectangle become one, in any order of their vertices") {
  const auto expected = lone_light(two_triangles(kCorners, kFirst[0], kSecond[0]));
  for (const auto& a : kFirst)
    for (const auto& b : kSecond) {
      const auto scene = lone_light(two_triangles(kCorners, a, b));
      REQUIRE(is_rectangle(*scene));
      const auto& light = scene->view().lights.rows[0];
      CHECK(light.data<RectangleLightData>().mesh.area == near(2));
      CHECK(pdf_at(scene->view(), kReceivers[1].at, {0.5f, 0.2f, 0}) ==
            near(pdf_at(expected->view(), kReceivers[1].at, {0.5f, 0.2f, 0})));
    }
  const Transform tilted = Transform::translate({50, -20, 3}) * Transform::rotate({1, 2, 0.5f}, 155);
  CHECK(is_rectangle(*lone_light(two_triangles(kCorners, kFirst[1], kSecond[2]), tilted)));
}

TEST_CASE("rectangle lights: other meshes do not become one") {
  std::array<Vec3f, 4> corners = kCorners;
  const auto &a = kFirst[0], &b = kSecond[0];
  CHECK_FALSE(is_rectangle(*lone_light(two_triangles(kCorners, a, {0, 2, 3}))));  // faces the other way
  CHECK_FALSE(is_rectangle(*lone_light(two_triangles(kCorners, a, a))));
  corners[3].x += 0.01f;
  CHECK_FALSE(is_rectangle(*lone_light(two_triangles(corners, a, b))));
  corners = kCorners;
  corners[3].z += 0.01f;  // bent
  CHECK_FALSE(is_rectangle(*lone_light(two_triangles(corners, a, b))));
  const Transform shear =
      Transform::rotate({0, 0, 1}, 30) * Transform::scale({1, 3, 1}) * Transform::rotate({0, 0, 1}, 30);
  CHECK_FALSE(is_rectangle(*lone_light(two_triangles(kCorners, a, b), shear)));
}

TEST_CASE("rectangle lights: samples follow the pdf that MIS uses, and lie on the light") {
  const auto scene = lone_light(two_triangles(kCorners, kFirst[0], kSecond[0]));
  REQUIRE(is_rectangle(*scene));
  const SceneView view = scene->view();
  constexpr int kCells = 10, kDraws = 100000, kSteps = 24;
  for (const Receiver& receiver : kReceivers) {
    CAPTURE(receiver.name);
    const auto& from = receiver.at;
    const auto cell_of = [](double x, double y) {
      const int column = std::clamp(static_cast<int>((x + 1) / 2 * kCells), 0, kCells - 1);
      const int row = std::clamp(static_cast<int>((y + 0.5) * kCells), 0, kCells - 1);
      return static_cast<std::size_t>(row * kCells + column);
    };
    std::vector<double> observed(kCells * kCells), expected(kCells * kCells);
    double worst = 0, worst_height = 0;
    int invalid = 0;
    for (std::uint32_t i = 0; i < kDraws; ++i) {
      const auto s = sample_given_light<Scalar>(view, from, view.lights.rows[0], random4<Scalar>(6, i, 0, 0));
      invalid += !s.valid;
      worst_height = std::max(worst_height, std::fabs(double(s.target.z)));
      worst = std::max(worst, std::fabs(double(pdf_at(view, from, s.target)) / s.pdf_solid_angle - 1));
      observed[cell_of(double(s.target.x), double(s.target.y))] += 1;
    }
    CHECK(invalid == 0);
    CHECK(worst < 5e-3);
    CHECK(worst_height < 1e-5);
    // Integrate the pdf over each cell
    constexpr int kPoints = kCells * kSteps;
    double integral = 0;
    for (int row = 0; row < kPoints; ++row)
      for (int column = 0; column < kPoints; ++column) {
        const double x = -1 + 2 * (column + 0.5) / kPoints, y = -0.5 + (row + 0.5) / kPoints;
        const Vec3f point{static_cast<float>(x), static_cast<float>(y), 0};
        const Vec3f to = point - from.p;
        const double distance = double(length(to)), solid_angle = std::fabs(double(to.z)) / std::pow(distance, 3);
        const double fraction = double(pdf_at(view, from, point)) * solid_angle * 2 / (double(kPoints) * kPoints);
        integral += fraction;
        expected[cell_of(x, y)] += fraction * kDraws;
      }
    CHECK(integral == near(1, 2e-3));
    CHECK(chi_square(observed, expected).p_value > significance_of_each(static_cast<int>(kReceivers.size())));
  }
}

TEST_CASE("rectangle lights: surfaces are sampled nearly in proportion to the cosine") {
  const auto scene = lone_light(two_triangles(kCorners, kFirst[0], kSecond[0]));
  const SceneView view = scene->view();
  const LightSampleContext<Scalar> wall = kReceivers[2].at;
  MeanVariance with_normal, without;
  for (std::uint32_t i = 0; i < 20000; ++i)
    for (const bool knows : {false, true}) {
      const LightSampleContext<Scalar> from{wall.p, knows ? wall.n : Vec3f{}};
      const auto s = sample_given_light<Scalar>(view, from, view.lights.rows[0], random4<Scalar>(7, i, 0, 0));
      (knows ? with_normal : without).add(double(dot(s.direction, wall.n)) / s.pdf_solid_angle);
    }
  CHECK(with_normal.mean() == near(without.mean(), 0.02));
  CHECK(with_normal.variance() < 0.5 * without.variance());
}

TEST_CASE("rectangle lights: points on the light sample it by area") {
  const auto scene = lone_light(two_triangles(kCorners, kFirst[0], kSecond[0]));
  const SceneView view = scene->view();
  for (const float z : {0.0f, -1e-7f}) {
    const LightSampleContext<Scalar> from{{0.1f, 0.1f, z}, {0, 0, 1}};
    for (std::uint32_t i = 0; i < 200; ++i) {
      const auto s = sample_given_light<Scalar>(view, from, view.lights.rows[0], random4<Scalar>(8, i, 0, 0));
      // By angle, the pdf would be about 1 / (2 pi)
      CHECK((!s.valid || s.pdf_solid_angle > 10));
    }
  }
}

TEST_CASE("rectangle lights: textures are looked up where rays that hit the light look them up") {
  for (const auto& a : kFirst)
    for (const auto& b : kSecond) {
      Mesh mesh = two_triangles(kCorners, a, b);
      mesh.uvs = {{0, 0}, {0.9f, 0.1f}, {1, 0.7f}, {0.2f, 1}};
      mesh.attributes.push_back({"vertex_value", 1, {1, 2, 4, 3}});
      Description d = empty_scene(4, 4);
      const TextureId board = add_checkerboard(d, {6, 1, 1}, {2, 3, 1});
      d.textures.push_back({MeshAttributeDescription{"vertex_value", 1}, {1, 0, 0, 0, 1, 0}, "", {}});
      d.textures.push_back({ProductTextureDescription{board, TextureId{1}}, {1, 0, 0, 0, 1, 0}, "", {}});
      add_shape(d, std::move(mesh), {}).radiance = TextureId{2};
      const auto scene = compile_scene(d);
      REQUIRE(is_rectangle(*scene));
      const SceneView view = scene->view();
      const LightRow& light = view.lights.rows[0];
      int differs = 0;
      for (std::uint32_t i = 0; i < 500; ++i) {
        const Vec3f from = kReceivers[1].at.p;
        const auto s = sample_given_light<Scalar>(view, {from, {}}, light, random4<Scalar>(9, i, 0, 0));
        const auto hit = trace_ray(view, from, s.direction);
        REQUIRE(hit);
        const auto y = surface_at(view, from, s.direction, *hit);
        const Spectrum4 seen =
            light.radiance *
            light_textures<Scalar>(view, light.texture, true, {y.uv, hit->shape, hit->primitive, hit->u, hit->v});
        differs += record_difference<Spectrum>(s.radiance, seen) > 1e-4;
      }
      CHECK(differs <= 5);  // at the edges of the board
    }
}

}  // namespace sheaf::test_rectangle_light
