// Manifold next-event estimation at lights inside glass, where radiance scales with the squared index of refraction,
// and at vertices behind the first one.
#include "kernels/bsdf/fresnel.h"
#include "tests/support/capture.h"
#include "tests/support/caustic_testing.h"

namespace sheaf::test_caustic_vertices {

namespace {

/// All comparisons of means of this file together fail with probability kSignificance.
const double kLevel = significance_of_each(9);

}  // namespace

TEST_CASE("caustics: lamps inside glass have the mean of BSDF sampling") {
  // The chain leaves the glass once, so the radiance is divided by the squared index.
  for (const bool disperses : {false, true})
    for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
      CAPTURE(disperses);
      CAPTURE(static_cast<int>(color));
      Description d = floor_scene(64);
      d.integrator.max_depth = 5;
      add_sphere(d, {0, 0, 1}, 0.6f, disperses ? add_dispersive_glass(d) : add_glass(d, 1.8f));
      add_area_light_sphere(d, {0.1f, 0, 0.95f}, 0.15f, 10);
      check_caustics_agree(d, 1, kLevel, color);
    }
}

TEST_CASE("caustics: a light at a point inside glass shines out of it") {
  // At normal incidence the solid angle grows by the squared index, and the light seems closer by it.
  Description d = floor_scene(64);
  const float index = 1.6f;
  add_shape(d, CubeShape{}, Transform::translate({0, 0, 1.5f}) * Transform::scale({5, 5, 0.5f}), add_glass(d, index));
  add_point_light(d, {0.3f, 0, 1.4f}, 5);
  d.integrator.max_depth = 3;
  const double transmittance = 1 - static_cast<double>(fresnel_dielectric<Scalar>(1, index).reflectance);
  const double distance = static_cast<double>(index) + 0.4;
  check_mean(render_with(d, CausticMode::kManifold).pixels,
             0.8 / 3.14159265 * 5 * transmittance / (distance * distance), kLevel, 1e-3);
}

TEST_CASE("caustics: several lights at a point and in a direction are chosen and weighed by their probability") {
  Description d = floor_scene(256);
  // A mirror in the plane x = -1, which faces +x, and lights of unequal power
  add_rectangle(d, Transform::translate({-1, 0, 2}) * Transform::rotate({0, 1, 0}, 90) * Transform::scale({2, 3, 1}),
                add_mirror(d, 0.7f));
  const Vec3f at[] = {{0.8f, 0.4f, 1.5f}, {0.6f, -0.5f, 1.2f}, {1.1f, 0.2f, 2}};
  const float intensity[] = {3, 0.5f, 12};
  double expected = 0;
  for (int i = 0; i < 3; ++i) {
    add_point_light(d, at[i], intensity[i]);
    // Direct light, and that of the image
    for (const float x : {at[i].x, -2 - at[i].x}) {
      const Vec3f to = Vec3f{x, at[i].y, at[i].z} - Vec3f{0.3f, 0, 0};
      const double squared = static_cast<double>(dot(to, to));
      expected += 0.8 / 3.14159265 * (x < 0 ? 0.7 : 1.0) * static_cast<double>(intensity[i] * to.z) /
                  (squared * std::sqrt(squared));
    }
  }
  // A sun, whose reflection shines from the mirror at the same height
  d.lights.push_back({DirectionalLightDescription{{-0.6f, 0, -0.8f}, SpectrumDescription::constant(4)}, {}});
  expected += 0.8 / 3.14159265 * 4 * 0.8 * (1 + 0.7);
  d.integrator.max_depth = 3;
  check_mean(render_with(d, CausticMode::kManifold).pixels, expected, kLevel, 1e-3 * expected);
}

TEST_CASE("caustics: light that arrives only as a caustic at the second vertex has the mean of BSDF sampling") {
  Description d = floor_scene(256);
  d.integrator.max_depth = 5;
  // A lamp shines up through a slab of glass at a ceiling, which lights the floor. A wall hides both from the floor.
  const MaterialId black = add_two_sided(d, add_diffuse(d, 0));
  add_area_light_rectangle(d, Transform::translate({-2, 0, 0.2f}) * Transform::scale({0.3f, 0.3f, 1}), 20);
  add_shape(d, CubeShape{}, Transform::translate({-2, 0, 0.5f}) * Transform::scale({0.5f, 0.5f, 0.1f}), add_glass(d));
  add_rectangle(
      d, Transform::translate({-1.2f, 0, 0.5f}) * Transform::rotate({0, 1, 0}, 90) * Transform::scale({0.5f, 4, 1}),
      black);
  add_rectangle(
      d, Transform::translate({-1, 0, 1.6f}) * Transform::rotate({1, 0, 0}, 180) * Transform::scale({1.5f, 1, 1}),
      add_diffuse(d, 0.8f));
  check_caustics_agree(d, 1.5, kLevel);
}

}  // namespace sheaf::test_caustic_vertices
