// The point relative to which scenes far from the origin are rendered, and what their readers keep of positions.
#include "scene/compile/compile.h"
#include "scene/compile/render_origin.h"
#include "tests/support/files/gltf_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"
#include "tests/support/pbrt_testing.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace sheaf::test_render_origin {

using namespace test;

namespace {

/// A place as in UTM coordinates, m. Floats are multiples of 0.5 there.
constexpr Vec3d kPosition{500000.125, 40, -5400000.375};

std::string text_of(Vec3d v) { return std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z); }

/// The vertex of the first mesh of a scene, relative to Scene::origin().
Vec3f first_vertex(const Scene& scene) {
  const SceneView& view = scene.view();
  return view.geometry.vertices[view.geometry.shapes[0].first_vertex].position;
}

/// Where the first vertex of a compiled scene is.
Vec3d first_vertex_in_world(const Description& d) {
  const auto scene = compile_scene(d);
  CHECK(scene->origin() != Vec3d());
  return Vec3d(first_vertex(*scene)) + scene->origin();
}

void check_equal(Vec3d found, Vec3d expected, double distance) {
  CAPTURE(text_of(found));
  CHECK(length(found - expected) <= distance);
}

}  // namespace

TEST_CASE("render origin: only scenes that lie far away in relation to the distance of the camera have one") {
  const std::vector<Vec3d> points{{0, 0, 0}, {3, 4, 0}};
  for (const double scale : {1e-6, 1.0, 1e6}) {
    CAPTURE(scale);
    const auto origin = [&](Vec3d offset) {
      std::vector<Vec3d> moved;
      for (const Vec3d p : points) moved.push_back((p + offset) * scale);
      return render_origin((Vec3d{0, 5, 0} + offset) * scale, moved);
    };
    CHECK(origin({0, 0, 0}) == Vec3d());
    CHECK(origin({0, 100, 0}) == Vec3d());
    const Vec3d far{1e5, -2e6, 3e7};
    CHECK(length(origin(far) - far * scale) < 16 * scale);
  }
  CHECK(render_origin({1e9, 0, 0}, {}) == Vec3d());
}

TEST_CASE("render origin: a camera that moves a little keeps the origin") {
  const std::vector<Vec3d> points{kPosition};
  const Vec3d camera = kPosition + Vec3d{0.3, 9, 0.2};
  const Vec3d origin = render_origin(camera, points);
  CHECK(origin != Vec3d());
  CHECK(render_origin(camera + Vec3d{0.05, 0.1, -0.1}, points) == origin);
}

TEST_CASE("render origin: Mitsuba's transforms keep positions far from the origin") {
  const auto scene = [](const std::string& to_world) {
    const std::string at = text_of(kPosition + Vec3d{0, 0, 5});
    return mitsuba_scene("<shape type='rectangle'><transform name='to_world'>" + to_world + "</transform></shape>",
                         "<sensor type='perspective'><transform name='to_world'><lookat origin='" + at + "' target='" +
                             text_of(kPosition) + "' up='0, 1, 0'/></transform></sensor>");
  };
  const Vec3d corner = kPosition + Vec3d{-1, -1, 0};
  const auto check = [&](const std::string& to_world) {
    check_equal(first_vertex_in_world(read_text(scene(to_world))), corner, 1e-5);
  };
  check("<translate value='" + text_of(kPosition) + "'/>");
  check("<matrix value='1 0 0 " + std::to_string(kPosition.x) + " 0 1 0 " + std::to_string(kPosition.y) + " 0 0 1 " +
        std::to_string(kPosition.z) + " 0 0 0 1'/>");
  // A rotation by an angle that floats do not hold, there and back
  check("<translate value='" + text_of(kPosition) + "'/><rotate y='1' angle='33.3'/><rotate y='1' angle='-33.3'/>");
}

TEST_CASE("render origin: Mitsuba's points keep positions far from the origin") {
  const Vec3d camera = kPosition + Vec3d{0, 0, 5};
  const std::string sensor = "<sensor type='perspective'><transform name='to_world'><lookat origin='" +
                             text_of(camera) + "' target='" + text_of(kPosition) +
                             "' up='0, 1, 0'/></transform></sensor>";
  const std::string center = "<point name='center' value='" + text_of(kPosition) + "'/>";
  const auto sphere = compile_scene(read_text(mitsuba_scene("<shape type='sphere'>" + center + "</shape>", sensor)));
  const float* m = sphere->view().geometry.quadrics[0].to_world;
  check_equal(Vec3d(m[3], m[7], m[11]) + sphere->origin(), kPosition, 1e-5);
  const std::string ends = "<point name='p0' value='" + text_of(kPosition) + "'/><point name='p1' value='" +
                           text_of(kPosition + Vec3d{0, 0.25, 0}) + "'/>";
  const auto tube = compile_scene(read_text(mitsuba_scene("<shape type='cylinder'>" + ends + "</shape>", sensor)));
  m = tube->view().geometry.quadrics[0].to_world;
  check_equal(Vec3d(m[3], m[7], m[11]) + tube->origin(), kPosition, 1e-5);
  CHECK(double{m[6]} == near(0.25));
  const std::string light =
      "<emitter type='point'><point name='position' value='" + text_of(kPosition) + "'/></emitter>";
  const auto lamp =
      compile_scene(read_text(mitsuba_scene("<shape type='sphere'>" + center + "</shape>" + light, sensor)));
  const auto& row = lamp->view().lights.rows[0];
  check_equal(Vec3d(PointLightKind::position(row)) + lamp->origin(), kPosition, 1e-5);
}

TEST_CASE("render origin: pbrt's transforms keep positions far from the origin") {
  const auto numbers = [](Vec3d v) {
    return std::to_string(v.x) + " " + std::to_string(v.y) + " " + std::to_string(v.z) + " ";
  };
  const std::string camera =
      "LookAt " + numbers(kPosition + Vec3d{0, 0, 5}) + numbers(kPosition) + "0 1 0 Camera \"perspective\"";
  const std::string shape = "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [0 0 0 1 0 0 0 1 0]\n";
  check_equal(first_vertex_in_world(read_pbrt_world("Translate " + numbers(kPosition) + shape, camera)), kPosition,
              1e-5);
  const std::string object =
      "ObjectBegin \"o\"\n" + shape + "ObjectEnd\nTranslate " + numbers(kPosition) + "ObjectInstance \"o\"";
  const auto instanced = compile_scene(read_pbrt_world(object, camera));
  const float* m = instanced->view().geometry.instances[0].to_world;
  check_equal(Vec3d(m[3], m[7], m[11]) + instanced->origin(), kPosition, 1e-5);
}

TEST_CASE("render origin: nodes of glTF keep positions far from the origin") {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}}};
  gltf.json["nodes"].push_back({{"camera", 0}, {"translation", {0, 0, 5}}});
  gltf.json["nodes"].push_back({{"children", {0, 1}}, {"translation", {kPosition.x, kPosition.y, kPosition.z}}});
  gltf.json["scenes"][0]["nodes"] = {2};
  const TemporaryFolder folder;
  const Description d = read_scene(write_below(folder, "scene.gltf", gltf.text()));
  check_equal(first_vertex_in_world(d), kPosition, 1e-5);
  check_equal(d.camera.to_world.translation(), kPosition + Vec3d{0, 0, 5}, 1e-9);
}

TEST_CASE("render origin: skins of glTF keep positions far from the origin") {
  GltfBuilder gltf;
  nlohmann::json& primitive = gltf.add_triangle();
  primitive["attributes"]["JOINTS_0"] = gltf.add<std::uint8_t>(std::vector<std::uint8_t>(12, 0), "VEC4");
  primitive["attributes"]["WEIGHTS_0"] = gltf.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  gltf.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}}};
  gltf.json["skins"] = {{{"joints", {1}}}};
  gltf.json["nodes"][0]["skin"] = 0;
  gltf.json["nodes"].push_back({{"translation", {0.5, 0, 0}}});
  gltf.json["nodes"].push_back({{"camera", 0}, {"translation", {0, 0, 5}}});
  gltf.json["nodes"].push_back({{"children", {1, 2}}, {"translation", {kPosition.x, kPosition.y, kPosition.z}}});
  gltf.json["scenes"][0]["nodes"] = {0, 3};
  const TemporaryFolder folder;
  const Description d = read_scene(write_below(folder, "scene.gltf", gltf.text()));
  check_equal(first_vertex_in_world(d), kPosition + Vec3d{0.5, 0, 0}, 1e-5);
}

TEST_CASE("render origin: everything that has a place moves") {
  const Vec3d by{1000, -2000, 3000};
  const auto check_moved = [&](const Transform& moved) { check_equal(moved.translation(), -by, 1e-9); };
  Description d;
  d.more_cameras.emplace_back();
  d.camera.target = Vec3d{1, 2, 3};
  d.more_cameras[0].target = CameraDescription::TargetArea{};
  d.shapes.emplace_back();
  d.groups.push_back({{ShapeDescription{}}, {}, {}});
  d.instances.emplace_back();
  d.motions.push_back(AnimatedTransform({{0, Transform()}, {1, Transform::translate({5, 0, 0})}}));
  // All grids of media, phase functions and textures
  const GridVolumeDescription grid;
  d.media.resize(2);
  d.media[0].coefficients = ExtinctionAlbedoDescription{grid, grid};
  d.media[1].coefficients = AbsorptionScatteringDescription{grid, grid};
  d.media[0].density = d.media[0].emission_factor = d.media[0].temperature = grid;
  d.media[0].emission = grid;
  d.phases.push_back({SggxDescription{grid}, {}});
  d.textures.emplace_back();
  d.textures[0].model = VolumeTextureDescription{grid};
  d.lights = {{PointLightDescription{}, {}},
              {SpotLightDescription{}, {}},
              {GoniometricLightDescription{}, {}},
              {ProjectorDescription{}, {}},
              {BeamDescription{}, {}}};
  const Description moved = moved_to(d, by);
  check_moved(moved.camera.to_world);
  check_moved(moved.more_cameras[0].to_world);
  check_equal(std::get<Vec3d>(moved.camera.target), Vec3d{1, 2, 3} - by, 1e-9);
  check_moved(std::get<CameraDescription::TargetArea>(moved.more_cameras[0].target).to_world);
  check_moved(moved.shapes[0].to_world);
  CHECK(moved.groups[0].shapes[0].to_world.translation() == Vec3d());
  const std::array<double, 12>& m = moved.instances[0].to_world;
  check_equal({m[3], m[7], m[11]}, -by, 1e-9);
  check_equal(moved.motions[0].at(1).translation(), Vec3d{5, 0, 0} - by, 1e-9);
  const auto& extinction = std::get<ExtinctionAlbedoDescription>(moved.media[0].coefficients);
  const auto& scattering = std::get<AbsorptionScatteringDescription>(moved.media[1].coefficients);
  for (const VolumeInput* input :
       {&extinction.sigma_t, &extinction.albedo, &scattering.sigma_a, &scattering.sigma_s, &*moved.media[0].emission})
    check_moved(std::get<GridVolumeDescription>(*input).to_world);
  for (const auto* optional : {&moved.media[0].density, &moved.media[0].emission_factor, &moved.media[0].temperature})
    check_moved((*optional)->to_world);
  const auto& flakes = std::get<SggxDescription>(moved.phases[0].model);
  check_moved(std::get<GridVolumeDescription>(flakes.matrix).to_world);
  check_moved(std::get<VolumeTextureDescription>(moved.textures[0].model).grid.to_world);
  // Every light that is not at infinity
  for (const LightDescription& light : moved.lights)
    std::visit(
        [&](const auto& model) {
          if constexpr (requires { model.to_world; }) check_moved(model.to_world);
          if constexpr (requires { model.position; }) check_equal(model.position, -by, 1e-9);
          CHECK((
              requires { model.to_world; } || requires { model.position; }));
        },
        light.model);
}

TEST_CASE("render origin: a mesh file whose vertices lie far away gets one, and a note on lost digits") {
  const TemporaryFolder folder;
  write_below(folder, "far.obj", "v 500000 40 0\nv 500001 40 0\nv 500000 41 0\nf 1 2 3\n");
  const std::string text = mitsuba_scene(
      "<shape type='obj'><string name='filename' value='far.obj'/></shape>",
      "<sensor type='perspective'><transform name='to_world'><lookat origin='500000, 40, 5' target='500000, 40, 0' "
      "up='0, 1, 0'/></transform></sensor>");
  const auto scene = compile_scene(read_scene(write_below(folder, "scene.xml", text)));
  CHECK(scene->origin() != Vec3d());
  check_equal(Vec3d(first_vertex(*scene)) + scene->origin(), {500000, 40, 0}, 1e-5);
  check_equal(scene->info().bounds_max, {500001, 41, 0}, 1e-5);
  const auto is_note = [](const std::string& w) { return w.find("multiples of 0.0312") != w.npos; };
  CHECK(std::count_if(scene->warnings().begin(), scene->warnings().end(), is_note) == 1);
}

TEST_CASE("render origin: meshes with all their digits get no note") {
  const TemporaryFolder folder;
  write_below(folder, "a.obj", "v 100 40 0\nv 101 40 0\nv 100 41 0\nf 1 2 3\n");
  const std::string text = mitsuba_scene("<shape type='obj'><string name='filename' value='a.obj'/></shape>");
  const auto scene = compile_scene(read_scene(write_below(folder, "scene.xml", text)));
  CHECK(scene->warnings().empty());
}

}  // namespace sheaf::test_render_origin
