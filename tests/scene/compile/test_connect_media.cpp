// The media whose rays are connected to lights.
#include "scene/compile/compile.h"
#include "tests/support/media_testing.h"
#include "tests/support/temporary_folder.h"

#include <doctest/doctest.h>

namespace sheaf::test_connect_media {

namespace {

/// A cube of fog from -1 to 1 m with a point light.
Description lit_cube(const MediumDescription& medium, Vec3f light) {
  Description d = empty_scene(4, 4);
  fill(d, add_shape(d, CubeShape{}, {}), add_medium(d, medium));
  add_point_light(d, light, 1);
  return d;
}

bool connects(const Description& d) { return compile_scene(d)->view().media.connects_segments; }

/// A medium whose extinction is a grid over the cube, of up to 1 / m.
MediumDescription with_grid(const std::filesystem::path& file) {
  MediumDescription m = fog(1, 0.5f);
  std::get<ExtinctionAlbedoDescription>(m.coefficients).sigma_t =
      vol(file, Transform::scale({2, 2, 2}) * Transform::translate({-0.5f, -0.5f, -0.5f}));
  return m;
}

}  // namespace

TEST_CASE("connected media: homogeneous ones with a light inside or close by") {
  CHECK(connects(lit_cube(fog(1, 0.5f), {0, 0, 0})));
  CHECK(connects(lit_cube(fog(0.1f, 0.5f), {0, 0, 3})));
  // far away for the size of the medium, too dense, without scattering
  CHECK(!connects(lit_cube(fog(0.1f, 0.5f), {0, 0, 9})));
  CHECK(!connects(lit_cube(fog(20, 0.5f), {0, 0, 0})));
  CHECK(!connects(lit_cube(fog(1, 0), {0, 0, 0})));
}

TEST_CASE("connected media: a medium that emits does not light itself") {
  MediumDescription glowing = fog(1, 0.5f);
  glowing.emission = SpectrumDescription::constant(1);
  CHECK(!connects(lit_cube(glowing, {0, 0, 9})));
  CHECK(connects(lit_cube(glowing, {0, 0, 0})));
}

TEST_CASE("connected media: a medium around everything is as large as the scene") {
  Description d = empty_scene(4, 4);
  add_rectangle(d, Transform::scale({5, 5, 5}), add_diffuse(d, 0.5f));
  add_point_light(d, {0, 0, 1}, 1);
  add_medium(d, fog(0.1f, 0.5f));
  d.camera.medium = MediumId{0};
  CHECK(connects(d));
  d.media[0] = fog(100, 0.5f);
  CHECK(!connects(d));
}

TEST_CASE("connected media: many lamps in dense fog light enough of it together") {
  Description d = lit_cube(fog(5, 0.5f), {0, 0, 0});
  d.lights.clear();
  add_point_light(d, {0.5f, 0, 0}, 1);
  CHECK(!connects(d));
  for (int i = 0; i < 40; ++i) add_point_light(d, {0.9f - 0.04f * static_cast<float>(i), 0.3f, 0.1f}, 1);
  CHECK(connects(d));
}

TEST_CASE("connected media: gray ones with one grid, by the density where there is any") {
  const TemporaryFolder folder;
  const auto half_empty = [](Vec3f p, int) { return p.x < 0.5f ? 0.0f : 1.0f; };
  MediumDescription m = with_grid(write_vol(folder / "gray.vol", 16, 1, half_empty));
  CHECK(connects(lit_cube(m, {0.5f, 0, 0})));
  const auto scene = compile_scene(lit_cube(m, {0.5f, 0, 0}));
  CHECK(scene->view().media.rows[0].mean_extinction > 0.8f);
  CHECK(scene->view().media.rows[0].mean_extinction < 1.05f);
  m.scale = 30;
  CHECK(!connects(lit_cube(m, {0.5f, 0, 0})));
  // colored, and varying albedo
  m.scale = 1;
  MediumDescription colored =
      with_grid(write_vol(folder / "colored.vol", 4, 3, [](Vec3f, int c) { return 1.0f + static_cast<float>(c); }));
  CHECK(!connects(lit_cube(colored, {0.5f, 0, 0})));
  auto& coefficients = std::get<ExtinctionAlbedoDescription>(m.coefficients);
  coefficients.albedo = vol(write_vol(folder / "albedo.vol", 4, 1, [](Vec3f p, int) { return p.x; }));
  CHECK(!connects(lit_cube(m, {0.5f, 0, 0})));
}

TEST_CASE("connected media: none if another medium has a colored grid") {
  const TemporaryFolder folder;
  Description d = lit_cube(fog(1, 0.5f), {0, 0, 0});
  const auto file = write_vol(folder / "colored.vol", 4, 3, [](Vec3f, int c) { return 1.0f + static_cast<float>(c); });
  fill(d, add_shape(d, CubeShape{}, Transform::translate({5, 0, 0})), add_medium(d, with_grid(file)));
  CHECK(!connects(d));
}

}  // namespace sheaf::test_connect_media
