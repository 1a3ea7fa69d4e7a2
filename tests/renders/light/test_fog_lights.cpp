// Several area lights and a medium. Light found after scattering in the medium has the MIS weight of the light tree's
// probability at the scattering vertex, so that light sampling, phase sampling and their combination have the same
// mean.
#include "tests/support/media_testing.h"
#include "tests/support/render_testing.h"
#include "tests/support/temporary_folder.h"

namespace sheaf::test_fog_lights {

namespace {

/// All comparisons of this file together fail with probability kSignificance if every estimator is unbiased.
const double kLevel = significance_of_each(9 * 9);

Transform rotated(Vec3f at, Vec3f axis, float degrees, float size) {
  return Transform::translate(at) * Transform::rotate(axis, degrees) * Transform::scale({size, size, 1});
}

/// Lights around the origin and out of view. They are large, so that both strategies find them, and of unequal power,
/// so that the selection probabilities matter.
void add_lights(Description& d) {
  add_area_light_sphere(d, {0, 0, 2.6f}, 1.3f, 4);
  add_area_light_sphere(d, {0, 2.4f, -0.3f}, 1.1f, 1);
  add_area_light_rectangle(d, rotated({0, -2.2f, 0}, {1, 0, 0}, -90, 1.3f), 2);
  add_area_light_rectangle(d, rotated({2.4f, 0, 1.8f}, {0, 1, 0}, -135, 1.2f), 7);
}

/// A sphere of `medium` around the origin, seen from the side.
Description ball_between_lights(const MediumDescription& medium, float g, int samples = 64) {
  Description d = one_point_scene(samples);
  look_at_point(d, {-5, 0.2f, 0.3f}, {0, 0.2f, 0.3f});
  d.integrator.max_depth = 3;
  MediumDescription m = medium;
  m.phase = add_phase(d, g);
  const MediumId id = add_medium(d, m);
  fill(d, add_sphere(d, {0, 0, 0}, 1), id);
  add_lights(d);
  return d;
}

}  // namespace

TEST_SUITE_BEGIN("slow");

TEST_CASE("fog lights: all strategies agree on area lights around a homogeneous medium") {
  for (const float g : {0.0f, 0.5f}) {
    CAPTURE(g);
    check_strategies_agree(ball_between_lights(fog(1, 0.9f), g), kLevel);
  }
}

TEST_CASE("fog lights: all strategies agree on area lights around a colored grid medium") {
  const TemporaryFolder folder;
  const auto lumps = write_vol(folder / "lumps.vol", 12, 1, [](Vec3f p, int) {
    return 1 + std::sin(17 * p.x) * std::sin(13 * p.y + 1) * std::cos(11 * p.z);
  });
  MediumDescription m = fog(1, 0.9f);
  std::get<ExtinctionAlbedoDescription>(m.coefficients).sigma_t = SpectrumDescription::rgb(0.5f, 1, 2.5f);
  m.density = vol(lumps, Transform::translate({-1, -1, -1}) * Transform::scale({2, 2, 2}));
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
    CAPTURE(static_cast<int>(color));
    check_strategies_agree(ball_between_lights(m, 0.2f), kLevel, color);
  }
}

TEST_CASE("fog lights: all strategies agree with several candidates") {
  Description d = ball_between_lights(fog(1, 0.9f), 0.3f);
  d.integrator.candidates = 3;
  check_strategies_agree(d, kLevel);
}

TEST_CASE("fog lights: all strategies agree on an emissive medium among other lights") {
  MediumDescription m = fog(1.5f, 0.5f);
  m.emission = VolumeInput(SpectrumDescription::rgb(8, 5, 3));
  for (const bool seen : {true, false}) {
    CAPTURE(seen);
    Description d = ball_between_lights(m, 0);
    add_rectangle(d, Transform::translate({0, 0, -1.6f}) * Transform::scale({6, 6, 1}), add_diffuse(d, 0.7f));
    if (!seen) look_at_point(d, {-4, 0, -0.9f}, {-0.6f, 0.2f, -1.6f});
    check_strategies_agree(d, kLevel);
  }
}

TEST_CASE("fog lights: all strategies agree on a medium behind a mask and a thin dielectric") {
  Description d = ball_between_lights(fog(1, 0.9f), 0);
  d.integrator.thin_dielectrics_are_free = true;
  // Between the medium and the lights above and behind it.
  const MaterialId half = add_material(d, MaskDescription{0.5f, add_diffuse(d, 0)});
  add_rectangle(d, Transform::translate({0, 0, 1.1f}) * Transform::scale({1.5f, 1.5f, 1}), half);
  DielectricDescription pane;
  pane.int_ior = 3;
  pane.ext_ior = 1;
  pane.thin = true;
  add_rectangle(d, rotated({1.15f, 0, 0}, {0, 1, 0}, 90, 1.5f), add_material(d, pane));
  check_strategies_agree(d, kLevel);
}

TEST_SUITE_END();

}  // namespace sheaf::test_fog_lights
