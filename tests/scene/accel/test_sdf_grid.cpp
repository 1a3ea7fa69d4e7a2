// Signed distance grids: hits against a numerical search, planes, spheres, watertightness, and errors.
#include "scene/accel/sdf_grid.h"

#include "scene/compile/compile.h"
#include "tests/support/files/mesh_files.h"
#include "tests/support/near.h"
#include "tests/support/records_testing.h"
#include "tests/support/test_transforms.h"
#include "tests/support/tiny_scenes.h"
#include "tests/support/trace_testing.h"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>

namespace sheaf::test_sdf_grid {

using namespace test;

namespace {

using Field = std::function<double(double, double, double)>;

/// A function on [0, 1]^3, sampled at the grid points.
SdfGrid sampled(std::array<int, 3> size, const Field& field, bool smooth = true) {
  SdfGrid grid{size, {}, smooth};
  for (int z = 0; z < size[2]; ++z)
    for (int y = 0; y < size[1]; ++y)
      for (int x = 0; x < size[0]; ++x)
        grid.values.push_back(static_cast<float>(field(x / (size[0] - 1.0), y / (size[1] - 1.0), z / (size[2] - 1.0))));
  return grid;
}

/// Noise of either sign inside, positive at the border: a closed surface of many cells with sharp creases.
SdfGrid noise_grid(std::array<int, 3> size) {
  SdfGrid grid{size, {}};
  std::uint32_t i = 0;
  for (int z = 0; z < size[2]; ++z)
    for (int y = 0; y < size[1]; ++y)
      for (int x = 0; x < size[0]; ++x) {
        const bool border = x == 0 || y == 0 || z == 0 || x == size[0] - 1 || y == size[1] - 1 || z == size[2] - 1;
        const float value = 2 * random4<Scalar>(91, i++, 0, 0).x - 1;
        grid.values.push_back(border ? std::fabs(value) + 0.1f : value);
      }
  return grid;
}

Field ball(double radius) {
  return [radius](double x, double y, double z) { return std::hypot(x - 0.5, y - 0.5, z - 0.5) - radius; };
}

std::unique_ptr<Scene> lone(const SdfGrid& grid, const Transform& to_world = Transform(), bool flip = false) {
  Description d = empty_scene(4, 4);
  add_shape(d, grid, to_world).flip_normals = flip;
  return compile_scene(d);
}

/// The trilinear function of a grid at a position in [0, 1]^3 by its definition, nothing outside.
std::optional<double> value_at(const SdfGrid& grid, const double* p) {
  std::size_t cell[3];
  double t[3];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double x = p[axis] * (grid.size[axis] - 1);
    if (!(x >= 0 && x <= grid.size[axis] - 1)) return std::nullopt;
    cell[axis] = static_cast<std::size_t>(std::min(std::floor(x), grid.size[axis] - 2.0));
    t[axis] = x - static_cast<double>(cell[axis]);
  }
  double sum = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    const std::size_t x = cell[0] + (i & 1), y = cell[1] + (i >> 1 & 1), z = cell[2] + (i >> 2);
    const auto width = static_cast<std::size_t>(grid.size[0]), height = static_cast<std::size_t>(grid.size[1]);
    const double w =
        ((i & 1) != 0 ? t[0] : 1 - t[0]) * ((i >> 1 & 1) != 0 ? t[1] : 1 - t[1]) * ((i >> 2) != 0 ? t[2] : 1 - t[2]);
    sum += w * double(grid.values[(z * height + y) * width + x]);
  }
  return sum;
}

/// The first sign change along a ray, by small steps and bisection.
std::optional<double> search(const SdfGrid& grid, const Transform& to_world, Vec3f origin, Vec3f direction,
                             double far) {
  const auto& m = to_world.inverse_matrix().m;
  const auto value = [&](double t) {
    const double p[3] = {origin.x + t * direction.x, origin.y + t * direction.y, origin.z + t * direction.z};
    double x[3];
    for (std::size_t i = 0; i < 3; ++i) x[i] = m[i][0] * p[0] + m[i][1] * p[1] + m[i][2] * p[2] + m[i][3];
    return value_at(grid, x);
  };
  constexpr int kSteps = 3000;
  auto before = value(0);
  for (int i = 0; i < kSteps; ++i) {
    double a = far * i / kSteps, b = far * (i + 1) / kSteps;
    const auto after = value(b);
    const bool crosses = before && after && (*before < 0) != (*after < 0);
    const bool negative = before && *before < 0;
    before = after;
    if (!crosses) continue;
    for (int step = 0; step < 60; ++step) {
      const double middle = 0.5 * (a + b);
      ((*value(middle) < 0) == negative ? a : b) = middle;
    }
    return a;
  }
  return std::nullopt;
}

}  // namespace

TEST_CASE("sdf grid: hits match a search along the ray") {
  const SdfGrid grid = noise_grid({6, 5, 4});
  for (const Transform& to_world : test_transforms()) {
    const auto scene = lone(grid, to_world);
    int hits = 0, disagreements = 0, wrong_normals = 0;
    double worst = 0;
    for (std::uint32_t i = 0; i < 300; ++i) {
      const auto u = random4<Scalar>(31, i, 0, 0), v = random4<Scalar>(31, i, 1, 0);
      const Vec3f target = to_world.point({u.x, u.y, u.z});
      const Vec3f origin =
          u.w < 0.3f ? to_world.point({v.x, v.y, v.z}) : target + random_direction(33, i) * (6.0f + 4.0f * v.w);
      const Vec3f direction = normalize(target - origin);
      const auto found = trace_ray(scene->view(), origin, direction, 0, 15);
      const auto expected = search(grid, to_world, origin, direction, 15);
      if (found.has_value() != expected.has_value() || (found && std::fabs(double(found->t) - *expected) > 1e-3)) {
        ++disagreements;
        continue;
      }
      if (!found) continue;
      ++hits;
      worst = std::max(worst, std::fabs(double(found->t) - *expected));
      const auto y = surface_at(scene->view(), origin, direction, *found);
      // Rays that hit the front come from positive values.
      const Vec3f behind = to_world.inverse().point(y.p - y.ng * 1e-3f),
                  before = to_world.inverse().point(y.p + y.ng * 1e-3f);
      const double p[3] = {behind.x, behind.y, behind.z}, q[3] = {before.x, before.y, before.z};
      wrong_normals += !(value_at(grid, p).value_or(-1) < 0 && value_at(grid, q).value_or(1) > 0);
    }
    CHECK(hits > 100);
    CHECK(disagreements <= 4);  // rays that graze the surface within a step of the search
    CHECK(worst < 2e-5);
    CHECK(wrong_normals <= 2);  // at creases sharper than the step of the finite differences
  }
}

TEST_CASE("sdf grid: planes are exact even through grid points") {
  const Vec3f axes[] = {normalize(Vec3f{1, 0.5f, -0.3f}), {1, 0, 0}, {0, 0, 1}};
  for (const Vec3f a : axes)
    for (const double offset : {0.5, 0.25, 0.47}) {  // the 5 grid points are at quarters
      const SdfGrid grid = sampled({5, 5, 5}, [&](double x, double y, double z) {
        return double(a.x) * (x - offset) + double(a.y) * (y - offset) + double(a.z) * (z - offset);
      });
      const auto scene = lone(grid);
      int hits = 0;
      for (std::uint32_t i = 0; i < 400; ++i) {
        const auto u = random4<Scalar>(41, i, 0, 0);
        const auto o = static_cast<float>(offset);
        Vec3f target{0.2f + 0.6f * u.x, 0.2f + 0.6f * u.y, 0.2f + 0.6f * u.z};
        target = target - a * dot(a, target - Vec3f{o, o, o});
        // Some rays along the axes, in the planes between cells.
        const Vec3f direction = i % 4 == 0 ? a : random_direction(42, i);
        if (i % 8 == 0) target = {a.x > 0.9f ? o : 0.5f, 0.25f, a.z > 0.9f ? o : 0.75f};
        if (max_component(abs(target - Vec3f{0.5f, 0.5f, 0.5f})) > 0.49f || std::fabs(dot(a, direction)) < 0.05f ||
            std::fabs(dot(a, target - Vec3f{o, o, o})) > 1e-6f)
          continue;
        ++hits;
        const Vec3f origin = target - direction * 2.0f;
        const auto hit = trace_ray(scene->view(), origin, direction);
        REQUIRE(hit.has_value());
        const auto y = surface_at(scene->view(), origin, direction, *hit);
        CHECK(record_difference<Vec3>(y.p, target) < 2e-5);
        CHECK(std::fabs(dot(a, y.p - Vec3f{o, o, o})) < 3e-7f);
        CHECK(dot(y.ng, a) == near(1, 1e-6));
        CHECK(dot(y.ns, a) == near(1, 1e-6));
      }
      CHECK(hits > 30);
    }
}

TEST_CASE("sdf grid: a sphere has its silhouette and positions and normals") {
  constexpr double kRadius = 0.4;
  for (const bool smooth : {false, true}) {
    const auto scene = lone(sampled({64, 64, 64}, ball(kRadius), smooth));
    constexpr int kSide = 100;
    int hits = 0;
    double off = 0, rotated = 0;
    for (int i = 0; i < kSide * kSide; ++i) {
      const int column = i % kSide, row = i / kSide;
      const Vec3f origin{(static_cast<float>(column) + 0.5f) / kSide, (static_cast<float>(row) + 0.5f) / kSide, -3};
      const auto hit = trace_ray(scene->view(), origin, {0, 0, 1});
      if (!hit) continue;
      ++hits;
      const auto y = surface_at(scene->view(), origin, {0, 0, 1}, *hit);
      const Vec3f from = y.p - Vec3f{0.5f, 0.5f, 0.5f};
      off = std::max(off, std::fabs(double(length(from)) - kRadius));
      rotated = std::max(rotated, double(length(normalize(from) - y.ns)));
      CHECK(y.ng.z < 0);
    }
    const double area = double(hits) / (kSide * kSide);
    CHECK(area == near(3.14159265 * kRadius * kRadius, 0.01));
    CHECK(off < 1.6e-4);  // 1/8 of the squared cell width times the sum of both curvatures
    CHECK(rotated < (smooth ? 0.004 : 0.03));
  }
}

TEST_CASE("sdf grid: positions and normals match Mitsuba") {
  constexpr int kSide = 20;
  const auto make = [](bool smooth) {
    return sampled(
        {kSide, kSide, kSide},
        [](double x, double y, double z) {
          return std::hypot(x - 0.5, y - 0.5, z - 0.5) - 0.3 +
                 0.05 * std::sin(12 * x) * std::sin(12 * y) * std::sin(12 * z);
        },
        smooth);
  };
  const Transform to_world = Transform::translate({-1, -1, 1.5f}) * Transform::scale({2, 2, 2});
  const auto smooth = lone(make(true), to_world), analytic = lone(make(false), to_world);
  // Mitsuba 3.9.1, scalar_rgb.
  const struct {
    Vec3f direction, p, ng, ns;
  } rays[] = {{{0.05f, 0.06f, 1},
               {0.0964799f, 0.115776f, 1.9296f},
               {0.266776f, 0.238789f, -0.933708f},
               {0.253971f, 0.251331f, -0.933987f}},
              {{-0.1f, 0.02f, 1},
               {-0.193897f, 0.0387793f, 1.93897f},
               {-0.333788f, -0.24358f, -0.910634f},
               {-0.314986f, -0.182879f, -0.93131f}},
              {{0.12f, -0.13f, 1},
               {0.241581f, -0.261713f, 2.01318f},
               {0.56065f, -0.597585f, -0.573205f},
               {0.577055f, -0.654332f, -0.488731f}}};
  for (const auto& ray : rays) {
    const Vec3f direction = normalize(ray.direction);
    for (const Scene* scene : {smooth.get(), analytic.get()}) {
      const auto hit = trace_ray(scene->view(), {0, 0, 0}, direction);
      REQUIRE(hit.has_value());
      const auto y = surface_at(scene->view(), {0, 0, 0}, direction, *hit);
      CHECK(record_difference<Vec3>(y.p, ray.p) < 1e-5);
      CHECK(record_difference<Vec3>(y.ng, ray.ng) < 2e-5);
      CHECK(record_difference<Vec3>(y.ns, scene == smooth.get() ? ray.ns : ray.ng) < 2e-5);
    }
  }
}

TEST_CASE("sdf grid: shading normals are optionally smooth across cells") {
  const Field field = [](double x, double y, double z) { return std::sin(3 * x) + y * y + 0.8 * z - 1.2; };
  for (const bool smooth : {false, true}) {
    const auto scene = lone(sampled({9, 7, 8}, field, smooth), Transform::scale({2, 1, 1.5f}));
    double jump = 0;
    int met = 0;
    for (std::uint32_t i = 0; i < 2000; ++i) {
      // Pairs of close rays.
      const auto u = random4<Scalar>(51, i, 0, 0);
      const Vec3f origin{0.1f + 1.8f * u.x, 0.1f + 0.8f * u.y, 5}, next = origin + Vec3f{2e-3f, 1e-3f, 0};
      const auto a = trace_ray(scene->view(), origin, {0, 0, -1}), b = trace_ray(scene->view(), next, {0, 0, -1});
      if (!a || !b) continue;
      ++met;
      jump = std::max(jump, double(length(surface_at(scene->view(), origin, {0, 0, -1}, *a).ns -
                                          surface_at(scene->view(), next, {0, 0, -1}, *b).ns)));
    }
    CHECK(met > 500);
    if (smooth)
      CHECK(jump < 3e-2);
    else
      CHECK(jump > 0.1);
  }
}

TEST_CASE("sdf grid: rays enter and leave alternately at every position and scale") {
  const SdfGrid grid = noise_grid({8, 7, 9});
  for (const float size : {1e-3f, 1.0f, 1e4f})
    for (const float away : {0.0f, 20.0f}) {
      CAPTURE(size);
      CAPTURE(away);
      const Transform to_world = Transform::translate(Vec3f{1, 2, -1} * (away * size)) *
                                 Transform::rotate({1, 2, 3}, 40) * Transform::scale({size, 1.3f * size, 0.8f * size});
      const auto scene = lone(grid, to_world);
      int crossings = 0, wrong = 0;
      for (std::uint32_t i = 0; i < 2000; ++i) {
        const auto u = random4<Scalar>(61, i, 0, 0);
        Vec3f origin = to_world.point({u.x, u.y, u.z}) + random_direction(62, i) * (3 * size);
        bool inside = false;
        for (int step = 0; step < 100; ++step) {
          // Continues in a new direction from every other hit, as light does.
          Vec3f direction = step == 0 ? normalize(to_world.point({u.x, u.y, u.z}) - origin)
                                      : random_direction(63, 100 * i + static_cast<std::uint32_t>(step));
          const auto hit = trace_ray(scene->view(), origin, direction);
          wrong += !hit && inside;
          if (!hit) break;
          const auto y = surface_at(scene->view(), origin, direction, *hit);
          wrong += (dot(y.ng, direction) > 0) != inside && std::fabs(dot(y.ng, direction)) > 1e-2f;
          ++crossings;
          direction = random_direction(63, 100 * i + static_cast<std::uint32_t>(step) + 1);
          origin = offset_origin<Scalar>(y.p, y.ng, y.offset, direction);
          inside = dot(y.ng, direction) < 0;
        }
      }
      CHECK(crossings > 4000);
      // At creases sharper than the ray offset.
      CHECK(wrong == 0);
    }
}

namespace {

/// A sphere, a cube, and two grids, of which the first has flipped normals; shapes 1 and 3 are the grids.
std::vector<ShapeDescription> mixed_shapes() {
  const SdfGrid grid = sampled({12, 10, 9}, ball(0.35));
  Description all;
  add_shape(all, SphereShape{{1.2f, 0.5f, 0.5f}, 0.3f}, Transform());
  add_shape(all, grid, Transform::scale({1, 1.2f, 1})).flip_normals = true;
  add_shape(all, CubeShape{}, Transform::translate({-0.5f, 0.5f, 0.5f}) * Transform::scale({0.2f, 0.2f, 0.2f}));
  add_shape(all, grid, Transform::translate({0, 0, -1}));
  return std::move(all.shapes);
}

/// Ray `i` of 2000 towards these shapes.
struct TestRay {
  Vec3f origin, direction;
  explicit TestRay(std::uint32_t i) {
    const Vec3f target = Vec3f{0.4f, 0.6f, 0.2f} + random_direction(72, i) * 0.6f;
    origin = target + random_direction(71, i) * 6.0f;
    direction = normalize(target - origin);
  }
};

}  // namespace

TEST_CASE("sdf grid: flipped normals, instances, and beside other shapes") {
  Description plain = empty_scene(4, 4), instanced = empty_scene(4, 4);
  plain.shapes = mixed_shapes();
  instanced.groups.emplace_back();
  instanced.groups[0].shapes = mixed_shapes();
  const Transform position =
      Transform::translate({1, 2, 3}) * Transform::rotate({1, 1, 0}, 50) * Transform::scale({2, 1.5f, 2});
  InstanceDescription instance;
  for (std::size_t i = 0; i < 12; ++i) instance.to_world[i] = position.matrix().m[i / 4][i % 4];
  instanced.instances.push_back(instance);
  const auto a = compile_scene(plain), b = compile_scene(instanced);
  int on_grid[2] = {0, 0};
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const auto [origin, direction] = TestRay(i);
    const auto x = trace_ray(a->view(), origin, direction);
    const Vec3f origin2 = position.point(origin), direction2 = position.vector(direction);
    const auto y = trace_ray(b->view(), origin2, direction2);
    if (!x || !y) continue;
    const auto p = surface_at(a->view(), origin, direction, *x), q = surface_at(b->view(), origin2, direction2, *y);
    if (std::fabs(dot(p.ng, direction)) < 0.2f) continue;
    if (x->shape % 2 == 1) {
      ++on_grid[x->shape / 2];
      CHECK((dot(p.ng, direction) > 0) == (x->shape == 1));
      CHECK(dot(p.ng, p.ns) > 0.8f);
      CHECK(p.uv.x == 0.0f);
    }
    CHECK(x->shape == y->shape);
    CHECK(record_difference<Vec3>(q.p, position.point(p.p)) < 1e-4);
    CHECK(record_difference<Vec3>(q.ng, normalize(position.normal(p.ng))) < 1e-3);
    CHECK(record_difference<Vec3>(q.ns, normalize(position.normal(p.ns))) < 1e-3);
  }
  CHECK(on_grid[0] > 200);
  CHECK(on_grid[1] > 200);
}

TEST_CASE("sdf grid: lanes together are as single ones, also beside other shapes") {
  Description d = empty_scene(4, 4);
  d.shapes = mixed_shapes();
  const auto scene = compile_scene(d);
  const SceneView view = scene->view();
  std::vector<std::pair<TracedHit, Vec3f>> hits;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const auto [origin, direction] = TestRay(i);
    const auto hit = trace_ray(view, origin, direction);
    if (!hit || std::fabs(dot(surface_at(view, origin, direction, *hit).ng, direction)) < 0.2f) continue;
    hits.push_back({*hit, origin + direction * hit->t});
  }
  CHECK(hits.size() > 400);
  double worst = 0;
  for (std::size_t first = 0; first + kWidth <= hits.size(); first += kWidth) {
    const auto hit_of = [&](int lane) -> const TracedHit& {
      return hits[first + static_cast<std::size_t>(lane)].first;
    };
    const WideUint shape = wide_uints([&](int lane) { return hit_of(lane).shape; }),
                   primitive = wide_uints([&](int lane) { return hit_of(lane).primitive; });
    const WideFloat u = wide_floats([&](int lane) { return hit_of(lane).u; }),
                    v = wide_floats([&](int lane) { return hit_of(lane).v; });
    const auto at = wide_record<Vec3>([&](int lane) { return hits[first + static_cast<std::size_t>(lane)].second; });
    const auto y = surface_point<Wide, true>(view, gather_rows<Wide>(view.geometry.shapes, shape), primitive, u, v, at,
                                             Uint<Wide>(kNone), WideFloat(0.0f));
    for (int lane = 0; lane < kWidth; ++lane) {
      const auto& [hit, position_of_hit] = hits[first + static_cast<std::size_t>(lane)];
      const auto one = surface_point<Scalar, true>(view, view.geometry.shapes[hit.shape], hit.primitive, hit.u, hit.v,
                                                   position_of_hit, kNone, 0.0f);
      worst = std::max(worst, record_difference<Vec3>(lane_record(y.p, lane), one.p));
      worst = std::max(worst, record_difference<Vec3>(lane_record(y.ng, lane), one.ng));
      worst = std::max(worst, record_difference<Vec3>(lane_record(y.ns, lane), one.ns));
    }
  }
  CHECK(worst < 1e-5);
}

TEST_CASE("sdf grid: unsupported grids are errors and grids without a surface are dropped") {
  const SdfGrid good = sampled({3, 3, 3}, ball(0.3));
  const auto error = [](const SdfGrid& grid, auto&& change) {
    Description d = empty_scene(4, 4);
    change(add_shape(d, grid, Transform()));
    return error_of([&] { compile_scene(d); });
  };
  const auto keep = [](ShapeDescription&) {};
  CHECK(error(good, keep).empty());
  CHECK(contains(error(good, [](ShapeDescription& s) { emit(s, 1); }), "cannot emit light"));
  SdfGrid bad = good;
  bad.size = {3, 9, 1};
  CHECK(contains(error(bad, keep), "1 points along an axis (expected 2"));
  bad = good;
  bad.values.pop_back();
  CHECK(contains(error(bad, keep), "26 values (expected 27)"));
  bad = good;
  bad.values[4] = kInfinity;
  CHECK(contains(error(bad, keep), "not finite"));
  const auto nothing = lone(sampled({3, 3, 3}, ball(-1)));
  REQUIRE(nothing->warnings().size() == 1);
  CHECK(contains(nothing->warnings()[0], "no surface"));
  CHECK(nothing->info().shapes == 0);
  CHECK(lone(good)->info().sdf_cells == 8);
}

}  // namespace sheaf::test_sdf_grid
