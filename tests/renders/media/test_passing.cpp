// Rays that continue behind surfaces (hidden lights, null interfaces, masks, the far plane, debug views), and unbounded
// media.
#include "kernels/passes/passes.h"
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/media_testing.h"
#include "tests/support/stages_testing.h"
#include "tests/support/statistics.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>

namespace sheaf::test_passing {

namespace {

/// All comparisons of this file together fail with probability kSignificance if every estimator is unbiased.
const double kLevel = significance_of_each(100);
constexpr int kSide = 32;
constexpr LightStrategy kStrategies[] = {LightStrategy::kMis, LightStrategy::kBsdfOnly, LightStrategy::kLightOnly};

/// A camera that looks at one point.
Description small_scene(Vec3f from, Vec3f at, int samples) {
  Description d = empty_scene(kSide, kSide);
  d.sampler.sample_count = static_cast<std::uint32_t>(samples);
  d.sampler.seed = 23;
  look_at(d, from, at, {0, 1, 0}, 0.01f);
  return d;
}

Image render_image(const Description& d) { return render(*compile_scene(d), {}).film.to_image(); }

MeanVariance means_of(const Image& image, int channel = 0) {
  MeanVariance m;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) m.add(image.at(x, y, channel));
  return m;
}

/// Tests the mean against `expected`. `rounding` is the relative error of single precision.
void check_mean(const MeanVariance& m, double expected, double rounding = 1e-4) {
  INFO("mean " << m.mean() << ", expected " << expected << ", standard error "
               << std::sqrt(m.variance() / (kSide * kSide)));
  const double distance = m.mean() - expected, allowed = rounding * std::fabs(expected);
  const double nearest = std::fabs(distance) <= allowed ? m.mean() : expected + std::copysign(allowed, distance);
  CHECK(m.p_value(nearest) >= kLevel);
}

Transform facing_back(float z) { return Transform::translate({0, 0, z}) * Transform::rotate({0, 1, 0}, 180); }

}  // namespace

TEST_CASE("pass-through: paths scatter behind a hidden light in a medium as if it were absent") {
  // Scattered light comes from the environment or the light, which have the same radiance. Unscattered paths see
  // nothing, nor do those that scatter inside the light, which is dark inside.
  Description d = small_scene({0, 0, 0}, {0, 0, 1}, 32);
  d.integrator.hide_emitters = true;
  d.integrator.rr_depth = 1000;
  add_constant_light(d, 1);
  add_area_light_sphere(d, {0, 0, 3}, 0.11f, 1);
  const MediumId id = add_medium(d, fog(0.3f, 1));
  fill(d, add_sphere(d, {0, 0, 0}, 6), id);
  check_mean(means_of(render_image(d)), 1 - std::exp(-1.8) - (std::exp(-0.3 * 2.89) - std::exp(-0.3 * 3.11)));
}

TEST_CASE("pass-through: the far plane keeps its distance") {
  for (const bool behind : {false, true})
    for (int what = 0; what < 3; ++what) {
      CAPTURE(behind);
      CAPTURE(what);
      Description d = small_scene({0, 0, 0}, {0, 0, 1}, 1);
      d.camera.far_clip = behind ? 6.5f : 5;
      d.integrator.hide_emitters = true;
      add_constant_light(d, 1);
      add_rectangle(d, facing_back(6), add_diffuse(d, 0.5f));
      const MaterialId black = add_diffuse(d, 0);
      for (const float z : {1.5f, 3.0f, 4.5f}) {
        ShapeDescription& shape = add_rectangle(d, facing_back(z), black);
        if (what == 0)
          emit(shape, 2);
        else if (what == 1)
          shape.material = add_material(d, NullDescription{});
        else
          shape.material = add_material(d, MaskDescription{0.0f, black});
      }
      check_mean(means_of(render_image(d), 3), behind ? 1 : 0);
    }
}

TEST_CASE("pass-through: debug views skip invisible surfaces and measure the distance from the camera") {
  for (const IntegratorKind kind : {IntegratorKind::kNormals, IntegratorKind::kDepth})
    for (const bool media : {false, true}) {
      CAPTURE(static_cast<int>(kind));
      CAPTURE(media);
      Description d = empty_scene(kSide, kSide);
      look_at(d, {0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 20);
      d.camera.near_clip = 0.1f;
      d.integrator.kind = kind;
      d.integrator.hide_emitters = true;
      add_rectangle(d, facing_back(6) * Transform::rotate({1, 2, 0}, 30) * Transform::scale({0.8f, 0.8f, 1}),
                    add_diffuse(d, 0.5f));
      const Image open = render_image(d);
      CHECK(open.at(kSide / 2, kSide / 2, 3) == 1.0f);
      CHECK(open.at(0, 0, 3) == 0.0f);
      const MaterialId black = add_diffuse(d, 0);
      emit(add_rectangle(d, facing_back(2), black), 2);
      emit(add_rectangle(d, facing_back(2.5f), black), 2);
      if (media) {
        add_rectangle(d, facing_back(3), add_material(d, NullDescription{}));
        add_rectangle(d, facing_back(4), add_material(d, MaskDescription{0.0f, black}));
        fill(d, add_sphere(d, {0, 0, 5}, 0.5f), add_medium(d, fog(1, 0.5f)));
      }
      const Image covered = render_image(d);
      double worst = 0;
      for (std::size_t i = 0; i < open.data.size(); ++i)
        worst = std::max(worst, std::fabs(double{open.data[i]} - double{covered.data[i]}));
      // Rays continue at a small offset behind a surface.
      CHECK(worst < 1e-4);
    }
}

TEST_CASE_TEMPLATE("pass-through: debug views lose no paths behind hidden lights", L, Wide, Scalar) {
  Description d = empty_scene(16, 16);
  d.integrator.kind = IntegratorKind::kDepth;
  d.integrator.hide_emitters = true;
  emit(add_rectangle(d, facing_back(1)), 2);
  const auto scene = compile_scene(d);
  TestWave test(16);
  test.begin({0, 0, 16, 16}, 0, 1, 16);
  run_pass<L>(test.context(*scene), test.wave);
  CHECK(test.wave.stats.samples == 256);
  CHECK(test.wave.free.size() == test.wave.capacity);
}

TEST_CASE("pass-through: a hidden light still bounds its media") {
  // Two meters of emissive gas before a black wall, in a cube that is a hidden light.
  MediumDescription gas = fog(1, 0);
  gas.emission = VolumeInput(SpectrumDescription::constant(1));
  Description d = small_scene({0, 0, 0}, {0, 0, 1}, 4);
  d.integrator.hide_emitters = true;
  const MaterialId black = add_diffuse(d, 0);
  add_rectangle(d, facing_back(8) * Transform::scale({4, 4, 1}), black);
  ShapeDescription& cube = add_shape(d, CubeShape{}, Transform::translate({0, 0, 4}), black);
  cube.interior = add_medium(d, gas);
  emit(cube, 3);
  check_mean(means_of(render_image(d)), 1 - std::exp(-2.0));
}

namespace {

/// A floor in an unbounded `medium`, seen from 2 m above, in a white environment.
Description foggy_floor(const MediumDescription& medium, int samples) {
  Description d = small_scene({1.2f, 1.6f, 0}, {0, 0, 0}, samples);
  d.camera.to_world = Transform::look_at({1.2f, 1.6f, 0}, {0, 0, 0}, {0, 0, 1});
  add_constant_light(d, 1);
  add_rectangle(d, Transform::rotate({1, 0, 0}, -90) * Transform::scale({3, 3, 1}), add_diffuse(d, 0.5f));
  d.camera.medium = add_medium(d, medium);
  return d;
}

/// Radius of the unbounded medium: 1.01 times that of the scene, a sphere around the corners of the floor.
const double kMediumRadius = 1.01 * std::sqrt(18.0);

}  // namespace

TEST_CASE("pass-through: distant light enters an unbounded medium at the bounding sphere of the scene") {
  for (const LightStrategy strategy : kStrategies) {
    CAPTURE(static_cast<int>(strategy));
    Description d = foggy_floor(fog(0.2f, 0), 16);
    d.integrator.strategy = strategy;
    check_mean(means_of(render_image(d)), 0.5 * std::exp(-0.2 * (2 + kMediumRadius)));
    // The camera looks at the environment itself.
    look_at(d, {0, 1.6f, 0}, {0, 2, 0}, {0, 0, 1}, 0.01f);
    check_mean(means_of(render_image(d)), std::exp(-0.2 * (kMediumRadius - 1.6)));
  }
}

TEST_CASE("pass-through: an unbounded medium has the same mean for every strategy") {
  MeanVariance found[3];
  for (int i = 0; i < 3; ++i) {
    Description d = foggy_floor(fog(0.2f, 0.8f), 32);
    d.integrator.strategy = kStrategies[i];
    found[i] = means_of(render_image(d));
  }
  for (int i = 1; i < 3; ++i) {
    const double error = std::sqrt((found[0].variance() + found[i].variance()) / (kSide * kSide));
    INFO("means " << found[0].mean() << " and " << found[i].mean() << ", standard error " << error);
    CHECK(student_t_p_value((found[0].mean() - found[i].mean()) / error, 2 * kSide * kSide - 2) >= kLevel);
  }
  MESSAGE("means " << found[0].mean() << ", " << found[1].mean() << ", " << found[2].mean());
}

TEST_CASE("pass-through: lossless surfaces are invisible in an unbounded lossless medium") {
  for (const LightStrategy strategy : kStrategies) {
    CAPTURE(static_cast<int>(strategy));
    Description d = foggy_floor(fog(0.2f, 1), 16);
    d.integrator.rr_depth = 1000;
    d.integrator.strategy = strategy;
    d.shapes[0].material = add_two_sided(d, add_diffuse(d, 1));
    check_mean(means_of(render_image(d)), 1);
  }
}

}  // namespace sheaf::test_passing
