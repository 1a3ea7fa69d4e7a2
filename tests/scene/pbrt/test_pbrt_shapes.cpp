// Shapes of pbrt: parameters, texture coordinates of spheres, curves, and the media on both sides.
#include "scene/compile/compile.h"
#include "scene/surfaces/shape.h"
#include "tests/support/near.h"
#include "tests/support/pbrt_testing.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace sheaf::test_pbrt_shapes {

using namespace test;

TEST_CASE("pbrt: shapes have the documented parameters") {
  const Description d = read_pbrt_world(R"(Shape "sphere" "float phimax" 90
Shape "disk" "float innerradius" 0.5
Shape "bilinearmesh" "point3 P" [ 0 0 0  1 0 0  0 1 0  1 1 1 ]
Shape "bilinearmesh" "point3 P" [ 0 0 0  1 0 0  0 1 0  1 1 0 ]
Scale 1 1 -1
Shape "trianglemesh" "point3 P" [ 0 0 0  1 0 0  0 1 0 ]
Shape "trianglemesh" "point3 P" [ 0 0 0  1 0 0  0 1 0 ] "normal N" [ 0 0 1 0 0 1 0 0 1 ])");
  const auto area = [&](std::size_t shape) {
    double sum = 0;
    const Mesh& mesh = std::get<Mesh>(d.shapes.at(shape).geometry);
    for (const auto& t : mesh.triangles)
      sum += 0.5 * static_cast<double>(length(cross(mesh.positions[t[1]] - mesh.positions[t[0]],
                                                    mesh.positions[t[2]] - mesh.positions[t[0]])));
    return sum;
  };
  CHECK(area(0) == near(3.14159265, 0.002));
  CHECK(area(1) == near(3.14159265 * 0.75, 0.002));
  CHECK(std::get<Mesh>(d.shapes[2].geometry).triangles.size() > 100);
  CHECK(std::get<Mesh>(d.shapes[3].geometry).triangles.size() == 2);
  CHECK(area(3) == near(1));
  CHECK(d.shapes[4].flip_normals);
  CHECK(!d.shapes[5].flip_normals);
}

TEST_CASE("pbrt: textured spheres have v from the lower end up and face outwards") {
  const Description d = read_pbrt_world(R"(Texture "t" "spectrum" "checkerboard"
Material "diffuse" "texture reflectance" "t" Translate 1 2 3 Shape "sphere" "float radius" 2)");
  const auto scene = compile_scene(d);
  const SceneView& view = scene->view();
  for (const float polar : {0.3f, 1.2f, 2.0f, 2.9f})  // angle from +z
    for (const float azimuth : {0.4f, 2.0f, 4.0f, 6.0f}) {
      const Vec3f n{std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar)};
      const auto y =
          surface_point<Scalar, true>(view, view.geometry.shapes[0], 0, 0, 0, Vec3f{1, 2, 3} + n * 2.0f, kNone, 0.0f);
      CHECK(y.uv.x == near(static_cast<double>(azimuth) / (2 * std::numbers::pi), 1e-4));
      CHECK(y.uv.y == near(1 - static_cast<double>(polar) / std::numbers::pi, 1e-4));
      CHECK(length(y.ng - n) < 1e-4f);
    }
}

TEST_CASE("pbrt: curves become B-spline tubes of the same shape") {
  const auto curves = [](const std::string& parameters) {
    return std::get<Curves>(read_pbrt_world("Shape \"curve\" " + parameters).shapes.at(0).geometry);
  };
  // The point of a segment at t and its radius: a weighted sum of four control points.
  const auto at = [](const Curves& c, std::size_t first, float t) {
    const float s = 1 - t;
    const float w[] = {s * s * s / 6, (4 - 6 * t * t + 3 * t * t * t) / 6, (4 - 6 * s * s + 3 * s * s * s) / 6,
                       t * t * t / 6};
    Curves::Point out{};
    for (std::size_t k = 0; k < 4; ++k) {
      out.position = out.position + c.points.at(first + k).position * w[k];
      out.radius += c.points[first + k].radius * w[k];
    }
    return out;
  };
  const Curves cubic = curves(R"("point3 P" [ 0 0 0  1 2 0  3 0 1  4 4 4 ] "float width0" 0.4 "float width1" 0)");
  REQUIRE(cubic.points.size() == 4);
  CHECK(cubic.basis == Curves::Basis::kBspline);
  for (const float t : {0.0f, 0.3f, 1.0f}) {
    const float s = 1 - t;
    const Vec3f expected =
        Vec3f{1, 2, 0} * (3 * s * s * t) + Vec3f{3, 0, 1} * (3 * s * t * t) + Vec3f{4, 4, 4} * (t * t * t);
    CHECK(length(at(cubic, 0, t).position - expected) < 1e-5f);
    CHECK(at(cubic, 0, t).radius == near(0.2 * (1 - t), 1e-5));
  }
  const Curves quadratic =
      curves(R"("point3 P" [ 0 0 0  1 2 0  2 0 0  3 -2 0  4 0 0 ] "integer degree" 2 "float width" 0.5)");
  CHECK(quadratic.starts == std::vector<std::uint32_t>{0, 4});
  CHECK(length(at(quadratic, 0, 0.5f).position - Vec3f{1, 1, 0}) < 1e-5f);
  CHECK(length(at(quadratic, 4, 0.5f).position - Vec3f{3, -1, 0}) < 1e-5f);
  CHECK(at(quadratic, 4, 0.5f).radius == near(0.25));
  const std::string points = R"("point3 P" [ 0 0 0  1 2 0  2 0 0  3 -2 0  4 0 0 ] "string basis" "bspline")";
  const Curves spline = curves(points + " \"float width1\" 3");
  CHECK(spline.starts.size() == 1);
  REQUIRE(spline.points.size() == 5);
  CHECK(spline.points[1].position == Vec3f{1, 2, 0});
  CHECK(at(spline, 0, 0).radius == near(0.5));
  CHECK(at(spline, 1, 0).radius == near(1));
  CHECK(at(spline, 1, 1).radius == near(1.5));
  // A quadratic B-spline passes the middle between control points where segments meet.
  const Curves smooth = curves(points + " \"integer degree\" 2");
  CHECK(smooth.starts.size() == 3);
  CHECK(length(at(smooth, 4, 0).position - Vec3f{1.5f, 1, 0}) < 1e-5f);
  CHECK(length(at(smooth, 4, 0.5f).position - Vec3f{2, 0, 0}) < 1e-5f);
}

TEST_CASE("pbrt: curves with the same material and attributes become one shape") {
  const std::string curve =
      "Shape \"curve\" \"point3 P\" [ 0 0 0  1 2 0  3 0 1  4 4 4 ] \"string type\" \"cylinder\"\n";
  const Description d =
      read_pbrt_world(curve + "AttributeBegin Scale 2 2 2\n" + curve + "AttributeEnd\nMaterial \"hair\"\n" + curve);
  REQUIRE(d.shapes.size() == 2);
  const Curves& two = std::get<Curves>(d.shapes[0].geometry);
  CHECK(two.starts == std::vector<std::uint32_t>{0, 4});
  CHECK(two.points[0].radius == 0.5f);
  CHECK(two.points[4].radius == near(1));
  CHECK(two.points[5].position.x == near(2 * two.points[1].position.x));
  CHECK(d.notes.empty());
  CHECK(model_of<HairDescription>(d, *d.shapes[1].material) != nullptr);
  const std::string board =
      "Texture \"t\" \"spectrum\" \"checkerboard\"\nMaterial \"diffuse\" \"texture reflectance\" \"t\"\n";
  CHECK(read_pbrt_world(board + curve + curve).shapes.size() == 2);
  const std::string flat = "Shape \"curve\" \"point3 P\" [ 0 0 0  1 2 0  3 0 1  4 4 4 ]\n";
  const std::vector<std::string> notes = read_pbrt_world(flat + flat).notes;
  REQUIRE(notes.size() == 1);
  CHECK(contains(notes[0], "type 'flat' rendered as a round tube"));
  CHECK(contains(error_of_pbrt_world("Shape \"curve\""), "has 0 points, expected 4 or more"));
  CHECK(contains(error_of_pbrt_world("Shape \"curve\" \"point3 P\" [ 0 0 0 1 0 0 2 0 0 3 0 0 4 0 0 ]"),
                 "1 and a multiple"));
  CHECK(contains(
      error_of_pbrt_world("Shape \"curve\" \"point3 P\" [ 0 0 0 1 0 0 2 0 0 3 0 0 ] \"string type\" \"round\""),
      "expected flat"));
  CHECK(contains(error_of_pbrt_world("AreaLightSource \"diffuse\"\n" + flat), "light of curves: not supported"));
}

TEST_CASE("pbrt: media lie inside and outside shapes and equal media need no boundary") {
  const Description d =
      read_pbrt_world(R"(MakeNamedMedium "fog" "string type" "homogeneous" "string preset" "Skin1" "float g" 0.5
MediumInterface "fog" "" Shape "sphere"
MediumInterface "fog" Shape "sphere"
MediumInterface "" "fog" Material "interface" Shape "sphere")",
                      "MakeNamedMedium \"air\" \"string type\" \"homogeneous\"\n"
                      "MediumInterface \"\" \"air\" Camera \"perspective\"");
  CHECK(d.media.size() == 2);
  CHECK(static_cast<int>(*d.camera.medium) == 0);
  CHECK(static_cast<int>(*d.shapes[0].interior) == 1);
  CHECK(!d.shapes[0].exterior);
  CHECK(!d.shapes[1].interior);
  CHECK(static_cast<int>(*d.shapes[2].exterior) == 1);
  CHECK(std::get<HenyeyGreensteinDescription>(d.phases[0].model).g == 0.5f);
}

}  // namespace sheaf::test_pbrt_shapes
