// The time to compile scenes of thousands of lights or materials.
#include "scene/compile/compile.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <ctime>
#include <utility>

namespace sheaf::test_light_compilation {

namespace {

/// Thousands of shapes or lights of one kind, side by side.
constexpr int kMany = 2000;

Transform position_of(int i) {
  const int column = i % 50, row = i / 50;
  return Transform::translate({static_cast<float>(column), static_cast<float>(row), 0});
}

/// CPU seconds to compile a description, the minimum of three runs.
double compile_seconds(const Description& d) {
  double least = 1e9;
  for (int i = 0; i < 3; ++i) {
    const std::clock_t start = std::clock();
    compile_scene(d);
    least = std::min(least, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return least;
}

}  // namespace

// Excluded under sanitizers, which slow down some code far more than other code.
TEST_SUITE_BEGIN("slow");

TEST_CASE("lights: thousands of lights and materials are compiled without an integration for each") {
  const auto many = [](auto&& add) {
    Description d = empty_scene(4, 4);
    for (int i = 0; i < kMany; ++i) add(d, i);
    return d;
  };
  // Flat disks, whose area is a product.
  const double disks = compile_seconds(many([](Description& d, int i) {
    emit(add_shape(d, DiskShape{}, position_of(i) * Transform::scale({0.1f, 0.1f, 1})), 1);
  }));
  const std::pair<const char*, Description> others[] = {
      {"spheres", many([](Description& d, int i) {
         emit(add_shape(d, SphereShape{{0, 0, 0}, 0.1f}, position_of(i)), 1);
       })},
      {"ellipsoids, each of its own shape", many([](Description& d, int i) {
         const float size = 0.1f + 1e-4f * static_cast<float>(i);
         emit(add_shape(d, SphereShape{}, position_of(i) * Transform::scale({0.1f, size, 2 * size})), 1);
       })},
      {"cylinders, each of its own shape", many([](Description& d, int i) {
         const float size = 0.1f + 1e-4f * static_cast<float>(i);
         emit(add_shape(d, CylinderShape{}, position_of(i) * Transform::scale({0.1f, size, 2 * size})), 1);
       })},
      {"textured lights of one texture", many([](Description& d, int i) {
         if (i == 0) add_checkerboard(d, {1, 2, 3}, {3, 2, 1});
         if (i % 2 == 0)
           add_shape(d, RectangleShape{}, position_of(i)).radiance = static_cast<TextureId>(0);
         else
           add_shape(d, SphereShape{}, position_of(i)).radiance = static_cast<TextureId>(0);
       })},
      {"spots", many([](Description& d, int i) {
         SpotLightDescription spot;
         spot.to_world = position_of(i);
         d.lights.push_back({spot, {}});
       })},
  };
  for (const auto& other : others) {
    const double seconds = compile_seconds(other.second);
    INFO(other.first << ": " << seconds << " s, disks " << disks << " s");
    // An integration for each would take 20 to 200 times as long as a disk.
    CHECK(seconds < 6 * disks + 0.05);
  }
  // Fits for a few roughnesses serve all others. A fit for each would take seconds.
  const double plastics = compile_seconds(many([](Description& d, int i) {
    PlasticDescription plastic;
    const float alpha = 0.05f + 4e-4f * static_cast<float>(i);
    plastic.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, alpha, alpha};
    add_shape(d, DiskShape{}, position_of(i), add_material(d, plastic));
  }));
  INFO("plastics: " << plastics << " s, disks " << disks << " s");
  CHECK(plastics < 6 * disks + 0.5);
  // A separate texture for each light is evaluated at hundreds of points, not at thousands.
  const double textured = compile_seconds(many([](Description& d, int i) {
    add_checkerboard(d, {1, 2, 3}, {3, static_cast<float>(i), 1});
    add_shape(d, RectangleShape{}, position_of(i)).radiance = static_cast<TextureId>(i);
  }));
  INFO("textures: " << textured << " s, disks " << disks << " s");
  CHECK(textured < 12 * disks + 0.1);
}

TEST_SUITE_END();

}  // namespace sheaf::test_light_compilation
