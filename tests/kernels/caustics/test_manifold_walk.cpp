// Manifold walks: chains of specular vertices against closed forms and finite differences, and the casters and lights
// of a scene.
#include "kernels/caustics/chain_light.h"
#include "scene/compile/compile.h"
#include "tests/support/capture.h"
#include "tests/support/motion_testing.h"
#include "tests/support/near.h"
#include "tests/support/tiny_scenes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

namespace sheaf::test_manifold_walk {

namespace {

/// A vertex with the normal +z.
ChainStart start_at(Vec3f at) { return {at, {0, 0, 1}, 1e-5f}; }

/// A scene with its casters, and a tracer of chains.
struct Traced {
  explicit Traced(const Description& d)
      : scene(compile_scene(d, {})), casters(scene->view()), tracer(scene->view(), casters) {}
  std::unique_ptr<Scene> scene;
  CausticCasters casters;
  ChainTracer tracer;
};

ChainType type_of(std::initializer_list<bool> refractions) {
  ChainType type;
  for (const bool refraction : refractions) type.add(refraction);
  return type;
}

/// A sphere of radius 1 by latitude and longitude with smooth normals.
Mesh smooth_ball(std::uint32_t rings, std::uint32_t segments) {
  Mesh mesh;
  for (std::uint32_t i = 0; i <= rings; ++i)
    for (std::uint32_t j = 0; j < segments; ++j) {
      const double theta = 3.14159265 * (i + 0.01) / (rings + 0.02), phi = 2 * 3.14159265 * j / segments;
      mesh.positions.push_back({static_cast<float>(std::sin(theta) * std::cos(phi)),
                                static_cast<float>(std::sin(theta) * std::sin(phi)),
                                static_cast<float>(std::cos(theta))});
    }
  mesh.normals = mesh.positions;
  for (std::uint32_t i = 0; i < rings; ++i)
    for (std::uint32_t j = 0; j < segments; ++j) {
      const std::uint32_t a = i * segments + j, b = i * segments + (j + 1) % segments;
      mesh.triangles.push_back({a, a + segments, b + segments});
      mesh.triangles.push_back({a, b + segments, b});
    }
  return mesh;
}

/// Solid angle of the chain's first direction per area across its last ray at the target, by central differences.
double ratio_by_differences(Traced& t, const ChainStart& start, const ConnectedChain& chain, Vec3f target) {
  const auto frame = Frame<Scalar>::from_normal(chain.direction), last = Frame<Scalar>::from_normal(chain.last);
  constexpr float kStep = 1e-3f;
  double moved[2][2];
  for (int i = 0; i < 2; ++i) {
    Vec3f at[2];
    for (int side = 0; side < 2; ++side) {
      const Vec3f step = (i == 0 ? frame.s : frame.t) * (side == 0 ? -kStep : kStep);
      DifferentialRay ray = start.ray(normalize(chain.direction + step));
      REQUIRE(t.tracer.follow(chain.type, ray));
      // The ray in the plane through the target across the unperturbed ray
      at[side] = ray.origin + ray.direction * (dot(target - ray.origin, chain.last) / dot(ray.direction, chain.last));
    }
    const Vec3f d = (at[1] - at[0]) / (2 * kStep);
    moved[i][0] = static_cast<double>(dot(d, last.s)), moved[i][1] = static_cast<double>(dot(d, last.t));
  }
  return 1 / std::fabs(moved[0][0] * moved[1][1] - moved[0][1] * moved[1][0]);
}

}  // namespace

TEST_CASE("manifold walks: a flat mirror shows the image of the light") {
  Description d = empty_scene(1, 1);
  add_rectangle(d, Transform::scale({5, 5, 1}), add_mirror(d));
  Traced t(d);
  const ChainStart start = start_at({-0.4f, 0.3f, 1.2f});
  const Vec3f light{1.1f, -0.7f, 2.5f}, image{light.x, light.y, -light.z};
  const auto chain =
      walk_to_target(t.tracer, start, {light, false}, type_of({false}), normalize(Vec3f{0.1f, 0.2f, -1}));
  REQUIRE(chain);
  const Vec3f to = image - start.p;
  CHECK(length(chain->direction - normalize(to)) < 1e-5f);
  CHECK(chain->solid_angle_ratio == near(1 / static_cast<double>(dot(to, to)), 1e-4));
  // A light in a direction
  const Vec3f sun = normalize(Vec3f{0.3f, 0.5f, 1});
  const auto to_sun = walk_to_target(t.tracer, start, {sun, true}, type_of({false}), {0, 0, -1});
  REQUIRE(to_sun);
  CHECK(length(to_sun->direction - Vec3f{sun.x, sun.y, -sun.z}) < 1e-5f);
  CHECK(to_sun->solid_angle_ratio == near(1, 1e-4));
  // There is no refraction at a mirror, and nothing behind it.
  CHECK_FALSE(walk_to_target(t.tracer, start, {light, false}, type_of({true}), {0, 0, -1}));
  CHECK_FALSE(walk_to_target(t.tracer, start, {{1, 1, -2}, false}, type_of({false}), {0, 0, -1}));
}

TEST_CASE("manifold walks: a slab of glass displaces the light by Snell's law") {
  Description d = empty_scene(1, 1);
  add_shape(d, CubeShape{}, Transform::translate({0, 0, 1}) * Transform::scale({20, 20, 0.5f}), add_glass(d, 1.5f));
  Traced t(d);
  const ChainStart start = start_at({0, 0, 0});
  const Vec3f light{1.3f, 0, 3};
  const auto chain = walk_to_target(t.tracer, start, {light, false}, type_of({true, true}), {0, 0, 1});
  REQUIRE(chain);
  // Offsets across 2 m of air and 1 m of glass add up to the light's.
  const double sine = static_cast<double>(chain->direction.x), inside = sine / 1.5;
  const double air = 2 * sine / std::sqrt(1 - sine * sine), glass = inside / std::sqrt(1 - inside * inside);
  CHECK(air + glass == near(1.3, 1e-4));
  // dA = x dx dphi at the light's height, seen under the cosine of the ray; dw = sine dtheta dphi.
  const double cosine = std::sqrt(1 - sine * sine), inside_cosine = std::sqrt(1 - inside * inside);
  const double dx = 2 / (cosine * cosine) + cosine / 1.5 / std::pow(inside_cosine, 3);
  CHECK(chain->solid_angle_ratio == near(sine / (1.3 * dx * cosine), 1e-3));
}

TEST_CASE("manifold walks: the solid angle ratio is that of finite differences on curved shapes") {
  const auto add_cylinder = [](Description& d, MaterialId m) {
    add_shape(d, CylinderShape{{0, 0, -3}, {0, 0, 3}, 1}, Transform(), m);
  };
  const auto add_ellipsoid = [](Description& d, MaterialId m) {
    add_shape(d, SphereShape{{0, 0, 0}, 1}, Transform::rotate({1, 1, 0}, 30) * Transform::scale({1, 0.8f, 1.3f}), m);
  };
  const auto add_ball = [](Description& d, MaterialId m) { add_sphere(d, {0, 0, 0}, 1, m); };
  const auto add_inverted_ball = [](Description& d, MaterialId m) {
    add_sphere(d, {0, 0, 0}, 1, m).flip_normals = true;
  };
  const auto add_inverted_cylinder = [](Description& d, MaterialId m) {
    add_shape(d, CylinderShape{{0, 0, -3}, {0, 0, 3}, 1}, Transform(), m).flip_normals = true;
  };
  const auto add_mirrored_ellipsoid = [](Description& d, MaterialId m) {
    add_shape(d, SphereShape{{0, 0, 0}, 1}, Transform::rotate({1, 1, 0}, 30) * Transform::scale({-1, 0.8f, 1.3f}), m)
        .flip_normals = true;
  };
  const auto add_two_sided_ball = [](Description& d, MaterialId m) {
    add_sphere(d, {0, 0, 0}, 1, add_two_sided(d, m)).flip_normals = true;
  };
  const auto add_mesh = [](Description& d, MaterialId m) { add_shape(d, smooth_ball(6, 9), Transform(), m); };
  // Round at half of the exposure only, and elsewhere before
  const auto add_moving = [](Description& d, MaterialId m) {
    move(d, add_sphere(d, {0, 0, 0}, 1, m),
         {{0, Transform::translate({2, 0, 3}) * Transform::scale({0.6f, 1, 2})},
          {1, Transform::translate({-2, 0, -3}) * Transform::scale({1.2f, 0.8f, 0.4f})}});
    expose(d, 0, 1);
  };
  const auto add_deforming = [](Description& d, MaterialId m) {
    Mesh first = smooth_ball(6, 9), last = first;
    for (std::size_t i = 0; i < first.positions.size(); ++i) {
      first.positions[i].z -= 0.6f, last.positions[i].z += 0.6f;
      first.positions[i].x *= 0.7f, last.positions[i].x *= 1.3f;
    }
    for (Vec3f& n : last.normals) n = normalize(Vec3f{n.x, 0.6f * n.y, n.z});
    add_shape(d, DeformingMesh{{{0, first}, {1, last}}}, Transform(), m);
    expose(d, 0, 1);
  };
  struct Case {
    const char* name;
    void (*add)(Description&, MaterialId);
    bool mirror;
    ChainType type;
  };
  const ChainType reflected = type_of({false}), through = type_of({true, true}), around = type_of({true, false, true});
  for (const Case& c : {Case{"mirror ball", add_ball, true, reflected},
                        {"glass ball", add_ball, false, through},
                        {"glass ball, reflected inside", add_ball, false, around},
                        {"mirror ellipsoid", add_ellipsoid, true, reflected},
                        {"glass ellipsoid", add_ellipsoid, false, through},
                        {"mirror cylinder", add_cylinder, true, reflected},
                        {"glass cylinder", add_cylinder, false, through},
                        {"inverted glass ball", add_inverted_ball, false, through},
                        {"inverted glass cylinder", add_inverted_cylinder, false, through},
                        {"mirrored and inverted glass ellipsoid", add_mirrored_ellipsoid, false, through},
                        {"inverted two-sided mirror ball", add_two_sided_ball, true, reflected},
                        {"mirror mesh", add_mesh, true, reflected},
                        {"glass mesh", add_mesh, false, through},
                        {"moving glass ball", add_moving, false, through},
                        {"deforming glass mesh", add_deforming, false, through}}) {
    CAPTURE(c.name);
    Description d = empty_scene(1, 1);
    c.add(d, c.mirror ? add_mirror(d) : add_glass(d, 1.4f));
    Traced t(d);
    t.tracer.set_time(0.5f);
    std::mt19937 random(7);
    std::uniform_real_distribution<float> u(-1, 1);
    int compared = 0, equal = 0;
    for (int i = 0; i < 300; ++i) {
      // Aim at a random point of a random chain, so that a solution exists.
      const ChainStart start = start_at({3 + u(random), u(random), u(random)});
      const Vec3f aim = normalize(Vec3f{0.8f * u(random), 0.8f * u(random), 0.8f * u(random)} - start.p);
      DifferentialRay ray = start.ray(aim);
      if (!t.tracer.follow(c.type, ray)) continue;
      const Vec3f target = ray.origin + ray.direction * (2 + u(random));
      const Vec3f aside = normalize(aim + Vec3f{u(random), u(random), u(random)} * 0.003f);
      const auto chain = walk_to_target(t.tracer, start, {target, false}, c.type, aside);
      if (!chain) continue;
      CHECK(length(cross(target - chain->origin, chain->last)) < 2e-3f);
      // Differences are inaccurate where the ratio changes fast: near caustics, edges of triangles and the horizon.
      if (chain->solid_angle_ratio > 1) continue;
      DifferentialRay wide =
          start.ray(normalize(chain->direction + Frame<Scalar>::from_normal(chain->direction).s * 0.002f));
      if (!t.tracer.follow(c.type, wide)) continue;
      const double expected = ratio_by_differences(t, start, *chain, target);
      ++compared;
      if (std::fabs(static_cast<double>(chain->solid_angle_ratio) / expected - 1) < 0.02) ++equal;
    }
    CAPTURE(equal);
    CHECK(compared > 40);
    CHECK(equal >= 0.9 * compared);
  }
}

TEST_CASE("manifold walks: seeds find all chains of a mirror ball and a glass ball") {
  Description d = empty_scene(1, 1);
  add_sphere(d, {0, 0, 0}, 1, add_glass(d));
  add_sphere(d, {0, 3, 0}, 1, add_mirror(d));
  add_point_light(d, {-3, 0.1f, 0}, 1);
  Traced t(d);
  const ChainStart start = start_at({4, 0.2f, 0.1f});
  MediumRandom random(1, 2, 3, 4, MediumStream::kCaustics);
  const auto end = sample_chain_light(t.scene->view(), t.casters, start.p, 0, {}, random);
  REQUIRE(end);
  CHECK(end->pdf == 1);
  int straight = 0, mirrored = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec3f towards = sample_seed_direction(t.tracer, start, end->target, random);
    if (!is_finite(towards)) continue;
    const auto seed = sample_seed_type(t.tracer, start, end->target, towards, kMaxChainLength, random);
    if (!seed) continue;
    const auto chain = walk_to_target(t.tracer, start, end->target, seed->type, seed->direction);
    if (!chain) continue;
    CHECK(is_same_chain(*chain, *chain));
    CHECK(length(cross(end->target.position - chain->origin, chain->last)) < 1e-2f);
    if (chain->type == type_of({true, true})) ++straight;
    if (chain->type == type_of({false}) && chain->direction.y > 0.3f) ++mirrored;
  }
  CHECK(straight > 20);
  CHECK(mirrored > 10);
}

TEST_CASE("manifold walks: casters are smooth and untextured shapes that do not emit") {
  Description d = empty_scene(1, 1);
  DielectricDescription rough;
  rough.roughness = RoughnessDescription{RoughnessDescription::Distribution::kGgx, 0.2f, 0.2f};
  const MaterialId diffuse = add_diffuse(d, 0.5f), glass = add_glass(d), mirror = add_mirror(d);
  const MaterialId frosted = add_material(d, rough), both = add_two_sided(d, mirror);
  const MaterialId half = add_material(d, TwoSidedDescription{mirror, diffuse});
  for (const MaterialId m : {diffuse, glass, mirror, frosted, both, half}) add_sphere(d, {0, 0, 0}, 1, m);
  emit(add_sphere(d, {0, 0, 0}, 1, mirror), 1);
  Traced t(d);
  const bool expected[] = {false, true, true, false, true, false, false};
  for (std::uint32_t i = 0; i < std::size(expected); ++i) {
    CAPTURE(i);
    CHECK(t.casters.is_caster(i, kNone) == expected[i]);
    CHECK_FALSE(t.casters.is_caster(i, 0));
  }
  CHECK_FALSE(t.casters.is_caster(kNone, kNone));
  CHECK(t.casters.has_glass());
  CHECK_FALSE(t.casters.empty());
  // Light from the environment only
  Description sky = empty_scene(1, 1);
  add_sphere(sky, {0, 0, 0}, 1, add_glass(sky));
  add_constant_light(sky, 1);
  CHECK(Traced(sky).casters.empty());
}

}  // namespace sheaf::test_manifold_walk
