// Meshes and curves that deform while the shutter is open: closed forms, and agreement of estimators.
#include "tests/support/envmap_testing.h"
#include "tests/support/light_tracing_testing.h"
#include "tests/support/motion_testing.h"
#include "tests/support/render_testing.h"
#include "tests/support/trace_testing.h"

namespace sheaf::test_deformation {

namespace {

constexpr double kAllowed = 2e-4;

/// A quadrilateral with corners in counter-clockwise order, as seen from its front.
Mesh quad(Vec3f a, Vec3f b, Vec3f c, Vec3f d) {
  return {{a, b, c, d}, {}, {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {{0, 1, 2}, {0, 2, 3}}};
}

/// The same with one normal.
Mesh quad(Vec3f a, Vec3f b, Vec3f c, Vec3f d, Vec3f normal) {
  Mesh mesh = quad(a, b, c, d);
  mesh.normals.assign(4, normal);
  return mesh;
}

/// A strip of the plane z = 0 from x = -3 to `right`.
Mesh strip(float right) { return quad({-3, -1, 0}, {right, -1, 0}, {right, 1, 0}, {-3, 1, 0}); }

ShapeDescription& add_deforming(Description& d, std::vector<DeformingMesh::Key> keys,
                                std::optional<MaterialId> material = {}) {
  return add_shape(d, DeformingMesh{std::move(keys)}, {}, material);
}

/// A camera above the origin that sees the point (x, 0, 0).
Description view_of(float x, int samples) {
  Description d = one_point_scene(samples);
  look_at_point(d, {x, 0, 5}, {x, 0, 0}, {0, 1, 0});
  d.integrator.max_depth = 1;
  return d;
}

/// The plane z = 0 seen from the side, lit by nothing yet.
Description floor_scene(int samples) {
  Description d = one_point_scene(samples);
  look_at_point(d, {0, -4, 4}, {0, 0, 0});
  d.integrator.max_depth = 2;
  add_rectangle(d, Transform::scale({50, 50, 1}), add_diffuse(d, 0.5f));
  return d;
}

/// A straight tube along y.
Curves tube(Curves::Basis basis, float x, float radius) {
  Curves curves{basis, {}, {0}};
  for (const float y : {-3.0f, -1.0f, 1.0f, 3.0f}) curves.points.push_back({{x, y, 0}, radius});
  return curves;
}

/// Two hairs of varying radius.
Curves hairs(Curves::Basis basis, Vec3f shift) {
  Curves curves{basis, {}, {0, 5}};
  for (int i = 0; i < 11; ++i) {
    const auto k = static_cast<float>(i);
    curves.points.push_back({shift + Vec3f{0.25f * std::sin(2 * k), 0.4f * k - 2, 0.3f * std::cos(k)},
                             0.15f + 0.04f * static_cast<float>(i % 3)});
  }
  return curves;
}

/// Hairs that bend and widen.
Curves bent_hairs(Curves::Basis basis) {
  Curves curves = hairs(basis, {0.4f, 0, 0.3f});
  for (Curves::Point& point : curves.points) {
    point.position.x += 0.2f * point.position.y;
    point.position.z += 0.3f * point.position.y * point.position.y;
    point.radius *= 1.7f;
  }
  return curves;
}

ShapeDescription& add_deforming(Description& d, std::vector<DeformingCurves::Key> keys,
                                std::optional<MaterialId> material = {}) {
  return add_shape(d, DeformingCurves{std::move(keys)}, {}, material);
}

/// A floor and lights around hairs, which the caller adds.
Description hair_scene(int samples) {
  Description d = empty_scene(16, 16);
  d.sampler.sample_count = static_cast<std::uint32_t>(samples);
  look_at(d, {0, 0, 6}, {0, 0, 0}, {0, 1, 0}, 45);
  d.integrator.max_depth = 3;
  add_rectangle(d, Transform::translate({0, 0, -1}) * Transform::scale({6, 6, 1}), add_diffuse(d, 0.7f));
  d.lights.push_back({ConstantLightDescription{SpectrumDescription::constant(0.2f)}, {}});
  add_point_light(d, {2, 1, 4}, 8);
  return d;
}

MaterialId add_hair(Description& d) {
  HairDescription hair;
  hair.scale_tilt = 8;
  return add_material(d, hair);
}

constexpr Curves::Basis kBases[] = {Curves::Basis::kBspline, Curves::Basis::kLinear};

MeanVariance green(const Description& d) { return pixel_means(d)[1]; }

/// A lamp above the plane z = 0 that bends, turns and grows.
std::vector<DeformingMesh::Key> bending_lamp() {
  return {{0, quad({-1, 1, 2}, {1, 1, 2}, {1, -1, 2}, {-1, -1, 2})},
          {0.5, quad({-1, 0.5f, 2}, {1, 1, 1.5f}, {1.5f, -1, 2.5f}, {-1, -0.5f, 2})},
          {1, quad({-0.5f, 1, 3}, {0, 1, 1.5f}, {0, -1, 1.5f}, {-0.5f, -1, 3})}};
}

}  // namespace

TEST_CASE("deformation: an edge that moves leaves the ramp of a rigid edge") {
  const double level = significance_of_each(6);
  for (const float x : {-0.6f, 0.3f, 0.7f}) {
    CAPTURE(x);
    // The right edge moves from -1 to 1
    Description d = view_of(x, 64);
    emit(add_deforming(d, {{0, strip(-1)}, {1, strip(1)}}), 1);
    expose(d, 0, 1);
    check_mean(green(d), 0.5 * (1 - x), level, kAllowed);
    // In the second quarter of the interval of the keys, from -0.5 to 0
    expose(d, 0.25, 0.5);
    check_mean(green(d), x > 0 ? 0.0 : x < -0.5f ? 1.0 : -2.0 * x, level, kAllowed);
  }
}

TEST_CASE("deformation: several keys give several speeds, and outside of them the mesh stands still") {
  Description d = view_of(0, 64);
  // The edge passes the origin at 0.2, stands at 1 from 0.3 to 0.4, and passes it again at 0.6
  emit(add_deforming(d, {{0.1, strip(-1)}, {0.3, strip(1)}, {0.4, strip(1)}, {0.8, strip(-1)}}), 1);
  expose(d, 0, 1);
  check_mean(green(d), 0.4, kSignificance, kAllowed);
  // With a closed shutter the mesh is as it is at that time
  for (const double time : {0.19, 0.21, 0.59, 0.61}) {
    expose(d, time, time);
    const auto scene = compile_scene(d);
    CHECK_FALSE(scene->view().motion.any());
    CHECK(render(*scene, {}).to_image().at(3, 3, 1) == (time > 0.2 && time < 0.6 ? 1.0f : 0.0f));
  }
}

TEST_CASE("deformation: normals are interpolated") {
  Description d = view_of(0.2f, 64);
  d.integrator.max_depth = 2;
  const auto tilted = [](Vec3f normal) { return quad({-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, normal); };
  add_deforming(d, {{0, tilted({0, 0, 1})}, {1, tilted({0.8f, 0, 0.6f})}}, add_diffuse(d, 0.5f));
  d.lights.push_back({DirectionalLightDescription{{0, 0, -1}}, {}});
  expose(d, 0, 1);
  double cosine = 0;
  constexpr int kSteps = 1000;
  for (int i = 0; i < kSteps; ++i) {
    const double t = (i + 0.5) / kSteps, z = 1 - 0.4 * t;
    cosine += z / std::hypot(0.8 * t, z) / kSteps;
  }
  check_mean(green(d), 0.5 / double(kPi) * cosine, kSignificance, 2e-5);
}

TEST_CASE("deformation: a blocker that grows casts its shadow for part of the time") {
  Description d = floor_scene(64);
  add_point_light(d, {0, 0, 4}, 1);
  // Half way to the light: its edge passes the axis at 0.3
  const auto blocker = [](float right) { return quad({-2, -1, 2}, {right, -1, 2}, {right, 1, 2}, {-2, 1, 2}); };
  add_deforming(d, {{0, blocker(-0.6f)}, {1, blocker(1.4f)}});
  expose(d, 0, 1);
  check_mean(green(d), 0.3 * 0.5 / double(kPi) / 16, kSignificance, 1e-5);
}

TEST_CASE("deformation: a lamp that grows gives the mean of its irradiance, however it is sampled") {
  // A rectangle, whose half width grows from 0: small and far away, where lights are sampled, and large and near, where
  // both techniques matter
  struct Lamp {
    float width, depth, height, radiance;
  };
  const double level = significance_of_each(6);
  for (const Lamp& lamp : {Lamp{0.3f, 0.3f, 9, 1000}, Lamp{4, 0.5f, 1, 1}})
    for (const NamedStrategy& strategy : kLightStrategies) {
      CAPTURE(lamp.height);
      CAPTURE(strategy.name);
      Description d = floor_scene(256);
      d.integrator.strategy = strategy.strategy;
      const auto of_width = [&](float half) {
        const float y = lamp.depth, z = lamp.height;
        return quad({-half, y, z}, {half, y, z}, {half, -y, z}, {-half, -y, z});
      };
      emit(add_deforming(d, {{0, of_width(0)}, {1, of_width(lamp.width)}}), lamp.radiance);
      if (strategy.strategy == LightStrategy::kBsdfOnly) d.sampler.sample_count = 4096;
      expose(d, 0, 1);
      // Irradiance of a rectangle of half sides a, b at height h, on its axis
      const auto irradiance = [](double a, double b, double h) {
        const double u = std::sqrt(a * a + h * h), v = std::sqrt(b * b + h * h);
        return 2 * (a / u * std::atan(b / u) + b / v * std::atan(a / v));
      };
      double mean = 0;
      constexpr int kSteps = 1000;
      for (int i = 0; i < kSteps; ++i)
        mean += irradiance(double{lamp.width} * (i + 0.5) / kSteps, lamp.depth, lamp.height) / kSteps;
      check_mean(green(d), 0.5 / double(kPi) * lamp.radiance * mean, level, 1e-5);
    }
}

TEST_CASE("deformation: a lamp that turns over lights what it faces later") {
  // Turned about the x axis, it faces upwards at first and downwards in the end
  const auto rotated = [](float degrees) {
    const float angle = degrees * kPi / 180, y = std::cos(angle), z = std::sin(angle);
    return quad({-1, y, 2 + z}, {1, y, 2 + z}, {1, -y, 2 - z}, {-1, -y, 2 - z});
  };
  Description d = floor_scene(128);
  emit(add_deforming(d, {{0, rotated(180)}, {0.5, rotated(90)}, {1, rotated(0)}}), 3);
  add_area_light_rectangle(d, Transform::translate({0, 3, 3}) * Transform::rotate({1, 0, 0}, 140), 1);
  expose(d, 0, 1);
  check_strategies_agree(d, significance_of_each(9));
}

TEST_CASE("deformation: light and BSDF sampling agree on lamps that bend, also in instances that move") {
  const double level = significance_of_each(2 * 9);
  for (const bool instanced : {false, true}) {
    CAPTURE(instanced);
    Description d = floor_scene(128);
    ShapeDescription lamp;
    lamp.geometry = DeformingMesh{bending_lamp()};
    emit(lamp, 3);
    if (!instanced) {
      d.shapes.push_back(lamp);
    } else {
      d.groups.emplace_back();
      d.groups.back().shapes.push_back(lamp);
      for (const float side : {-1.0f, 1.0f}) {
        InstanceDescription instance;
        instance.motion =
            add_motion(d, {{0, Transform::translate({side, 0, 0})},
                           {1, Transform::translate({side, 1, 0.2f}) * Transform::scale({0.5f, 1, 0.8f})}});
        if (side > 0)
          instance.motion = add_motion(d, {{0, Transform::translate({side, 0, 0})},
                                           {1, Transform::translate({side, 1, 0}) * Transform::rotate({0, 1, 0}, 20)}});
        d.instances.push_back(instance);
      }
    }
    add_area_light_rectangle(d, Transform::translate({0, 3, 3}) * Transform::rotate({1, 0, 0}, 140), 1);
    expose(d, 0, 1);
    check_strategies_agree(d, level);
  }
}

TEST_CASE("deformation: light tracing and path tracing agree") {
  Description d = empty_scene(24, 24);
  d.sampler.sample_count = 256;
  look_at(d, {0, -6, 3}, {0, 0, 0.5f}, {0, 0, 1}, 50);
  d.integrator.max_depth = 3;
  add_rectangle(d, Transform::scale({6, 6, 1}), add_diffuse(d, 0.6f));
  add_deforming(d,
                {{0, quad({-1, 0, 0}, {1, 0, 0.3f}, {1, 0, 1}, {-1, 0, 1})},
                 {1, quad({-1, 1, 0}, {1, 0, 0.3f}, {2, 0, 1}, {-1, -1, 1.5f})}},
                add_two_sided(d, add_diffuse(d, 0.7f)));
  add_deforming(d, {{0, hairs(Curves::Basis::kBspline, {-1.5f, 0, 1})}, {1, bent_hairs(Curves::Basis::kBspline)}},
                add_diffuse(d, 0.7f));
  emit(add_deforming(d, bending_lamp()), 4);
  expose(d, 0, 1);
  check_light_tracing_agrees(d);
}

TEST_CASE("deformation: keys with different meshes are errors") {
  const auto error = [](Mesh second) {
    Description d = view_of(0, 1);
    add_deforming(d, {{0, strip(0)}, {1, std::move(second)}});
    expose(d, 0, 1);
    try {
      compile_scene(d);
    } catch (const SceneError& e) { return std::string(e.what()); }
    return std::string();
  };
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  Mesh other = strip(1);
  std::swap(other.triangles[0], other.triangles[1]);
  CHECK(has(error(other), "different triangles"));
  other = strip(1);
  other.triangles.pop_back();
  CHECK(has(error(other), "number 1 has 2, number 2 has 1"));
  other = strip(1);
  other.positions.push_back({});
  other.uvs.push_back({});
  CHECK(has(error(other), "number 1 has 4, number 2 has 5"));
  other = strip(1);
  other.normals.assign(4, {0, 0, 1});
  CHECK(has(error(other), "only some meshes of a deformation have normals"));
}

TEST_CASE("deformation: a mesh that has an area for part of the time is kept") {
  Description d = view_of(0, 64);
  // Grows out of a point
  const auto square = [](float half) {
    return quad({-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0});
  };
  look_at_point(d, {0.5f, 0, 5}, {0.5f, 0, 0}, {0, 1, 0});
  emit(add_deforming(d, {{0, square(0)}, {1, square(1)}}), 1);
  expose(d, 0, 1);
  check_mean(green(d), 0.5, kSignificance, kAllowed);
  // Vertices that are not finite at any time drop their triangles
  Mesh broken = square(1);
  broken.positions[1].x = kInfinity;
  std::get<DeformingMesh>(d.shapes[0].geometry).keys[1].mesh = broken;
  CHECK(compile_scene(d)->info().triangles == 1);
}

TEST_CASE("deformation: curves that move and widen cover the background for part of the time") {
  const double level = significance_of_each(8);
  for (const Curves::Basis basis : kBases) {
    CAPTURE(static_cast<int>(basis));
    // Of radius 0.3, from -1 to 1
    Description d = view_of(0.2f, 64);
    d.lights.push_back({ConstantLightDescription{SpectrumDescription::constant(1)}, {}});
    const MaterialId black = add_diffuse(d, 0);
    add_deforming(d, {{0, tube(basis, -1, 0.3f)}, {1, tube(basis, 1, 0.3f)}}, black);
    expose(d, 0, 1);
    check_mean(green(d), 0.7, level, kAllowed);
    // In the second quarter of the interval of the keys, from -0.5 to 0: covered from -0.1 on
    expose(d, 0.25, 0.5);
    check_mean(green(d), 0.8, level, kAllowed);
    // The radius grows from 0 to 0.5, and shrinks again
    d.shapes[0].geometry =
        DeformingCurves{{{0, tube(basis, 0, 0)}, {0.5, tube(basis, 0, 0.5f)}, {0.75, tube(basis, 0, 0)}}};
    expose(d, 0, 1);
    check_mean(green(d), 1 - 0.6 * 0.75, level, kAllowed);
    // In an instance that moves from -1 to 1 relative to curves that move from -1 to 1
    ShapeDescription curves = d.shapes[0];
    curves.geometry = DeformingCurves{{{0, tube(basis, -1, 0.3f)}, {1, tube(basis, 1, 0.3f)}}};
    d.shapes.clear();
    d.groups.emplace_back();
    d.groups[0].shapes.push_back(curves);
    InstanceDescription instance;
    instance.motion = add_motion(d, {{0, Transform::translate({-1, 0, 0})}, {1, Transform::translate({1, 0, 0})}});
    d.instances.push_back(instance);
    check_mean(green(d), 0.85, level, kAllowed);
  }
}

TEST_CASE("deformation: curves that are only displaced look like curves that an animation moves") {
  for (const Curves::Basis basis : kBases) {
    CAPTURE(static_cast<int>(basis));
    Description d = hair_scene(16);
    const Curves from = hairs(basis, {-0.5f, 0, 0}), to = hairs(basis, {0.5f, 0.2f, 0.3f});
    ShapeDescription& shape = add_shape(d, from, {}, add_hair(d));
    move(d, shape, {{0, Transform()}, {1, Transform::translate({1, 0.2f, 0.3f})}});
    expose(d, 0, 1);
    RenderOptions options;
    options.aovs = {aov_named("motion"), aov_named("normal"), aov_named("uv")};
    const Image animated = render(*compile_scene(d), options).to_image();
    shape.motion.reset();
    shape.to_world = {};
    shape.geometry = DeformingCurves{{{0, from}, {1, to}}};
    const Image deforming = render(*compile_scene(d), options).to_image();
    // The same samples give the same values, but for rounding, which changes where some paths go
    for (int channel = 0; channel < static_cast<int>(animated.channels.size()); ++channel) {
      CAPTURE(animated.channels[static_cast<std::size_t>(channel)]);
      double difference = 0, sum = 0;
      for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) {
          difference += std::fabs(double{animated.at(x, y, channel)} - double{deforming.at(x, y, channel)});
          sum += std::fabs(double{animated.at(x, y, channel)});
        }
      CHECK(sum > 0);
      CHECK(difference < 5e-3 * sum);
    }
  }
}

TEST_CASE("deformation: curves that bend give the mean of their images at fixed times") {
  constexpr int kTimes = 8;
  for (const Curves::Basis basis : kBases) {
    CAPTURE(static_cast<int>(basis));
    Description d = hair_scene(16);
    const Curves first = hairs(basis, {-0.5f, 0, 0}), last = bent_hairs(basis);
    add_deforming(d, {{0, first}, {1, last}}, add_hair(d));
    const auto mean = [&](double open, double close, std::uint32_t seed) {
      expose(d, open, close);
      RenderOptions options;
      options.seed = seed;
      const Image image = render(*compile_scene(d), options).to_image();
      double sum = 0;
      for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) sum += double{image.at(x, y, 1)} / 256;
      return sum;
    };
    MeanVariance moving, still;
    for (std::uint32_t seed = 0; seed < 8; ++seed) {
      moving.add(mean(0, 1, seed));
      double sum = 0;
      for (int i = 0; i < kTimes; ++i) sum += mean((i + 0.5) / kTimes, (i + 0.5) / kTimes, 100 + kTimes * seed + i);
      still.add(sum / kTimes);
    }
    check_same_mean(moving, still, significance_of_each(2), 8);
    // At one time, the bits are those of curves between the keys
    expose(d, 0.25, 0.25);
    const Image at_time = render(*compile_scene(d), {}).to_image();
    Curves between = first;
    for (std::size_t i = 0; i < between.points.size(); ++i) {
      const Curves::Point &a = first.points[i], &b = last.points[i];
      between.points[i] = {a.position * 0.75f + b.position * 0.25f, a.radius * 0.75f + b.radius * 0.25f};
    }
    d.shapes.back().geometry = between;
    CHECK(at_time.data == render(*compile_scene(d), {}).to_image().data);
  }
}

TEST_CASE("deformation: hits of curves are those of the curves at that time") {
  for (const Curves::Basis basis : kBases) {
    CAPTURE(static_cast<int>(basis));
    const Curves first = hairs(basis, {-0.5f, 0, 0}), last = bent_hairs(basis);
    Description d = empty_scene(4, 4);
    add_deforming(d, {{0, first}, {0.5, last}, {1, first}});
    expose(d, 0, 1);
    const auto moving = compile_scene(d);
    for (const float time : {0.2f, 0.85f}) {
      expose(d, double{time}, double{time});
      const auto still = compile_scene(d);
      int hits = 0;
      for (int i = 0; i < 64; ++i) {
        const Vec3f origin{0.3f * static_cast<float>(i % 8) - 1, 0.3f * static_cast<float>(i / 8) - 1, 5};
        const Vec3f direction{0, 0, -1};
        RayPacket packet;
        packet.set_ray(0, origin, direction);
        packet.time[0] = time;
        packet.shape[0] = kNone;
        moving->view().accel->intersect(packet, 1);
        const auto expected = trace_ray(still->view(), origin, direction);
        REQUIRE((packet.shape[0] != kNone) == expected.has_value());
        if (!expected) continue;
        ++hits;
        const auto y =
            surface_point<Scalar, true>(moving->view(), moving->view().geometry.shapes[0], packet.primitive[0],
                                        packet.u[0], packet.v[0], origin + direction * packet.t_far[0], kNone, time);
        const auto x = surface_at(still->view(), origin, direction, *expected);
        CHECK(length(y.p - x.p) < 1e-4f);
        CHECK(length(y.ng - x.ng) < 2e-3f);
        CHECK(length(y.dp_du - x.dp_du) < 2e-3f * length(x.dp_du));
        CHECK(length(y.dp_dv - x.dp_dv) < 2e-3f * length(x.dp_dv));
        CHECK(std::fabs(y.uv.y - x.uv.y) < 1e-4f);
        // The error of the time is added
        CHECK(y.offset > x.offset);
        CHECK(y.offset < 1.1f * x.offset);
      }
      CHECK(hits > 5);
    }
    // Bounds are those of all times
    CHECK(moving->view().radius > compile_scene(d)->view().radius);
  }
}

TEST_CASE("deformation: keys with different curves are errors") {
  const auto error = [](const Curves& second) {
    Description d = view_of(0, 1);
    add_deforming(d, {{0, hairs(Curves::Basis::kLinear, {})}, {1, second}});
    try {
      compile_scene(d);
    } catch (const SceneError& e) { return std::string(e.what()); }
    return std::string();
  };
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  Curves other = hairs(Curves::Basis::kLinear, {});
  CHECK(error(other).empty());
  other.points.pop_back();
  CHECK(has(error(other), "differ in their points: number 1 has 11, number 2 has 10"));
  other = hairs(Curves::Basis::kLinear, {});
  other.starts.back() = 4;
  CHECK(has(error(other), "differ in the points per curve"));
  other.starts.pop_back();
  CHECK(has(error(other), "differ in their number of curves: number 1 has 2, number 2 has 1"));
  CHECK(has(error(hairs(Curves::Basis::kBspline, {})), "different types"));
  other = hairs(Curves::Basis::kLinear, {});
  other.points[3].radius = -1;
  CHECK(has(error(other), "the radius of a curve is -1"));
  other.points[3] = {{kInfinity, 0, 0}, 1};
  CHECK(error(other).empty());
}

}  // namespace sheaf::test_deformation
