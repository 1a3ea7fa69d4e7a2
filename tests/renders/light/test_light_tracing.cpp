// Light tracing against path tracing: every emitter with every BSDF, hidden lights, variance channels, determinism.
#include "scene/data/glasses.h"
#include "tests/renders/light/light_tracing_cases.h"
#include "tests/support/media_testing.h"
#include "tests/support/near.h"
#include "tests/support/same_bits.h"

#include <doctest/doctest.h>

#include <vector>

namespace sheaf::test_light_tracing {

using namespace light_tracing_cases;

TEST_CASE("light tracing: the bits do not depend on threads or wave size or crop") {
  Description d = room(8);
  d.sampler.kind = SamplerKind::kSobol;
  d.camera.medium = add_medium(d, fog(0.1f, 0.8f));
  for (const NamedChange& emitter : emitters()) emitter.add(d);
  add_named(d, balls(), "rough dielectric");
  d.integrator.kind = IntegratorKind::kLightTracer;
  check_same_bits(*compile_scene(d));
}

TEST_CASE("light tracing: the variance channels match the spread over seeds") {
  Description d = room(32);
  add_named(d, emitters(), "rectangle");
  d.integrator.kind = IntegratorKind::kLightTracer;
  const auto scene = compile_scene(d);
  constexpr int kImages = 40;
  std::vector<MeanVariance> pixels(std::size_t{kSide} * kSide);
  double claimed = 0;
  for (int i = 0; i < kImages; ++i) {
    RenderOptions options;
    options.seed = static_cast<std::uint32_t>(i);
    const Image image = render(*scene, options).to_image();
    const int variance = image.find_channel("variance.G");
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        pixels[static_cast<std::size_t>(y * kSide + x)].add(image.at(x, y, 1));
        claimed += static_cast<double>(image.at(x, y, variance)) / kImages;
      }
  }
  double found = 0;
  for (const MeanVariance& pixel : pixels) found += pixel.variance();
  CHECK(claimed / found == near(1, 0.06));
}

TEST_CASE("light tracing: hidden lights and their reflections are invisible except through thin dielectrics") {
  // A wall, lit by a point light and by two reflective lights in front of it.
  const auto wall = [] {
    Description d = empty_scene(12, 12);
    d.sampler.kind = SamplerKind::kIndependent;
    d.sampler.sample_count = 64;
    d.film.filter = {};
    look_at(d, {0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 40);
    d.integrator.max_depth = 4;
    d.integrator.hide_emitters = true;
    add_rectangle(d, Transform::scale({3, 3, 1}), add_diffuse_rgb(d, 0.8f, 0.5f, 0.2f));
    const MaterialId gray = add_diffuse(d, 0.7f);
    emit(add_rectangle(d, Transform::translate({0, 0, 1}) * Transform::scale({0.4f, 0.4f, 1}), gray), 3);
    emit(add_sphere(d, {0.5f, 0.4f, 0.5f}, 0.3f, gray), 2);
    add_point_light(d, {1, 1, 3}, 3);
    return d;
  };
  const auto pane = [](Description& d, float z) {
    DielectricDescription glass;
    glass.thin = true;
    glass.specular_reflectance = SpectrumDescription::constant(0);  // light tracing cannot render specular reflections
    add_rectangle(d, Transform::translate({-0.2f, -0.2f, z}) * Transform::scale({0.5f, 0.5f, 1}),
                  add_material(d, glass));
    d.integrator.thin_dielectrics_are_free = true;
  };
  check_agree(wall());
  // A pane before all lights, which makes them visible, behind all of them, and between them.
  for (const float z : {1.5f, 0.1f, 0.9f}) {
    CAPTURE(z);
    Description d = wall();
    pane(d, z);
    check_agree(d);
  }
  Description veiled = wall();
  add_rectangle(veiled, Transform::translate({0, 0, 1.3f}) * Transform::scale({0.5f, 0.5f, 1}),
                add_material(veiled, MaskDescription{0.4f, add_two_sided(veiled, add_diffuse(veiled, 0.7f))}));
  veiled.camera.medium = add_medium(veiled, fog(0.1f, 0.8f));
  check_agree(veiled);
}

TEST_SUITE_BEGIN("slow");

TEST_CASE("light tracing: every emitter with every BSDF has the mean of path tracing") {
  for (const NamedChange& emitter : emitters())
    for (const NamedChange& ball : balls()) {
      CAPTURE(emitter.name);
      CAPTURE(ball.name);
      Description d = room();
      emitter.add(d);
      ball.add(d);
      check_agree(d);
    }
}

TEST_CASE("light tracing: spectral mode with dispersion has the mean of path tracing") {
  for (const bool dispersion : {false, true}) {
    CAPTURE(dispersion);
    Description d = room(128);
    add_named(d, emitters(), "textured rectangle");
    DielectricDescription glass;
    if (dispersion)
      glass.int_dispersion = *find_dispersion("diamond");
    else
      glass.int_ior = 1.6f;
    glass.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.3f, 0.3f};
    add_shape(d, smooth_ball({0, 0, 0.8f}, 0.75f), Transform(), add_material(d, glass));
    check_agree(d, ColorMode::kSpectral);
    MediumDescription colored;
    colored.coefficients = ExtinctionAlbedoDescription{SpectrumDescription::rgb(0.1f, 0.2f, 0.4f),
                                                       SpectrumDescription::rgb(0.9f, 0.5f, 0.7f)};
    d.camera.medium = add_medium(d, colored);
    check_agree(d, ColorMode::kSpectral);
  }
}

TEST_SUITE_END();

}  // namespace sheaf::test_light_tracing
