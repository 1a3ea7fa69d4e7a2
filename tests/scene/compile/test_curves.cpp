// Round curves: their files, and hits against cylinders, Mitsuba 3 and splines evaluated here.
#include "scene/compile/compile.h"
#include "scene/formats/curve_file.h"
#include "scene/formats/hair_file.h"
#include "tests/support/files/mesh_files.h"
#include "tests/support/light_testing.h"
#include "tests/support/near.h"
#include "tests/support/records_testing.h"
#include "tests/support/tiny_scenes.h"
#include "tests/support/trace_testing.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>

namespace sheaf::test_curves {

using namespace test;

namespace {

Curves read_curves(const std::string& text, Curves::Basis basis = Curves::Basis::kLinear) {
  const TemporaryFile file("curve.txt", text);
  return read_curve_file(file.path(), basis);
}

Curves read_hairs(const std::string& bytes, const HairReading& reading = {}) {
  const TemporaryFile file("wig.hair", bytes);
  return read_hair_file(file.path(), reading);
}

std::string word(std::uint32_t value) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xffu);
  return bytes;
}
std::string number(float value) { return word(std::bit_cast<std::uint32_t>(value)); }
std::string point(float x, float y, float z) { return number(x) + number(y) + number(z); }

Curves one_curve(Curves::Basis basis, std::vector<Curves::Point> points) { return {basis, std::move(points), {0}}; }

std::unique_ptr<Scene> lone(const Curves& curves, const Transform& to_world = Transform()) {
  Description d = empty_scene(4, 4);
  add_shape(d, curves, to_world);
  return compile_scene(d);
}

bool is_close(Vec3f a, Vec3f b, float tolerance) { return max_component(abs(a - b)) <= tolerance; }

/// Position and radius of a uniform cubic B-spline by de Boor's recursion.
std::array<double, 4> de_boor(const std::vector<Curves::Point>& points, std::size_t first, double t) {
  std::array<std::array<double, 4>, 4> d{};
  for (std::size_t k = 0; k < 4; ++k) {
    const Curves::Point& q = points[first + k];
    d[k] = {q.position.x, q.position.y, q.position.z, q.radius};
  }
  for (std::size_t level = 1; level <= 3; ++level)
    for (std::size_t j = 3; j >= level; --j)
      for (std::size_t c = 0; c < 4; ++c) {
        const double alpha = (t + 3.0 - static_cast<double>(j)) / static_cast<double>(4 - level);
        d[j][c] = (1 - alpha) * d[j - 1][c] + alpha * d[j][c];
      }
  return d[3];
}

}  // namespace

TEST_CASE("curve files: points are lines of four numbers and empty lines separate curves") {
  const Curves two = read_curves("0 0 0 0.1\r\n1 +2 3e0 .2\r\n\r\n\r\n 4 5 6 0\n7\t8 9 1\n10 11 12 2");
  CHECK(two.starts == std::vector<std::uint32_t>{0, 2});
  REQUIRE(two.points.size() == 5);
  CHECK(two.points[1].position == Vec3f{1, 2, 3});
  CHECK(two.points[1].radius == 0.2f);
  CHECK(two.points[4].radius == 2);
  CHECK(read_curves("0 0 0 1\n0 0 1 1\n0 0 2 1\n0 0 3 1\n\n", Curves::Basis::kBspline).points.size() == 4);
}

TEST_CASE("curve files: malformed files are errors with a line number") {
  const auto error = [](const std::string& text, Curves::Basis basis = Curves::Basis::kLinear) {
    return error_of([&] { read_curves(text, basis); });
  };
  CHECK(contains(error("0 0 0 1\n0 0 1\n"), "curve.txt:2: expected 4 finite numbers (x y z radius), found '0 0 1'"));
  CHECK(contains(error("0 0 0 1\n0 0 1 1 1\n"), ":2: expected 4 finite numbers"));
  CHECK(contains(error("0 0 0 1\n\n"), ":2: the curve that ends here has 1 points (expected at least 2)"));
  CHECK(contains(error("0 0 0 1\n0 0 1 1\n0 0 2 1", Curves::Basis::kBspline), ":3: the curve that ends here has 3"));
  CHECK(contains(error("0 0 0 -1\n"), ":1: the radius -1"));
  for (const char* bad : {"0 0 nan 1", "0 inf 0 1", "0 1e99 0 1", "0 0 x 1", "0 0 1,5 1", "0x1 0 0 1", "v 0 0 0"})
    CHECK(contains(error(std::string("0 0 0 1\n") + bad), ":2: expected 4 finite numbers"));
  CHECK(contains(error(std::string(100'000, '7')), "777...'"));
  CHECK(contains(error(""), "no curve"));
  CHECK(contains(error("\n \n\r\n"), "no curve"));
  CHECK(
      contains(error_of([] { read_curve_file("/nowhere/curve.txt", Curves::Basis::kLinear); }), "/nowhere/curve.txt"));
}

TEST_CASE("hair files: text and binary files give the same curves") {
  const Curves text = read_hairs("# two hairs\n0 0 0\n0 0 1\n1 0 1\n\n5 5 5\n# between\n2 0 0\n2 1 0\n");
  CHECK(text.starts == std::vector<std::uint32_t>{0, 3});
  REQUIRE(text.points.size() == 5);
  CHECK(text.points[2].position == Vec3f{1, 0, 1});
  CHECK(text.points[3].radius == 0.025f);
  CHECK(text.basis == Curves::Basis::kLinear);
  const std::string gap = number(kInfinity);
  const Curves binary = read_hairs("BINARY_HAIR" + word(6) + point(0, 0, 0) + point(0, 0, 1) + point(1, 0, 1) + gap +
                                   point(5, 5, 5) + gap + point(2, 0, 0) + point(2, 1, 0));
  CHECK(binary.starts == text.starts);
  REQUIRE(binary.points.size() == text.points.size());
  for (std::size_t i = 0; i < 5; ++i) CHECK(binary.points[i].position == text.points[i].position);
}

TEST_CASE("hair files: nearly straight points and a fraction of the hairs are removed") {
  const std::string bent = "0 0 0\n0 0 1\n0 0.01 2\n0 0.01 2\n0 0.03 3\n1 0.03 3\n";
  CHECK(read_hairs(bent).points.size() == 3);
  HairReading all;
  all.angle_threshold = 0.1f;
  CHECK(read_hairs(bent, all).points.size() == 5);
  std::string many;
  for (int i = 0; i < 4000; ++i) many += "0 0 " + std::to_string(i) + "\n1 0 0\n\n";
  HairReading reduced;
  reduced.reduction = 0.75f;
  const Curves few = read_hairs(many, reduced);
  CHECK(std::abs(static_cast<double>(few.starts.size()) - 1000) < 5 * std::sqrt(4000 * 0.75 * 0.25));
  CHECK(few.points[0].radius == near(0.1f));
}

TEST_CASE("hair files: truncated and malformed and inconsistent files are errors") {
  const auto error = [](const std::string& bytes) { return error_of([&] { read_hairs(bytes); }); };
  CHECK(contains(error("0 0 0\n0 0\n"), "wig.hair:2: expected 3 finite numbers (x y z), found '0 0'"));
  CHECK(contains(error(""), "no hair"));
  CHECK(contains(error("1 2 3\n\n4 5 6\n"), "no hair of two points"));
  CHECK(contains(error("BINARY_HAIR"), "no number of points"));
  CHECK(contains(error("BINARY_HAIR\1"), "no number of points"));
  CHECK(contains(error("BINARY_HAIR" + word(0)), "no hair"));
  const std::string whole = "BINARY_HAIR" + word(2) + point(0, 0, 0) + point(0, 0, 1);
  CHECK(error(whole).empty());
  for (std::size_t size = 15; size < whole.size(); ++size) CHECK(contains(error(whole.substr(0, size)), "truncated"));
  CHECK(contains(error("BINARY_HAIR" + word(0xffffffffu) + point(0, 0, 0)), "ends within point 2"));
  CHECK(contains(error("BINARY_HAIR" + word(2) + point(0, 0, 0) + number(kInfinity)), "ends within point 2"));
  CHECK(contains(error("BINARY_HAIR" + word(1) + point(0, std::nanf(""), 0)), "point 1 is not finite"));
}

TEST_CASE("curves: straight curves are cylinders") {
  const Transform transform = Transform::translate({0.5f, -0.25f, 2}) * Transform::rotate({2, -1, 2}, 40);
  const float r = 0.3f;
  const auto straight = [&](Curves::Basis basis, int from, int to) {
    Curves curves = one_curve(basis, {});
    for (int i = from; i <= to; ++i) curves.points.push_back({{0, 0, static_cast<float>(i)}, r});
    return curves;
  };
  Description d = empty_scene(4, 4);
  add_shape(d, CylinderShape{{0, 0, -1}, {0, 0, 1}, r}, transform);
  const auto cylinder = compile_scene(d);
  const std::unique_ptr<Scene> curves[] = {lone(straight(Curves::Basis::kLinear, -1, 1), transform),
                                           lone(straight(Curves::Basis::kBspline, -2, 2), transform)};
  int compared = 0;
  for (std::uint32_t i = 0; i < 3000; ++i) {
    const Vec3f target = transform.point(random_direction(61, i) * 0.8f),
                origin = transform.point(random_direction(62, i) * 5.0f), direction = normalize(target - origin);
    const auto expected = trace_ray(cylinder->view(), origin, direction);
    if (!expected) continue;
    const auto x = surface_at(cylinder->view(), origin, direction, *expected);
    if (dot(x.ng, direction) > -0.05f) continue;  // the inside, seen through an end, and edges
    for (const auto& scene : curves) {
      const auto hit = trace_ray(scene->view(), origin, direction);
      REQUIRE(hit);
      if (hit->t < expected->t - 1e-3f) continue;  // the round end of a line
      const auto y = surface_at(scene->view(), origin, direction, *hit);
      CHECK(hit->t == near(expected->t, 1e-4));
      CHECK(is_close(y.p, x.p, 1e-4f));
      CHECK(is_close(y.ng, x.ng, 1e-3f));
      CHECK(y.uv.y == near(x.uv.y, 1e-3));
      ++compared;
    }
  }
  CHECK(compared > 1000);
}

TEST_CASE("curves: hits lie on the swept circles and tangents are perpendicular to normals") {
  const std::vector<Curves::Point> points = {{{0, 0, 0}, 0.1f},       {{0.5f, 0.2f, 1}, 0.15f}, {{1, -0.3f, 2}, 0.3f},
                                             {{0.8f, 0.5f, 3}, 0.1f}, {{0, 1, 3.5f}, 0.2f},     {{-0.5f, 0, 4}, 0.05f}};
  const auto scene = lone(one_curve(Curves::Basis::kBspline, points));
  int hits = 0;
  for (std::uint32_t i = 0; i < 4000; ++i) {
    const Vec3f target = Vec3f{0.4f, 0.2f, 2.2f} + random_direction(63, i) * 0.7f,
                origin = random_direction(64, i) * 8.0f;
    const Vec3f direction = normalize(target - origin);
    const auto hit = trace_ray(scene->view(), origin, direction);
    if (!hit) continue;
    ++hits;
    const auto y = surface_at(scene->view(), origin, direction, *hit);
    CHECK(is_close(y.p, origin + direction * hit->t, 1e-4f));
    const double along = y.uv.y * 3.0;
    const auto segment = static_cast<std::size_t>(std::min(along, 2.999));
    const std::array<double, 4> axis = de_boor(points, segment, along - static_cast<double>(segment));
    const Vec3f middle{static_cast<float>(axis[0]), static_cast<float>(axis[1]), static_cast<float>(axis[2])};
    CHECK(length(y.p - middle) == near(axis[3], 1e-4));
    CHECK(length(y.ng) == near(1, 1e-5));
    CHECK(is_close(normalize(cross(y.dp_du, y.dp_dv)), y.ng, 1e-3f));
    // A nearby hit lies in the plane of the tangents.
    const Vec3f aside = normalize(y.dp_dv) * 1e-3f;
    const auto next = trace_ray(scene->view(), origin + aside, direction);
    if (!next || std::abs(dot(y.ng, direction)) < 0.2f || std::abs(next->t - hit->t) > 0.02f) continue;
    const Vec3f step = origin + aside + direction * next->t - (origin + direction * hit->t);
    CHECK(std::abs(dot(step, y.ng)) < 0.03f * length(step));
  }
  CHECK(hits > 1000);
}

namespace {

/// Curves in Mitsuba's format: one of 5 control points and one of 4.
const std::string kTwoCurves =
    "0 0 0 0.1\n0 0 1 0.1\n0.3 0 2 0.2\n0 0 3 0.2\n1 0 4 .1\n\n2 0 0 .1\n2 0 1 .1\n2 0 2 .1\n2 0 3 .1\n";

/// Expected hit of a ray along +x or -x.
struct Expected {
  Curves::Basis basis;
  Vec3f origin;
  float side;
  Vec3f p, n;
  Vec2f uv;
};

/// Mitsuba 3.9 (scalar_rgb), ray_intersect() of rays with kTwoCurves: p, n and uv.
std::vector<Expected> hits_of_mitsuba() {
  const auto linear = Curves::Basis::kLinear, spline = Curves::Basis::kBspline;
  return {
      {spline,
       {-5, 0.05f, 1.2f},
       1,
       {-0.0340261f, 0.05f, 1.2f},
       {-0.913038f, 0.392987f, 0.10919f},
       {0.185588f, 0.0594342f}},
      {spline, {5, 0.05f, 1.7f}, -1, {2.0866f, 0.05f, 1.7f}, {0.866025f, 0.5f, 0}, {0.0833334f, 0.9f}},
      {spline,
       {-5, 0.05f, 2.3f},
       1,
       {-0.00691223f, 0.05f, 2.3f},
       {-0.960102f, 0.257462f, -0.109169f},
       {0.70855f, 0.439232f}},
      {spline,
       {5, 0.05f, 2.3f},
       -1,
       {0.369273f, 0.05f, 2.3f},
       {0.963591f, 0.25838f, 0.068788f},
       {0.291604f, 0.427522f}},
      {linear, {-5, 0.05f, 0.5f}, 1, {-0.0866027f, 0.05f, 0.5f}, {-0.866026f, 0.499999f, 0}, {0.416667f, 0.0714286f}},
      {linear,
       {-5, 0.05f, 1.2f},
       1,
       {-0.0509958f, 0.05f, 1.2f},
       {-0.890293f, 0.423628f, 0.167088f},
       {0.180034f, 0.168611f}},
      {linear,
       {-5, 0.05f, 2.3f},
       1,
       {0.00782442f, 0.05f, 2.3f},
       {-0.927411f, 0.25f, -0.278224f},
       {0.709785f, 0.336521f}},
      {linear,
       {5, 0.05f, 3.2f},
       -1,
       {0.428313f, 0.05f, 3.2f},
       {0.723763f, 0.295105f, -0.623763f},
       {0.797801f, 0.472241f}}};
}

}  // namespace

TEST_CASE("curves: positions and normals and uv match Mitsuba") {
  for (const Expected& e : hits_of_mitsuba()) {
    const auto scene = lone(read_curves(kTwoCurves, e.basis));
    const auto hit = trace_ray(scene->view(), e.origin, {e.side, 0, 0});
    REQUIRE(hit);
    const auto y = surface_at(scene->view(), e.origin, {e.side, 0, 0}, *hit);
    CHECK(is_close(y.p, e.p, 2e-5f));
    CHECK(is_close(y.ng, e.n, 2e-4f));
    CHECK(is_close(y.ns, y.ng, 0));
    CHECK(y.uv.x == near(e.uv.x, 1e-4));
    CHECK(y.uv.y == near(e.uv.y, 1e-4));
  }
}

TEST_CASE("curves: rays that leave convex curves do not hit them again") {
  for (const auto basis : {Curves::Basis::kLinear, Curves::Basis::kBspline})
    for (const float scale : {1e-2f, 1.0f, 10.0f})
      for (const float radius : {0.3f, 0.01f}) {
        Curves curves = one_curve(basis, {});
        for (int i = 0; i < 6; ++i) {
          const float z = static_cast<float>(i) - 2.5f;
          curves.points.push_back({Vec3f{0.3f * z, 0.1f * z, z} * scale, radius * scale * (1 + 0.1f * z)});
        }
        const auto scene = lone(curves);
        int starts = 0, self_hits = 0;
        for (std::uint32_t i = 0; i < 3000; ++i) {
          const float z = 2.8f * (static_cast<float>(i) / 3000 - 0.5f);
          const Vec3f target = (Vec3f{0.3f, 0.1f, 1} * z + random_direction(65, i) * (0.5f * radius)) * scale;
          const Vec3f origin = target + random_direction(66, i) * (4 * scale), direction = normalize(target - origin);
          const auto hit = trace_ray(scene->view(), origin, direction);
          if (!hit) continue;
          const auto y = surface_at(scene->view(), origin, direction, *hit);
          if (dot(y.ng, direction) > 0) continue;
          ++starts;
          for (std::uint32_t k = 0; k < 3; ++k) {
            Vec3f away = random_direction(67 + k, i);
            if (k == 2) away = normalize(away - y.ng * (dot(away, y.ng) * 0.98f));  // grazing
            if (dot(away, y.ng) < 0) away = -away;
            self_hits += trace_ray(scene->view(), offset_origin<Scalar>(y.p, y.ng, y.offset, away), away).has_value();
          }
        }
        INFO("scale " << scale << ", radius " << radius << ", basis " << static_cast<int>(basis));
        CHECK(starts > 1500);
        CHECK(self_hits == 0);
      }
}

TEST_CASE("curves: instances beside meshes and quadrics are placed correctly") {
  const Curves curves = one_curve(
      Curves::Basis::kBspline,
      {{{0, 0, -2}, 0.2f}, {{0.2f, 0, -1}, 0.3f}, {{0, 0.3f, 0}, 0.2f}, {{0, 0, 1}, 0.4f}, {{0, 0, 2}, 0.2f}});
  const auto fill = [&](std::vector<ShapeDescription>& shapes) {
    Description all;
    add_shape(all, SphereShape{{0.8f, 0, 0}, 0.3f}, Transform());
    add_shape(all, curves, Transform());
    add_shape(all, CubeShape{}, Transform::translate({-1, 0, 0}) * Transform::scale({0.2f, 0.2f, 0.2f}));
    shapes = std::move(all.shapes);
  };
  Description plain = empty_scene(4, 4), instanced = empty_scene(4, 4);
  fill(plain.shapes);
  instanced.groups.emplace_back();
  fill(instanced.groups[0].shapes);
  const Transform transform =
      Transform::translate({1, 2, 3}) * Transform::rotate({1, 1, 0}, 50) * Transform::scale({2, 2, 2});
  InstanceDescription instance;
  for (std::size_t i = 0; i < 12; ++i) instance.to_world[i] = transform.matrix().m[i / 4][i % 4];
  instanced.instances.push_back(instance);
  const auto a = compile_scene(plain), b = compile_scene(instanced);
  int on_curve = 0;
  for (std::uint32_t i = 0; i < 2000; ++i) {
    const Vec3f origin = random_direction(71, i) * 6.0f, target = random_direction(72, i),
                direction = normalize(target - origin);
    const auto x = trace_ray(a->view(), origin, direction);
    const Vec3f origin2 = transform.point(origin), direction2 = transform.vector(direction);
    const auto y = trace_ray(b->view(), origin2, direction2);
    if (!x || !y) continue;
    const auto p = surface_at(a->view(), origin, direction, *x), q = surface_at(b->view(), origin2, direction2, *y);
    if (dot(p.ng, direction) > -0.2f) continue;
    on_curve += x->shape == 1;
    CHECK(x->shape == y->shape);
    CHECK(is_close(q.p, transform.point(p.p), 1e-4f));
    CHECK(is_close(q.ng, normalize(transform.normal(p.ng)), 1e-3f));
    CHECK(is_close(q.dp_dv, transform.vector(p.dp_dv), 1e-2f));
  }
  CHECK(on_curve > 200);
}

TEST_CASE("curves: radii may decrease linearly to zero") {
  // A cone from radius 0.2 at z = 0 to its tip at z = 1. The control point beyond the tip has a negative radius.
  const auto cone = lone(one_curve(Curves::Basis::kBspline,
                                   {{{0, 0, -1}, 0.4f}, {{0, 0, 0}, 0.2f}, {{0, 0, 1}, 0.0f}, {{0, 0, 2}, -0.2f}}),
                         Transform());
  for (std::uint32_t i = 0; i < 300; ++i) {
    const float z = 0.02f + 0.96f * random4<Scalar>(63, i, 0, 0).x, r = 0.2f * (1 - z);
    const Vec3f across = normalize(Vec3f{random_direction(64, i).x, random_direction(64, i).y, 0});
    const Vec3f side{-across.y, across.x, 0};
    CHECK(trace_ray(cone->view(), across * 2.0f + side * (0.9f * r) + Vec3f{0, 0, z}, -across));
    CHECK_FALSE(trace_ray(cone->view(), across * 2.0f + side * (1.1f * r) + Vec3f{0, 0, z}, -across));
  }
}

TEST_CASE("curves: unsupported and malformed curves are errors") {
  const Curves good = one_curve(Curves::Basis::kLinear, {{{0, 0, 0}, 1}, {{0, 0, 1}, 1}});
  const auto error = [](const Curves& curves, auto&& change) {
    Description d = empty_scene(4, 4);
    change(add_shape(d, curves, Transform()));
    return error_of([&] { compile_scene(d); });
  };
  const auto keep = [](ShapeDescription&) {};
  CHECK(error(good, keep).empty());
  CHECK(contains(error(good, [](ShapeDescription& s) { emit(s, 1); }), "curves cannot emit light"));
  CHECK(contains(error(good, [](ShapeDescription& s) { s.flip_normals = true; }), "flip_normals"));
  CHECK(contains(error(good, [](ShapeDescription& s) { s.interior = MediumId{0}; }), "cannot bound media"));
  Curves bad = good;
  bad.basis = Curves::Basis::kBspline;
  CHECK(contains(error(bad, keep), "fewer than 4 points"));
  bad = good;
  bad.starts = {0, 2};
  CHECK(contains(error(bad, keep), "fewer than 2 points"));
  bad.starts = {0, 7};
  CHECK(contains(error(bad, keep), "fewer than 2 points"));
  bad = good;
  bad.points[0].radius = -1;
  CHECK(contains(error(bad, keep), "radius"));
}

TEST_CASE("curves: segments without a surface are dropped") {
  Curves curves = one_curve(Curves::Basis::kLinear,
                            {{{0, 0, 0}, 0.1f}, {{0, 0, 0}, 0.1f}, {{0, 0, 1}, 0.1f}, {{1e30f, 0, 1}, 0.1f}});
  const auto scene = lone(curves);
  CHECK(scene->info().curve_segments == 1);
  REQUIRE(scene->warnings().size() == 1);
  CHECK(contains(scene->warnings()[0], "2 degenerate or non-finite curve segments"));
  CHECK(trace_ray(scene->view(), {-5, 0, 0.5f}, {1, 0, 0}));
  CHECK_FALSE(trace_ray(scene->view(), {0, 0, 0.5f}, {1, 0, 0}));  // from inside
  curves.points.resize(2);
  CHECK(lone(curves)->info().shapes == 0);
}

}  // namespace sheaf::test_curves
