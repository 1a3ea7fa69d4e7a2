// glTF nodes: hierarchies, instances, skins, morph targets, animation, cameras and lights.
#include "scene/compile/compile.h"
#include "tests/support/files/gltf_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_gltf_nodes {

using namespace test;
using nlohmann::json;

namespace {

constexpr double kTolerance = 1e-5;

Description read_document(const GltfBuilder& gltf, const ReadOptions& options = {}) {
  const TemporaryFolder folder;
  return read_scene(write_below(folder, "model.gltf", gltf.text()), options);
}
Description at_time(const GltfBuilder& gltf, double time, const std::string& animation = {}) {
  ReadOptions options;
  options.moment = {time, animation};
  return read_document(gltf, options);
}

void check_near(Vec3f a, Vec3f b) {
  CAPTURE(a.x);
  CAPTURE(a.y);
  CAPTURE(a.z);
  CHECK(length(a - b) < kTolerance * (1 + length(b)));
}

/// World position of a vertex of the first shape.
Vec3f vertex(const Description& d, std::size_t i) {
  const ShapeDescription& shape = d.shapes.front();
  return shape.to_world.point(std::get<Mesh>(shape.geometry).positions[i]);
}

/// A triangle whose node moves by keys.
GltfBuilder animated(const char* path, const std::vector<float>& times, const std::vector<float>& values,
                     const char* type, const char* interpolation) {
  GltfBuilder gltf;
  gltf.add_triangle();
  const int input = gltf.add<float>(times, "SCALAR"), output = gltf.add<float>(values, type);
  gltf.json["animations"].push_back(
      {{"name", "walk"},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}}},
       {"samplers", {{{"input", input}, {"output", output}, {"interpolation", interpolation}}}}});
  return gltf;
}

}  // namespace

TEST_CASE("gltf: transforms of parents apply to children") {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.json["nodes"][0]["scale"] = {2, 3, 4};
  const double half = std::sqrt(0.5);
  gltf.json["nodes"].push_back({{"rotation", {0, 0, half, half}}, {"translation", {10, 0, 0}}, {"children", {0}}});
  gltf.json["scenes"][0]["nodes"] = {1};
  const Description d = read_document(gltf);
  check_near(vertex(d, 1), {10, 2, 0});
  check_near(vertex(d, 2), {7, 0, 0});
  // The matrix has columns.
  gltf.json["nodes"][1] = {{"matrix", {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1}}, {"children", {0}}};
  check_near(vertex(read_document(gltf), 2), {7, 0, 0});
}

TEST_CASE("gltf: a mesh of several nodes is one group with instances, and mirrored nodes keep their front") {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.json["nodes"].push_back({{"mesh", 0}, {"translation", {0, 0, 5}}});
  gltf.json["scenes"][0]["nodes"] = {0, 1};
  const Description d = read_document(gltf);
  CHECK(d.groups.size() == 1);
  REQUIRE(d.instances.size() == 2);
  CHECK(d.instances[1].to_world[11] == 5);
  gltf.json["nodes"] = {{{"mesh", 0}, {"scale", {-1, 1, 1}}}};
  gltf.json["scenes"][0]["nodes"] = {0};
  CHECK(read_document(gltf).shapes.front().flip_normals);
}

TEST_CASE("gltf: EXT_mesh_gpu_instancing places a mesh many times") {
  GltfBuilder gltf;
  gltf.add_triangle();
  const int translations = gltf.add<float>({1, 0, 0, 2, 0, 0, 3, 0, 0}, "VEC3");
  const int scales = gltf.add<float>({1, 1, 1, 5, 5, 5, 1, 1, 1}, "VEC3");
  gltf.json["nodes"][0]["translation"] = {0, 7, 0};
  gltf.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", translations},
                                                                                  {"SCALE", scales}};
  const Description d = read_document(gltf);
  REQUIRE(d.instances.size() == 3);
  CHECK(d.instances[1].to_world[0] == 5);
  CHECK(d.instances[2].to_world[3] == 3);
  CHECK(d.instances[2].to_world[7] == 7);
}

TEST_CASE("gltf: nodes follow steps, lines and cubic splines, and stand still outside of the keys") {
  const std::vector<float> times = {1, 3};
  const GltfBuilder linear = animated("translation", times, {0, 0, 0, 4, 0, 0}, "VEC3", "LINEAR");
  check_near(vertex(at_time(linear, 0), 0), {0, 0, 0});
  check_near(vertex(at_time(linear, 1.5), 0), {1, 0, 0});
  check_near(vertex(at_time(linear, 9), 0), {4, 0, 0});
  check_near(vertex(read_document(linear), 0), {0, 0, 0});
  const GltfBuilder step = animated("translation", times, {0, 0, 0, 4, 0, 0}, "VEC3", "STEP");
  check_near(vertex(at_time(step, 2.9), 0), {0, 0, 0});
  check_near(vertex(at_time(step, 3), 0), {4, 0, 0});

  const GltfBuilder cubic =
      animated("translation", times, {0, 0, 0, 0, 0, 0, 3, 0, 0, 3, 0, 0, 4, 0, 0, 0, 0, 0}, "VEC3", "CUBICSPLINE");
  check_near(vertex(at_time(cubic, 2), 0), {2, 0, 0});
  // Hermite basis at a quarter of the interval of two seconds, with slopes of 3 per second at both keys
  const double t = 0.25, h10 = t * t * t - 2 * t * t + t, h01 = 3 * t * t - 2 * t * t * t, h11 = t * t * t - t * t;
  check_near(vertex(at_time(cubic, 1.5), 0), {static_cast<float>(2 * 3 * h10 + 4 * h01 + 2 * 3 * h11), 0, 0});
}

TEST_CASE("gltf: rotations turn at constant speed the short way") {
  const float half = std::sqrt(0.5f);
  const GltfBuilder gltf = animated("rotation", {0, 3}, {0, 0, 0, 1, 0, 0, -half, -half}, "VEC4", "LINEAR");
  const float angle = 30 * kPi / 180;
  check_near(vertex(at_time(gltf, 1), 1), {std::cos(angle), std::sin(angle), 0});
  check_near(vertex(at_time(gltf, 3), 1), {0, 1, 0});
}

TEST_CASE("gltf: animations are chosen by name or number") {
  GltfBuilder gltf = animated("translation", {0, 1}, {1, 0, 0, 1, 0, 0}, "VEC3", "LINEAR");
  json second = gltf.json["animations"][0];
  second["name"] = "run";
  second["samplers"][0]["output"] = gltf.add<float>({2, 0, 0, 2, 0, 0}, "VEC3");
  gltf.json["animations"].push_back(second);
  check_near(vertex(at_time(gltf, 0), 0), {1, 0, 0});
  check_near(vertex(at_time(gltf, 0, "run"), 0), {2, 0, 0});
  check_near(vertex(at_time(gltf, 0, "1"), 0), {2, 0, 0});
  CHECK_THROWS_WITH_AS(at_time(gltf, 0, "rum"), doctest::Contains("did you mean 'run'"), SceneError);
}

TEST_CASE("gltf: morph targets move vertices by their weights") {
  GltfBuilder gltf = animated("weights", {0, 2}, {0, 1}, "SCALAR", "LINEAR");
  const int target = gltf.add<float>({0, 0, 4, 0, 0, 0, 0, 0, 0}, "VEC3");
  gltf.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", target}}};
  gltf.json["meshes"][0]["weights"] = {0.25};
  check_near(vertex(read_document(gltf), 0), {0, 0, 1});
  check_near(vertex(at_time(gltf, 1), 0), {0, 0, 2});
  gltf.json["nodes"][0]["weights"] = {0.5};
  check_near(vertex(read_document(gltf), 0), {0, 0, 2});
}

TEST_CASE("gltf: skins move vertices with their joints and ignore the node's own transform") {
  GltfBuilder gltf;
  json& primitive = gltf.add_triangle();
  primitive["attributes"]["JOINTS_0"] = gltf.add<std::uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, "VEC4");
  primitive["attributes"]["WEIGHTS_0"] = gltf.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0}, "VEC4");
  const std::vector<float> bind = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1,
                                   1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1};
  const int matrices = gltf.add<float>(bind, "MAT4");
  gltf.json["nodes"][0]["skin"] = 0;
  gltf.json["nodes"][0]["translation"] = {100, 0, 0};
  gltf.json["nodes"].push_back({{"translation", {0, 0, 2}}});
  gltf.json["nodes"].push_back({{"translation", {1, 0, 6}}});
  gltf.json["scenes"][0]["nodes"] = {0, 1, 2};
  gltf.json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", matrices}}};
  const Description d = read_document(gltf);
  check_near(vertex(d, 0), {0, 0, 2});
  check_near(vertex(d, 1), {1, 0, 6});
  check_near(vertex(d, 2), {0, 1, 4});
}

TEST_CASE("gltf: cameras look along -z and are chosen by name") {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.json["cameras"] = {
      {{"type", "perspective"},
       {"name", "wide"},
       {"perspective", {{"yfov", 1.0}, {"aspectRatio", 2.0}, {"znear", 0.5}}}},
      {{"type", "orthographic"}, {"orthographic", {{"xmag", 3.0}, {"ymag", 1.5}, {"znear", 0.1}, {"zfar", 9.0}}}}};
  gltf.json["nodes"].push_back({{"camera", 0}, {"translation", {0, 0, 5}}});
  gltf.json["nodes"].push_back({{"camera", 1}, {"name", "flat"}});
  gltf.json["scenes"][0]["nodes"] = {0, 1, 2};
  const Description d = read_document(gltf);
  CHECK(d.film.width == 1200);
  CHECK(d.film.height == 600);
  CHECK(d.camera.fov == near(180 / 3.14159265));
  CHECK(d.camera.near_clip == 0.5f);
  check_near(d.camera.to_world.point({0, 0, 1}), {0, 0, 4});
  check_near(d.camera.to_world.vector({1, 0, 0}), {-1, 0, 0});
  ReadOptions options;
  options.camera = "flat";
  const Description flat = read_document(gltf, options);
  CHECK(flat.camera.projection == CameraDescription::Projection::kOrthographic);
  check_near(flat.camera.to_world.vector({1, 0, 0}), {-3, 0, 0});
  options.camera = "flut";
  CHECK_THROWS_WITH_AS(read_document(gltf, options), doctest::Contains("did you mean 'flat'"), SceneError);
}

TEST_CASE("gltf: extras of cameras set the lens and the center of the image") {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.json["cameras"] = {{{"type", "orthographic"},
                           {"orthographic", {{"xmag", 4.0}, {"ymag", 2.0}, {"znear", 0.1}, {"zfar", 9.0}}},
                           {"extras",
                            {{"aperture_radius", 0.5},
                             {"focus_distance", 3},
                             {"principal_point_offset_x", 0.25},
                             {"principal_point_offset_y", -0.125},
                             {"note", "of another program"}}}}};
  gltf.json["nodes"].push_back({{"camera", 0}});
  gltf.json["scenes"][0]["nodes"] = {0, 1};
  const CameraDescription camera = read_document(gltf).camera;
  check_near(camera.to_world.vector({camera.aperture_radius, 0, 0}), {-0.5f, 0, 0});
  CHECK(camera.focus_distance == 3);
  CHECK(camera.principal_point_x == 0.25f);
  CHECK(camera.principal_point_y == -0.125f);

  gltf.json["cameras"][0]["extras"] = "text";
  CHECK(read_document(gltf).camera.aperture_radius == 0);
  gltf.json["cameras"][0]["extras"] = {{"focus_distance", "far"}};
  CHECK_THROWS_WITH_AS(read_document(gltf), doctest::Contains("'focus_distance' of 'extras' is not a number"),
                       SceneError);
}

TEST_CASE("gltf: punctual lights keep their place, direction and photometric intensity") {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"color", {1, 0.5, 0}}, {"intensity", 8}},
      {{"type", "directional"}, {"intensity", 3}},
      {{"type", "spot"}, {"intensity", 2}, {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.5}}}}};
  for (int i = 0; i < 3; ++i)
    gltf.json["nodes"].push_back(
        {{"translation", {0, 0, 4}}, {"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
  gltf.json["scenes"][0]["nodes"] = {0, 1, 2, 3};
  const Description d = read_document(gltf);
  REQUIRE(d.lights.size() == 3);  // and no sky
  const auto& point = std::get<PointLightDescription>(d.lights[0].model);
  check_near(point.position.rounded(), {0, 0, 4});
  check_near(std::get<SpectrumDescription::Rgb>(point.intensity.value).value, {8, 4, 0});
  check_near(std::get<DirectionalLightDescription>(d.lights[1].model).direction, {0, 0, -1});
  const auto& spot = std::get<SpotLightDescription>(d.lights[2].model);
  check_near(spot.to_world.vector({0, 0, 1}), {0, 0, -1});
  CHECK(spot.cutoff_angle == near(0.5 * 180 / 3.14159265));
  CHECK(spot.beam_width == near(0.1 * 180 / 3.14159265));
}

}  // namespace sheaf::test_gltf_nodes
