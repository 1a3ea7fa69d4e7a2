// The limit on contributions of indirect light: a closed form, and direct light, which has no limit.
#include "core/io/error.h"
#include "tests/renders/light/closed_forms.h"
#include "tests/support/caustic_testing.h"
#include "tests/support/media_testing.h"

#include <doctest/doctest.h>

#include <algorithm>

namespace sheaf::test_clamped_indirect {

using namespace closed_forms;

namespace {

Image render_clamped(const Description& d, float limit, ColorMode color = ColorMode::kRgb,
                     CausticMode caustics = CausticMode::kSampled) {
  CompileOptions compile;
  compile.color = color;
  RenderOptions options;
  options.clamp_indirect = limit;
  options.caustics = caustics;
  options.light_groups = true;
  return render(*compile_scene(d, compile), options).to_image();
}

/// A diffuse floor with a mirror ball, a glass ball and a glowing one below a lamp.
Description lit_floor() {
  Description d = floor_scene(16);
  d.film.width = d.film.height = 16;
  look_at(d, {0, -4, 3}, {0, 0, 0.5f}, {0, 0, 1}, 50);
  add_sphere(d, {-1, 0, 0.5f}, 0.5f, add_mirror(d));
  add_sphere(d, {1, 0, 0.5f}, 0.5f, add_glass(d));
  emit(add_sphere(d, {0, 0, 0.3f}, 0.2f), 0.5f);
  add_lamp(d, {-0.4f, 0.1f, 3}, 0.4f, 10);
  return d;
}

}  // namespace

TEST_CASE("clamped indirect light: inside a furnace each bounce from the second on is limited") {
  // A bounce adds radiance 2 * 0.8^n, without any noise if only BSDFs are sampled.
  Description d = small_scene();
  d.film.width = d.film.height = 4;
  look_at(d, {0.2f, -0.3f, 0.1f}, {1, 0.4f, 0.3f});
  ShapeDescription& shape = add_sphere(d, {0, 0, 0}, 1, add_diffuse(d, 0.8f));
  shape.flip_normals = true;
  emit(shape, 2).emitter_id = "furnace";
  d.integrator.strategy = LightStrategy::kBsdfOnly;
  d.integrator.max_depth = 5;
  d.integrator.rr_depth = 100;
  for (const double limit : {1e30, 3.0, 1.1, 0.9, 0.5}) {
    CAPTURE(limit);
    const double expected =
        2 + 2 * 0.8 + std::min(2 * 0.64, limit) + std::min(2 * 0.512, limit) + std::min(2 * 0.4096, limit);
    const Image image = render_clamped(d, static_cast<float>(limit));
    check_mean(statistics_of(image, 0), expected);
    const int group = image.find_channel("light_furnace.R");
    REQUIRE(group >= 0);
    check_mean(statistics_of(image, group), expected);
  }
}

TEST_CASE("clamped indirect light: a low limit leaves direct light, in all color modes, media and estimators") {
  Description plain = lit_floor();
  Description foggy = lit_floor();
  MediumDescription glowing = fog(0.1f, 0.8f);
  glowing.emission = SpectrumDescription::constant(0.3f);
  foggy.camera.medium = add_medium(foggy, glowing);
  for (Description* scene : {&plain, &foggy})
    for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral})
      for (const CausticMode caustics : {CausticMode::kSampled, CausticMode::kManifold}) {
        if (scene == &foggy && caustics == CausticMode::kManifold) continue;
        CAPTURE(static_cast<int>(color));
        CAPTURE(static_cast<int>(caustics));
        Description direct = *scene;
        direct.integrator.max_depth = 2;
        const Image expected = render_clamped(direct, kInfinity, color, caustics);
        const Image clamped = render_clamped(*scene, 1e-9f, color, caustics);
        REQUIRE(expected.data.size() == clamped.data.size());
        double worst = 0;
        for (std::size_t i = 0; i < expected.data.size(); ++i)
          worst = std::max(worst, std::fabs(static_cast<double>(expected.data[i]) - clamped.data[i]));
        CHECK(worst < 1e-5);
        CHECK(statistics_of(expected, 0).mean() > 0.01);
      }
}

TEST_CASE("clamped indirect light: no limit changes no bits, and a limit only removes light") {
  const Description d = lit_floor();
  const Image all = render_clamped(d, kInfinity), high = render_clamped(d, 1e30f), low = render_clamped(d, 0.2f);
  CHECK(all.data == high.data);
  bool is_darker = true;
  for (std::size_t i = 0; i < all.data.size(); ++i) is_darker = is_darker && low.data[i] <= all.data[i] * 1.00001f;
  CHECK(is_darker);
  CHECK(statistics_of(low, 0).mean() < 0.99 * statistics_of(all, 0).mean());
}

TEST_CASE("clamped indirect light: integrators without paths from the camera reject it") {
  Description d = lit_floor();
  d.integrator.kind = IntegratorKind::kLightTracer;
  RenderRequest request;
  request.clamp_indirect = 1;
  CHECK_THROWS_WITH_AS(resolve_settings(d, ColorMode::kRgb, request),
                       "clamping indirect light needs an integrator that traces paths from the camera, such as path "
                       "(got 'ptracer')",
                       Error);
}

}  // namespace sheaf::test_clamped_indirect
