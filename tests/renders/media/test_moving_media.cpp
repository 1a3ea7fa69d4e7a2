// Media whose grids move and emissive media in motion: closed forms, and agreement of estimators and integrators.
#include "kernels/lights/light_select.h"
#include "tests/support/light_tracing_testing.h"
#include "tests/support/media_testing.h"
#include "tests/support/motion_testing.h"
#include "tests/support/near.h"
#include "tests/support/photon_testing.h"
#include "tests/support/render_testing.h"
#include "tests/support/same_bits.h"
#include "tests/support/temporary_folder.h"

namespace sheaf::test_moving_media {

namespace {

constexpr double kAllowed = 4e-4;  ///< of the tabulated transforms

constexpr MediumEstimator kEstimators[] = {MediumEstimator::kNullMis, MediumEstimator::kDelta, MediumEstimator::kRatio,
                                           MediumEstimator::kMarching};

Transform shift(float x, float y = 0, float z = 0) { return Transform::translate({x, y, z}); }
Transform scale(float s) { return Transform::scale({s, s, s}); }
Transform about_z(double degrees) { return Transform::rotate({0, 0, 1}, degrees); }

/// From the unit cube to the cube of side 2 around the origin.
Transform centered() { return shift(-1, -1, -1) * scale(2); }

/// Mean of the green channel.
MeanVariance green(const Description& d) { return pixel_means(d)[1]; }

/// A camera that looks along `from` - `at`, with a constant background of 1.
Description view_through(Vec3f from, Vec3f at, int samples) {
  Description d = one_point_scene(samples);
  look_at_point(d, from, at, {0, 1, 0});
  d.integrator.kind = IntegratorKind::kPath;
  d.integrator.max_depth = -1;
  add_constant_light(d, 1);
  expose(d, 0, 1);
  return d;
}

/// Gray fog whose extinction is a grid, at rest at the first key.
MediumDescription fog_on_grid(Description& d, const std::filesystem::path& file, float albedo,
                              const Transform& position, MotionKeys keys) {
  MediumDescription m = fog(1, albedo);
  GridVolumeDescription grid = vol(file, keys[0].value * position);
  grid.filter = GridFilter::kNearest;
  grid.motion = add_motion(d, std::move(keys));
  d.motions.back() = d.motions.back() * AnimatedTransform(position);
  std::get<ExtinctionAlbedoDescription>(m.coefficients).sigma_t = grid;
  return m;
}

/// A still box of half the side `size` around the origin that bounds a medium.
ShapeDescription& fill_box(Description& d, float size, const MediumDescription& m) {
  return fill(d, add_shape(d, CubeShape{}, scale(size)), add_medium(d, m));
}

std::filesystem::path constant_grid(const TemporaryFolder& folder, float value, int channels = 1) {
  return write_vol(folder / ("constant" + std::to_string(channels) + ".vol"), 2, channels,
                   [=](Vec3f, int) { return value; });
}

}  // namespace

TEST_CASE("moving media: a box that passes gives the mean of both transmittances, for every estimator") {
  const TemporaryFolder folder;
  const double level = significance_of_each(12);
  for (const MediumEstimator estimator : kEstimators)
    for (const int channels : {1, 3})
      for (const bool shape_moves : {true, false}) {
        if (channels == 3 && shape_moves) continue;
        CAPTURE(static_cast<int>(estimator));
        CAPTURE(channels);
        CAPTURE(shape_moves);
        Description d = view_through({0, 0, 9}, {0, 0, 0}, 64);
        d.integrator.medium_estimator = estimator;
        d.integrator.step_size = 0.02f;
        // Its right side passes the axis at 0.3, and stays
        const MotionKeys keys{{0, shift(-1.6f)}, {1, shift(0.4f)}};
        ShapeDescription& box = fill_box(d, shape_moves ? 1.001f : 4,
                                         fog_on_grid(d, constant_grid(folder, 0.6f, channels), 0, centered(), keys));
        if (shape_moves) {
          const Transform around = box.to_world;
          move(d, box, {{0, shift(-1.6f) * around}, {1, shift(0.4f) * around}});
        }
        check_mean(green(d), 0.3 + 0.7 * std::exp(-1.2), level,
                   estimator == MediumEstimator::kMarching ? 4e-3 : kAllowed);
      }
}

TEST_CASE("moving media: a grid that turns shows each of its halves for its part of the time") {
  const TemporaryFolder folder;
  const auto halves = write_vol(folder / "halves.vol", 16, 1, [](Vec3f p, int) { return p.x < 0.5f ? 0.9f : 0.2f; });
  const double level = significance_of_each(8);
  for (const MediumEstimator estimator : kEstimators)
    for (const bool oblique : {false, true}) {
      CAPTURE(static_cast<int>(estimator));
      CAPTURE(oblique);
      // The dense half leaves the ray at 30 degrees from the x axis after a turn by 120 degrees. A ray in the plane
      // through the axis crosses the same half all the way
      const Vec3f at{0.5f * std::sqrt(0.75f), 0.25f, 0};
      Description d = view_through(oblique ? Vec3f{at.x * 9, at.y * 9, 8} : Vec3f{at.x, at.y, 9}, at, 64);
      d.integrator.medium_estimator = estimator;
      d.integrator.step_size = 0.01f;
      fill_box(d, 1.6f,
               fog_on_grid(d, halves, 0, shift(-1, -1, -0.25f) * Transform::scale({2, 2, 0.5f}),
                           {{0, {}}, {0.5, about_z(90)}, {1, about_z(180)}}));
      const double length = oblique ? 0.5 * std::sqrt(64 + 16) / 8 : 0.5;
      const double expected = (std::exp(-0.2 * length) * 2 + std::exp(-0.9 * length)) / 3;
      check_mean(green(d), expected, level, estimator == MediumEstimator::kMarching ? 4e-3 : 1.5e-3);
    }
}

TEST_CASE("moving media: coefficients of a grid that stretches stay those per meter") {
  const TemporaryFolder folder;
  Description d = view_through({0, 0, 9}, {0, 0, 0}, 64);
  fill_box(d, 4,
           fog_on_grid(d, constant_grid(folder, 0.6f), 0, centered(), {{0, {}}, {1, Transform::scale({1, 1, 3})}}));
  // The length grows from 2 to 6
  check_mean(green(d), (std::exp(-1.2) - std::exp(-3.6)) / 2.4, kSignificance, kAllowed);
}

TEST_CASE("moving media: a camera that moves sees what a cloud that moves the other way shows") {
  const TemporaryFolder folder;
  const auto lumps = write_vol(folder / "lumps.vol", 8, 1, [](Vec3f p, int) {
    return 1 + 0.9f * std::sin(9 * p.x) * std::sin(7 * p.y + 1) * std::cos(5 * p.z);
  });
  const auto picture = [&](bool camera_moves, ColorMode color) {
    Description d = view_through({0.2f, 0.5f, 9}, {0.2f, 0.5f, 0}, 64);
    d.lights.push_back({DirectionalLightDescription{{0, 0, -1}}, {}});
    d.sampler.seed = camera_moves ? 3 : 4;
    // Both turn about the axis of the light
    const auto rotated = [](double angle) { return shift(0, 0, static_cast<float>(angle / 90)) * about_z(angle); };
    const bool cloud_moves = !camera_moves;
    MediumDescription m =
        fog_on_grid(d, lumps, 0.8f, centered(),
                    {{0, {}}, {0.5, rotated(cloud_moves ? 45 : 0)}, {1, rotated(cloud_moves ? 90 : 0)}});
    m.phase = add_phase(d, 0.6f);
    fill_box(d, 4, m);
    if (camera_moves) {
      d.camera.motion = add_motion(d, {{0, {}}, {0.5, rotated(-45)}, {1, rotated(-90)}});
      d.motions.back() = d.motions.back() * AnimatedTransform(d.camera.to_world);
    }
    return pixel_means(d, color)[1];
  };
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
    CAPTURE(static_cast<int>(color));
    check_same_mean(picture(true, color), picture(false, color), significance_of_each(2));
  }
}

TEST_CASE("moving media: flakes turn with their grid") {
  const TemporaryFolder folder;
  const auto scene = [&](float albedo, const std::array<float, 6>& matrix, double degrees) {
    Description d = view_through({0, 0, 9}, {0, 0, 0}, 64);
    d.phases.push_back({SggxDescription{matrix}, {}});
    MediumDescription m = fog_on_grid(d, constant_grid(folder, 1.5f), albedo, shift(-2, -2, -2) * scale(4),
                                      {{0, {}}, {1, Transform::rotate({0, 1, 0}, degrees)}});
    m.phase = static_cast<PhaseId>(d.phases.size() - 1);
    fill(d, add_sphere(d, {0, 0, 0}, 1), add_medium(d, m));
    return d;
  };
  // Fibers along x, which turn by `angle` towards -z
  const auto fibers = [](double angle) {
    const double x = std::cos(angle), z = -std::sin(angle);
    return std::array<float, 6>{static_cast<float>(1 - 0.96 * x * x), 1, static_cast<float>(1 - 0.96 * z * z), 0,
                                static_cast<float>(-0.96 * x * z),    0};
  };
  const double right = 0.5 * double(kPi);
  // Absorption along z: the projected area changes over time
  double expected = 0;
  constexpr int kSteps = 1000;
  for (int i = 0; i < kSteps; ++i) {
    const double c = std::cos(right * (i + 0.5) / kSteps);
    expected += std::exp(-3 * std::sqrt(c * c + 0.04 * (1 - c * c))) / kSteps;
  }
  check_mean(green(scene(0, fibers(0), 90)), expected, significance_of_each(2), 1e-3);
  // Scattering from x to z: against fibers that stand still at three times, by Simpson's rule
  const auto scattered = [&](double angle, double degrees, std::uint32_t seed) {
    Description d = scene(1, fibers(angle), degrees);
    d.lights.clear();
    d.lights.push_back({DirectionalLightDescription{{1, 0, 0}}, {}});
    d.integrator.max_depth = 2;
    d.sampler.seed = seed;
    expose(d, 0.5, 0.7);
    return green(d);
  };
  const MeanVariance first = scattered(0.5 * right, 0, 1), middle = scattered(0.6 * right, 0, 2),
                     last = scattered(0.7 * right, 0, 3), all = scattered(0, 90, 4);
  const double sum = (first.mean() + 4 * middle.mean() + last.mean()) / 6;
  const double variance = (first.variance() + 16 * middle.variance() + last.variance()) / 36 + all.variance();
  CAPTURE(sum);
  CAPTURE(all.mean());
  CHECK(std::fabs(first.mean() - last.mean()) > 0.1 * sum);
  const double distance = std::max(std::fabs(all.mean() - sum) - 2e-3 * sum, 0.0);
  CHECK(student_t_p_value(distance / std::sqrt(variance / (32 * 32)), 32 * 32 - 1) >= significance_of_each(2));
}

namespace {

/// Emission of a glowing cube of side 1 that hardly absorbs, W / (m^3 sr).
constexpr float kGlow = 4, kThin = 1e-3f;

/// A grid that moves in a still box, or with its shape; no grid; a shape that moves in a still grid.
enum class Glow { kGridInBox, kGridInShape, kHomogeneous, kShapeInGrid };

/// A wall at x = 0 that faces +x, seen at the origin, and a glowing cube of side 1 with the motion `keys`. `lamp`: the
/// irradiance that a point light adds.
Description glow_scene(const TemporaryFolder& folder, Glow glow, const MotionKeys& keys, const NamedStrategy& strategy,
                       float lamp) {
  const bool by_bsdf = strategy.strategy == LightStrategy::kBsdfOnly;
  Description d = one_point_scene(by_bsdf ? 256 : 64);
  d.integrator.max_depth = 2;
  d.integrator.strategy = strategy.strategy;
  // Collisions are too rare in thin media to sample their emission
  if (by_bsdf) d.integrator.medium_estimator = MediumEstimator::kMarching;
  d.integrator.step_size = 0.05f;
  look_at_point(d, {4, 0, -4}, {0, 0, 0});
  add_rectangle(d, Transform::rotate({0, 1, 0}, 90) * scale(0.2f), add_diffuse(d, 0.5f));
  // A second light, so that the choice depends on the bounds of the first over time
  if (!by_bsdf) add_point_light(d, {1, 0, 0}, lamp);
  const float radiance = kGlow / kThin;
  const Transform cube = shift(-0.5f, -0.5f, -0.5f);
  MediumDescription m = fog(kThin, 0);
  if (glow == Glow::kShapeInGrid)
    m = fog_on_grid(d, constant_grid(folder, kThin), 0, scale(20) * cube, {{0, {}}, {1, {}}});
  else if (glow != Glow::kHomogeneous)
    m = fog_on_grid(d, constant_grid(folder, kThin), 0, cube, keys);
  m.emission = SpectrumDescription::constant(radiance);
  ShapeDescription& shape = fill_box(d, glow == Glow::kGridInBox ? 20 : 0.5f, m);
  if (glow != Glow::kGridInBox) {
    MotionKeys placed = keys;
    for (AnimatedTransform::Key& key : placed) key.value = key.value * scale(0.5f);
    move(d, shape, std::move(placed));
  }
  expose(d, 0, 1);
  return d;
}

/// Radiance of the wall under the irradiance of the cube and of the point light, which BSDF sampling does not find.
double reflected(double irradiance, const NamedStrategy& strategy, float lamp) {
  const bool by_bsdf = strategy.strategy == LightStrategy::kBsdfOnly;
  return 0.5 / double(kPi) * (irradiance + (by_bsdf ? 0 : double{lamp}));
}

}  // namespace

TEST_CASE("moving media: a glowing cube on a line gives the integral of its irradiance, however it is sampled") {
  const TemporaryFolder folder;
  const double level = significance_of_each(10);
  // At the height 2, from behind the wall to its front, where it crosses the plane of the wall: its mean of max(x, 0)
  // there exceeds that of a point by 1 / 24 of a squared side
  constexpr float kSide = 0.5f, kLamp = 0.02f;
  const MotionKeys keys{{0, shift(-3, 0, 2) * scale(kSide)}, {1, shift(3, 0, 2) * scale(kSide)}};
  const double integral = 0.5 - 1 / std::sqrt(13) + double{kSide * kSide} / 24 / 8;
  const double irradiance = double{kGlow} * std::pow(double{kSide}, 3) * integral / 6;
  for (const Glow glow : {Glow::kGridInBox, Glow::kGridInShape, Glow::kHomogeneous, Glow::kShapeInGrid})
    for (const NamedStrategy& strategy : kLightStrategies) {
      if (glow == Glow::kGridInBox && strategy.strategy == LightStrategy::kBsdfOnly) continue;
      CAPTURE(static_cast<int>(glow));
      CAPTURE(strategy.name);
      const double expected = reflected(irradiance, strategy, kLamp);
      check_mean(green(glow_scene(folder, glow, keys, strategy, kLamp)), expected, level, 3e-3 * expected);
    }
}

TEST_CASE("moving media: the light tree bounds the emission over the whole shutter") {
  const TemporaryFolder folder;
  const Description d =
      glow_scene(folder, Glow::kHomogeneous, {{0, shift(-3, 0, 2)}, {1, shift(3, 0, 2)}}, kLightStrategies[0], 8);
  const auto scene = compile_scene(d);
  const SceneView& view = scene->view();
  const auto probability = [&](float x) {
    return choice_probability<Scalar>(view, {{x, 0, 3}, {}}, view.media.rows[0].light);
  };
  // The second light is nearer to the right end
  CHECK(probability(3) > 0.5f * probability(-3));
}

TEST_CASE("moving media: a cube that grows glows in proportion to its volume, however it is sampled") {
  const TemporaryFolder folder;
  const double level = significance_of_each(6);
  // A box of 0.4 x 0.4 x a at x = 3, where a grows from 0.1 to 0.7
  const auto position = [](float a) { return shift(3, 0, 0) * Transform::scale({0.4f, 0.4f, a}); };
  const MotionKeys keys{{0, position(0.1f)}, {1, position(0.7f)}};
  constexpr float kLamp = 0.03f;
  const double irradiance = double{kGlow} * 0.4 * 0.4 * 0.4 / 9;
  for (const Glow glow : {Glow::kGridInBox, Glow::kHomogeneous})
    for (const NamedStrategy& strategy : kLightStrategies) {
      if (glow == Glow::kGridInBox && strategy.strategy == LightStrategy::kBsdfOnly) continue;
      CAPTURE(static_cast<int>(glow));
      CAPTURE(strategy.name);
      const double expected = reflected(irradiance, strategy, kLamp);
      check_mean(green(glow_scene(folder, glow, keys, strategy, kLamp)), expected, level, 4e-3 * expected);
    }
}

TEST_CASE("moving media: path tracing and light tracing agree on a dense cloud that glows and turns") {
  const TemporaryFolder folder;
  const auto lumps = write_vol(folder / "lumps.vol", 8, 1, [](Vec3f p, int) { return 1 + std::sin(6 * p.x); });
  Description d = empty_scene(16, 16);
  d.sampler.sample_count = 64;
  look_at(d, {0, -5, 4}, {0, 0, 0.3f}, {0, 0, 1}, 60);
  d.integrator.max_depth = 4;
  add_rectangle(d, Transform::scale({3, 3, 1}), add_diffuse(d, 0.6f));
  const auto position = [](float x, double angle, float a) {
    return shift(x, 0, 1) * Transform::rotate({1, 1, 0}, angle) * Transform::scale({a, 1, 1});
  };
  MediumDescription m = fog_on_grid(d, lumps, 0.6f, centered(), {{0, position(-1, 0, 1)}, {1, position(1, 80, 0.5f)}});
  m.scale = 1.5f;
  m.emission = SpectrumDescription::rgb(2, 3, 1);
  ShapeDescription& ball = fill(d, add_sphere(d, {0, 0, 0}, 0.9f), add_medium(d, m));
  move(d, ball, {{0, position(-1, 0, 1)}, {1, position(1, 80, 0.5f)}});
  expose(d, 0, 1);
  SUBCASE("strategies") {
    d.sampler.kind = SamplerKind::kIndependent;
    look_at_point(d, {0, -5, 4}, {0.5f, 0, 0});
    d.film.width = d.film.height = 32;
    check_strategies_agree(d, significance_of_each(9));
  }
  SUBCASE("light tracing") { check_light_tracing_agrees(d); }
  SUBCASE("threads, waves and crops") { check_same_bits(*compile_scene(d), {64, 256, 1000}, {}); }
}

namespace {

/// A cloud lit by a point light, by photons in media. `keys`: of the cloud; with `all`, also of the light and the
/// camera.
Description photon_scene(const std::filesystem::path& lumps, const Transform& position, const MotionKeys& keys,
                         bool all) {
  Description d = empty_scene(12, 12);
  d.sampler.sample_count = 8;
  look_at(d, {0.5f, -5, 1}, {0, 0, 0}, {0, 0, 1}, 30);
  d.integrator.kind = IntegratorKind::kPhotonMapper;
  d.integrator.photons.global.count = 100;
  d.integrator.photons.volume = {10000, 0.1f, 0};
  d.integrator.max_depth = 6;
  MediumDescription m = fog_on_grid(d, lumps, 0.9f, position, keys);
  m.phase = add_phase(d, 0.5f);
  ShapeDescription& box = fill_box(d, 2.5f, m);
  add_point_light(d, {2, -3, 1.5f}, 20);
  if (all) {
    const auto moved = [&](const Transform& at_rest) {
      const MotionId id = add_motion(d, keys);
      d.motions.back() = d.motions.back() * AnimatedTransform(at_rest);
      return id;
    };
    box.motion = moved(box.to_world);
    d.lights[0].motion = moved({});
    d.camera.motion = moved(d.camera.to_world);
  }
  return d;
}

void check_same_photons(const Description& a, const Description& b, double level) {
  const Mean x = mean_of(a), y = mean_of(b);
  INFO("means " << x.value << " and " << y.value);
  CHECK(student_t_p_value((x.value - y.value) / std::sqrt(x.variance + y.variance), 14) >= level);
}

}  // namespace

TEST_CASE("moving media: photons in media move with the grids") {
  const TemporaryFolder folder;
  const auto lumps = write_vol(folder / "lumps.vol", 8, 1, [](Vec3f p, int) { return p.x < 0.5f ? 3.0f : 0.3f; });
  const double level = significance_of_each(2);
  const MotionKeys still{{0, {}}, {1, {}}};
  // All together: nothing moves relative to the camera
  Description d = photon_scene(lumps, centered(), {{0, {}}, {0.5, about_z(60)}, {1, shift(2, 1) * about_z(120)}}, true);
  expose(d, 0, 1);
  check_same_photons(d, photon_scene(lumps, centered(), still, false), level);
  // A cloud that has been stretched
  const Transform stretch = Transform::scale({0.5f, 2, 1.4f});
  d = photon_scene(lumps, centered(), {{0, {}}, {1, stretch}}, false);
  expose(d, 1, 1);
  check_same_photons(d, photon_scene(lumps, stretch * centered(), still, false), level);
}

TEST_CASE("moving media: with a closed shutter grids are where they are at that time") {
  const TemporaryFolder folder;
  const auto halves = write_vol(folder / "halves.vol", 8, 1, [](Vec3f p, int) { return p.x < 0.5f ? 2.0f : 0.1f; });
  Description d = view_through({0.4f, 0.2f, 9}, {0.4f, 0.2f, 0}, 16);
  fill_box(d, 4, fog_on_grid(d, halves, 0, centered(), {{0, {}}, {1, shift(0, 0.3f) * about_z(170)}}));
  const auto at = [&](double time) {
    Description still = d;
    expose(still, time, time);
    return green(still).mean();
  };
  CHECK(at(0) == near(std::exp(-0.2), 0.05));
  CHECK(at(0.9) == near(std::exp(-4.0), 0.3));
}

TEST_CASE("moving media: grids of one medium move together, and groups hold none") {
  const TemporaryFolder folder;
  Description d = view_through({0, 0, 9}, {0, 0, 0}, 1);
  MediumDescription m = fog_on_grid(d, constant_grid(folder, 0.5f), 0, centered(), {{0, {}}, {1, shift(1)}});
  // The same map in another place
  GridVolumeDescription albedo = vol(constant_grid(folder, 0.5f), shift(0, 2));
  albedo.motion = add_motion(d, {{0, shift(0, 2)}, {1, shift(1, 2)}});
  auto& pair = std::get<ExtinctionAlbedoDescription>(m.coefficients);
  pair.albedo = albedo;
  fill_box(d, 4, m);
  CHECK(compile_scene(d)->view().motion.media != nullptr);
  const auto message = [](const Description& of) {
    try {
      compile_scene(of);
    } catch (const SceneError& error) { return std::string(error.what()); }
    return std::string();
  };
  auto& compiled = std::get<ExtinctionAlbedoDescription>(d.media[0].coefficients);
  std::get<GridVolumeDescription>(compiled.albedo).motion = add_motion(d, {{0, shift(0, 2)}, {1, shift(1, 3)}});
  CHECK(message(d).find("'albedo' moves differently from 'sigma_t'") != std::string::npos);
  std::get<GridVolumeDescription>(compiled.albedo).motion.reset();
  CHECK(message(d).find("'albedo' moves differently from 'sigma_t'") != std::string::npos);
  // Flakes keep their shape
  compiled.albedo = SpectrumDescription::constant(0);
  d.phases.push_back({SggxDescription{std::array<float, 6>{1, 1, 1, 0, 0, 0}}, {}});
  d.media[0].phase = static_cast<PhaseId>(d.phases.size() - 1);
  CHECK(message(d).empty());
  std::get<GridVolumeDescription>(compiled.sigma_t).motion = add_motion(d, {{0, {}}, {1, scale(2)}});
  CHECK(message(d).find("microflakes cannot be stretched") != std::string::npos);
  // A shape in a group
  d.groups.emplace_back();
  d.groups.back().shapes.push_back(d.shapes.back());
  d.shapes.clear();
  CHECK(message(d).find("a medium in a shape group") != std::string::npos);
}

}  // namespace sheaf::test_moving_media
