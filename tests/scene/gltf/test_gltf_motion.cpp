// Motion of glTF nodes while the shutter is open: tracks, hierarchies, instances, cameras and lights.
#include "tests/support/capture.h"
#include "tests/support/files/gltf_files.h"
#include "tests/support/files/scene_files.h"
#include "tests/support/near.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_gltf_motion {

using namespace test;
using nlohmann::json;

namespace {

constexpr double kTolerance = 1e-5;

Description read_at(const GltfBuilder& gltf, double time, const std::optional<ShutterDescription>& shutter) {
  const TemporaryFolder folder;
  ReadOptions options;
  options.moment.time = time;
  options.shutter = shutter;
  return read_scene(write_below(folder, "model.gltf", gltf.text()), options);
}

/// Adds a channel of the first animation.
void animate(GltfBuilder& gltf, int node, const char* path, const std::vector<float>& times,
             const std::vector<float>& values, const char* type, const char* interpolation = "LINEAR") {
  const int input = gltf.add<float>(times, "SCALAR"), output = gltf.add<float>(values, type);
  if (!gltf.json.contains("animations"))
    gltf.json["animations"] = {{{"channels", json::array()}, {"samplers", json::array()}}};
  json& animation = gltf.json["animations"][0];
  animation["channels"].push_back(
      {{"sampler", animation["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
  animation["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
}

void check_near(Vec3f a, Vec3f b) {
  CAPTURE(a.x);
  CAPTURE(a.y);
  CAPTURE(a.z);
  CHECK(length(a - b) < kTolerance * (1 + length(b)));
}

const AnimatedTransform& motion_of(const Description& d, std::optional<MotionId> id) {
  REQUIRE(id.has_value());
  return d.motions.at(static_cast<std::size_t>(*id));
}

/// A triangle in node 0 whose translation has two keys, at 1 s and 3 s.
GltfBuilder moving_triangle(const char* interpolation = "LINEAR") {
  GltfBuilder gltf;
  gltf.add_triangle();
  animate(gltf, 0, "translation", {1, 3}, {0, 0, 0, 4, 0, 0}, "VEC3", interpolation);
  return gltf;
}

constexpr ShutterDescription kShutter{-1, 1, 0};

}  // namespace

TEST_CASE("gltf motion: times are relative to the moment, and keys keep their times") {
  const Description d = read_at(moving_triangle(), 3, ShutterDescription{-1, 1, 0.25f});
  CHECK(d.shutter.open == -1);
  CHECK(d.shutter.ramp == 0.25f);
  const AnimatedTransform& motion = motion_of(d, d.shapes.at(0).motion);
  CHECK(motion.key_times() == std::vector<double>{-1, 0, 1});
  check_near(motion.at(-1).point({0, 0, 0}), {2, 0, 0});
  check_near(motion.at(-0.5).point({0, 0, 0}), {3, 0, 0});
  check_near(motion.at(0).point({0, 0, 0}), {4, 0, 0});
  check_near(motion.at(1).point({0, 0, 0}), {4, 0, 0});
  check_near(d.shapes[0].to_world.point({0, 0, 0}), {2, 0, 0});
}

TEST_CASE("gltf motion: nothing moves without a shutter, without an animation, and between equal keys") {
  CHECK(read_at(moving_triangle(), 2, std::nullopt).motions.empty());
  const Description late = read_at(moving_triangle(), 3, ShutterDescription{0, 1, 0});
  CHECK(late.motions.empty());
  check_near(late.shapes.at(0).to_world.point({0, 0, 0}), {4, 0, 0});
  // A node that has moved before the shutter opens
  const Description opened = read_at(moving_triangle(), 1, ShutterDescription{2, 3, 0});
  CHECK(opened.motions.empty());
  check_near(opened.shapes.at(0).to_world.point({0, 0, 0}), {4, 0, 0});
  // An instant
  const Description instant = read_at(moving_triangle(), 1, ShutterDescription{1, 1, 0});
  CHECK(instant.motions.empty());
  check_near(instant.shapes.at(0).to_world.point({0, 0, 0}), {2, 0, 0});
}

TEST_CASE("gltf motion: steps and cubic splines follow the values at all times") {
  const Description steps = read_at(moving_triangle("STEP"), 3, kShutter);
  const AnimatedTransform& step = motion_of(steps, steps.shapes.at(0).motion);
  check_near(step.at(-0.01).point({0, 0, 0}), {0, 0, 0});
  check_near(step.at(0).point({0, 0, 0}), {4, 0, 0});
  GltfBuilder gltf;
  gltf.add_triangle();
  animate(gltf, 0, "translation", {1, 3}, {0, 0, 0, 0, 0, 0, 0, 6, 0, 0, 0, 0, 4, 0, 0, 0, 0, 0}, "VEC3",
          "CUBICSPLINE");
  const Description cubic = read_at(gltf, 2, kShutter);
  const AnimatedTransform& motion = motion_of(cubic, cubic.shapes.at(0).motion);
  CHECK(motion.key_times().size() == 129);
  for (const double time : {-1.0, -0.6, 0.0, 0.31, 1.0}) {
    const Description still = read_at(gltf, 2 + time, std::nullopt);
    const Vec3f expected = still.shapes.at(0).to_world.point({0, 0, 0});
    CHECK(length(motion.at(time).point({0, 0, 0}) - expected) < 1e-3f);
  }
}

TEST_CASE("gltf motion: tracks multiply along the hierarchy") {
  GltfBuilder gltf;
  gltf.add_triangle();
  gltf.json["nodes"].push_back({{"children", {0}}, {"translation", {0, 0, 5}}});
  gltf.json["nodes"][0]["translation"] = {2, 0, 0};
  gltf.json["scenes"][0]["nodes"] = {1};
  const float half = std::sqrt(0.5f);
  animate(gltf, 1, "rotation", {0, 2}, {0, 0, 0, 1, 0, 0, half, half}, "VEC4");
  animate(gltf, 0, "scale", {0, 2}, {1, 1, 1, 3, 1, 1}, "VEC3");
  const Description d = read_at(gltf, 0, ShutterDescription{0, 2, 0});
  const AnimatedTransform& motion = motion_of(d, d.shapes.at(0).motion);
  for (const double time : {0.0, 0.5, 1.0, 2.0}) {
    const double angle = time / 4 * 3.14159265358979323846;
    const auto reach = static_cast<float>(2 + (1 + time));
    check_near(motion.at(time).point({1, 0, 0}),
               {reach * static_cast<float>(std::cos(angle)), reach * static_cast<float>(std::sin(angle)), 5});
  }
}

TEST_CASE("gltf motion: instances") {
  GltfBuilder gltf = moving_triangle();
  gltf.json["nodes"].push_back({{"mesh", 0}, {"translation", {0, 7, 0}}});
  gltf.json["scenes"][0]["nodes"] = {0, 1};
  const Description d = read_at(gltf, 2, kShutter);
  REQUIRE(d.instances.size() == 2);
  check_near(motion_of(d, d.instances[0].motion).at(0).point({0, 0, 0}), {2, 0, 0});
  CHECK_FALSE(d.instances[1].motion.has_value());
  // EXT_mesh_gpu_instancing
  GltfBuilder many = moving_triangle();
  const int translations = many.add<float>({0, 1, 0, 0, 2, 0}, "VEC3");
  many.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = translations;
  many.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  const Description e = read_at(many, 2, kShutter);
  REQUIRE(e.instances.size() == 2);
  check_near(motion_of(e, e.instances[1].motion).at(0.5).point({0, 0, 0}), {3, 2, 0});
}

TEST_CASE("gltf motion: cameras and lights keep their orientation, also below scaled nodes") {
  for (const float scale : {1.0f, 2.0f}) {
    CAPTURE(scale);
    GltfBuilder gltf = moving_triangle();
    gltf.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}}};
    gltf.json["extensionsUsed"] = {"KHR_lights_punctual"};
    gltf.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "point"}}, {{"type", "spot"}, {"spot", json::object()}}, {{"type", "directional"}}};
    gltf.json["nodes"].push_back({{"children", {2, 3, 4, 5}}, {"scale", {scale, scale, scale}}});
    gltf.json["nodes"].push_back({{"camera", 0}});
    for (int i = 0; i < 3; ++i)
      gltf.json["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
    gltf.json["scenes"][0]["nodes"] = {0, 1};
    const float half = std::sqrt(0.5f);
    animate(gltf, 1, "rotation", {0, 2}, {0, 0, 0, 1, 0, half, 0, half}, "VEC4");
    animate(gltf, 1, "translation", {0, 2}, {0, 0, 0, 6, 0, 0}, "VEC3");
    const Description d = read_at(gltf, 0, ShutterDescription{0, 2, 0});
    const float s = std::sqrt(0.5f);
    const auto check = [&](std::optional<MotionId> id, bool rotations) {
      const Transform middle = motion_of(d, id).at(1);
      check_near(middle.point({0, 0, 0}), {3, 0, 0});
      // Along -z of the node, which has turned by 45 degrees about y
      if (rotations) check_near(middle.vector({0, 0, 1}), {-s, 0, -s});
      if (rotations) check_near(middle.vector({0, 1, 0}), {0, 1, 0});
    };
    check(d.camera.motion, true);
    REQUIRE(d.lights.size() >= 3);
    check(d.lights[0].motion, false);
    check(d.lights[1].motion, true);
    check(d.lights[2].motion, true);
    check_near(std::get<DirectionalLightDescription>(d.lights[2].model).direction, {0, 0, -1});
    check_near(d.camera.to_world.vector({0, 0, 1}), {0, 0, -1});
  }
}

TEST_CASE("gltf motion: scales of zero, and chains of many moving nodes") {
  GltfBuilder gltf;
  gltf.add_triangle();
  animate(gltf, 0, "scale", {0, 2}, {0, 0, 0, 2, 2, 2}, "VEC3");
  const Description d = read_at(gltf, 0, ShutterDescription{0, 2, 0});
  const AnimatedTransform& growing = motion_of(d, d.shapes.at(0).motion);
  check_near(growing.at(1).vector({1, 0, 0}), {1, 0, 0});
  CHECK(length(growing.at(0).vector({1, 0, 0})) < 1e-5f);
  GltfBuilder chain;
  chain.add_triangle();
  for (int i = 1; i <= 50; ++i) chain.json["nodes"].push_back({{"children", {i - 1}}});
  chain.json["scenes"][0]["nodes"] = {50};
  for (int i = 0; i <= 50; ++i) animate(chain, i, "translation", {0, 1}, {0, 0, 0, 1, 0, 0}, "VEC3");
  const Description e = read_at(chain, 0, ShutterDescription{0, 1, 0});
  check_near(motion_of(e, e.shapes.at(0).motion).at(0.5).point({0, 0, 0}), {25.5f, 0, 0});
}

TEST_CASE("gltf motion: morph targets become keys of meshes that deform") {
  const auto mesh_of = [](const std::vector<float>& times, const std::vector<float>& weights, const char* type) {
    GltfBuilder gltf;
    json& primitive = gltf.add_triangle();
    primitive["targets"] = {{{"POSITION", gltf.add<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3")}}};
    animate(gltf, 0, "weights", times, weights, "SCALAR", type);
    // Its transform stays apart from the deformation
    animate(gltf, 0, "translation", {0, 1}, {0, 0, 0, 1, 0, 0}, "VEC3");
    Description d = read_at(gltf, 0, ShutterDescription{0, 1, 0});
    CHECK(d.notes.empty());
    CHECK(d.shapes.at(0).motion.has_value());
    return std::get<DeformingMesh>(d.shapes.at(0).geometry);
  };
  const auto height = [](const DeformingMesh::Key& key) { return std::get<Mesh>(key.mesh).positions.at(1).z; };
  // Linear weights need two keys
  const DeformingMesh linear = mesh_of({0, 1}, {0, 1}, "LINEAR");
  REQUIRE(linear.keys.size() == 2);
  CHECK(linear.keys[1].time == 1);
  CHECK(height(linear.keys[0]) == 0);
  CHECK(height(linear.keys[1]) == near(1));
  // There and back needs three
  const DeformingMesh back = mesh_of({0, 0.5f, 1}, {0, 1, 0}, "LINEAR");
  REQUIRE(back.keys.size() == 3);
  CHECK(back.keys[1].time == 0.5);
  CHECK(height(back.keys[1]) == near(1));
  CHECK(mesh_of({0, 1}, {0, 0, 0, 0, 1, 0}, "CUBICSPLINE").keys.size() > 8);
  // Without a shutter the mesh is that of the moment
  GltfBuilder gltf;
  gltf.add_triangle()["targets"] = {{{"POSITION", gltf.add<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3")}}};
  animate(gltf, 0, "weights", {0, 1}, {0, 1}, "SCALAR");
  CHECK(std::holds_alternative<Mesh>(read_at(gltf, 0.5, std::nullopt).shapes.at(0).geometry));
}

TEST_CASE("gltf motion: skins deform meshes, and nodes that share a mesh deform on their own") {
  GltfBuilder gltf;
  json& primitive = gltf.add_triangle();
  primitive["attributes"]["JOINTS_0"] = gltf.add<std::uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  primitive["attributes"]["WEIGHTS_0"] = gltf.add<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  gltf.json["nodes"][0]["skin"] = 0;
  gltf.json["nodes"].push_back(json::object());
  gltf.json["nodes"].push_back(json::object());
  gltf.json["nodes"].push_back({{"mesh", 0}, {"skin", 1}});
  std::vector<float> identities(32, 0.0f);
  for (std::size_t i = 0; i < 32; i += i % 16 == 15 ? 1 : 5) identities[i] = 1;
  const int bind = gltf.add<float>(identities, "MAT4");
  gltf.json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", bind}},
                        {{"joints", {1, 1}}, {"inverseBindMatrices", bind}}};
  gltf.json["scenes"][0]["nodes"] = {0, 1, 2, 3};
  const float half = std::sqrt(0.5f);
  animate(gltf, 2, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, half, half}, "VEC4");
  const Description d = read_at(gltf, 0, ShutterDescription{0, 1, 0});
  REQUIRE(d.shapes.size() >= 2);
  const auto& mesh = std::get<DeformingMesh>(d.shapes[0].geometry);
  // A quarter turn needs many keys: 90 degrees / 32 deviates by 3e-4 of the radius
  CHECK(mesh.keys.size() >= 33);
  const auto position = [&](std::size_t key, std::size_t vertex) {
    return std::get<Mesh>(mesh.keys[key].mesh).positions.at(vertex);
  };
  check_near(position(0, 1), {1, 0, 0});
  check_near(position(mesh.keys.size() / 2, 1), {half, half, 0});
  check_near(position(mesh.keys.size() - 1, 1), {0, 1, 0});
  check_near(position(mesh.keys.size() - 1, 0), {0, 0, 0});
  // The joint of the other node does not move
  CHECK(std::get<DeformingMesh>(d.shapes[1].geometry).keys.size() == 2);
}

}  // namespace sheaf::test_gltf_motion
