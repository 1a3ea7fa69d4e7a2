// Instances of shape groups: what rays see of them is what they would see of the same shapes, placed one by one.
#include "kernels/passes/render.h"
#include "scene/compile.h"
#include "tests/records_testing.h"
#include "tests/scene_files.h"
#include "tests/tiny_scenes.h"
#include "tests/trace_testing.h"

#include <doctest/doctest.h>

#include <cmath>

using namespace sheaf;

namespace {

Transform shear() {
  Matrix4 m;
  m.m[0][1] = 0.7;
  m.m[1][2] = -0.4;
  m.m[2][0] = 0.3;
  return Transform(m);
}

struct NamedTransform {
  std::string name;
  Transform to_world;
};
const NamedTransform kPlacements[] = {
    {"identity", Transform()},
    {"moved", Transform::translate({2, -1, 5}) * Transform::rotate({1, 2, 3}, 70)},
    {"scaled", Transform::translate({-1, 0.5f, 2}) * Transform::scale({3, 3, 3})},
    {"stretched", Transform::rotate({3, 1, -2}, 40) * Transform::scale({2, 0.4f, 1.1f}) * Transform::rotate({1, 0, 1}, 25)},
    {"mirrored", Transform::translate({1, 2, 3}) * Transform::rotate({1, 1, 0}, 30) * Transform::scale({-1, 1, 1})},
    {"mirrored thrice", Transform::scale({-1.5f, -0.7f, -1})},
    {"sheared", Transform::translate({0, 1, 0}) * shear()},
    {"sheared and mirrored", shear() * Transform::scale({1, 1, -2})},
};

Mesh smooth_mesh() {
  Mesh mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0.3f}, {1, 1, 0}, {-1, 1, -0.2f}};
  mesh.normals = {{-0.3f, -0.3f, 1}, {0.4f, -0.2f, 1}, {0.1f, 0.3f, 1}, {-0.2f, 0.3f, 1}};
  mesh.uvs = {{0.1f, 0.1f}, {0.9f, 0.2f}, {1, 1.3f}, {-0.2f, 0.8f}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

/// Every kind of shape, at different places around the origin, with `materials` in turn. All have normals that lead
/// their triangles: the side of others follows the order of their vertices, which copies under a mirror keep.
std::vector<ShapeDescription> every_kind(const std::vector<MaterialId>& materials) {
  const auto at = [](float x, float y, float z) {
    return Transform::translate({x, y, z}) * Transform::rotate({1, 2, -1}, 35) * Transform::scale({0.9f, 0.6f, 0.8f});
  };
  Description all;
  add_shape(all, SphereShape{}, at(-1.5f, -1.5f, 0));
  add_shape(all, DiskShape{}, at(1.5f, -1.5f, 0));
  add_shape(all, CylinderShape{}, at(0, -1.5f, 1.5f));
  add_shape(all, RectangleShape{}, at(-1.5f, 1.5f, 0));
  add_shape(all, CubeShape{}, at(1.5f, 1.5f, 0));
  add_shape(all, smooth_mesh(), at(0, 1.5f, -1.5f));
  add_shape(all, SphereShape{{0.2f, 0, 0}, 0.5f}, at(0, 0, 0)).flip_normals = true;
  add_shape(all, smooth_mesh(), at(0, 1.5f, 1.5f)).flip_normals = true;
  for (std::size_t i = 0; i < all.shapes.size() && !materials.empty(); ++i)
    all.shapes[i].material = materials[i % materials.size()];
  return all.shapes;
}

void add_instance(Description& d, std::uint32_t group, const Transform& to_world) {
  InstanceDescription instance;
  instance.group = group;
  for (std::size_t i = 0; i < 12; ++i) instance.to_world[i] = static_cast<float>(to_world.matrix().m[i / 4][i % 4]);
  d.instances.push_back(instance);
}

std::uint32_t add_group(Description& d, std::vector<ShapeDescription> shapes) {
  d.groups.push_back({std::move(shapes), {}, {}});
  return static_cast<std::uint32_t>(d.groups.size() - 1);
}

void add_copies(Description& d, const std::vector<ShapeDescription>& shapes, const Transform& to_world) {
  for (ShapeDescription shape : shapes) {
    shape.to_world = to_world * shape.to_world;
    d.shapes.push_back(shape);
  }
}

struct Ray {
  Vec3f origin, direction;
};
/// A ray from around `to_world`'s image of a ball of radius 3 to a point in it.
Ray ray_towards(const Transform& to_world, std::uint32_t i) {
  const Vec3f origin = to_world.point(random_direction(71, i) * 8.0f), target = to_world.point(random_direction(72, i) * 2.2f);
  return {origin, normalize(target - origin)};
}

double distance(Vec3f a, Vec3f b) { return length(a - b); }

std::string message_of(const Description& d) {
  try {
    compile_scene(d);
  } catch (const SceneError& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("instancing: rays see the same as of shapes placed one by one") {
  for (const NamedTransform& placement : kPlacements) {
    CAPTURE(placement.name);
    Description instanced = empty_scene(1, 1), copied = empty_scene(1, 1);
    const std::vector<ShapeDescription> shapes = every_kind({});
    add_instance(instanced, add_group(instanced, shapes), placement.to_world);
    add_copies(copied, shapes, placement.to_world);
    Description unplaced = empty_scene(1, 1);
    unplaced.shapes = shapes;
    const auto scene = compile_scene(instanced), reference = compile_scene(copied), own = compile_scene(unplaced);
    int hits = 0, others = 0, seen[8] = {};
    double worst_t = 0, worst_p = 0, worst_ng = 0, worst_ns = 0, worst_uv = 0, worst_du = 0, worst_dv = 0;
    for (std::uint32_t i = 0; i < 6000; ++i) {
      const Ray ray = ray_towards(placement.to_world, i);
      const auto a = trace_ray(scene->view(), ray.origin, ray.direction);
      const auto b = trace_ray(reference->view(), ray.origin, ray.direction);
      if (a.has_value() != b.has_value() || (a && a->shape != b->shape)) {
        ++others;
        continue;
      }
      if (!a) continue;
      ++hits;
      ++seen[a->shape];
      CHECK(a->instance == 0);
      CHECK(b->instance == kNone);
      const auto x = surface_at(scene->view(), ray.origin, ray.direction, *a);
      const auto y = surface_at(reference->view(), ray.origin, ray.direction, *b);
      worst_t = std::max(worst_t, std::fabs(a->t - double(b->t)));
      worst_p = std::max(worst_p, distance(x.p, y.p));
      worst_ng = std::max(worst_ng, distance(x.ng, y.ng));
      // Vertex normals are interpolated in the group's space.
      const Vec3f hit_point = placement.to_world.inverse().point(x.p);
      const auto z = surface_point<Scalar>(own->view(), load_shapes<Scalar>(own->view(), a->shape), a->primitive, a->u, a->v, hit_point, kNone);
      worst_ns = std::max(worst_ns, distance(x.ns, normalize(placement.to_world.normal(z.ns))));
      const double turns = std::fabs(x.uv.x - double(y.uv.x));
      worst_uv = std::max({worst_uv, std::min(turns, std::fabs(1 - turns)), std::fabs(x.uv.y - double(y.uv.y))});
      worst_du = std::max(worst_du, distance(x.dp_du, y.dp_du) / length(y.dp_du));
      worst_dv = std::max(worst_dv, distance(x.dp_dv, y.dp_dv) / length(y.dp_dv));
    }
    CHECK(hits > 1500);
    for (const int count : seen) CHECK(count > 30);
    CHECK(others < 12);
    CHECK(worst_t < 1e-4);
    CHECK(worst_p < 1e-4);
    CHECK(worst_ng < 1e-4);
    CHECK(worst_ns < 1e-4);
    CHECK(worst_uv < 2e-4);
    CHECK(worst_du < 5e-3);
    CHECK(worst_dv < 5e-3);
  }
}

TEST_CASE("instancing: normals under a mirroring transform are those of Mitsuba") {
  Description d = empty_scene(1, 1);
  Description shapes;
  add_shape(shapes, SphereShape{}, Transform());
  add_shape(shapes, RectangleShape{}, Transform::translate({3, 0, 0}));
  add_instance(d, add_group(d, shapes.shapes), Transform::scale({-1, 2, 1}));
  const auto scene = compile_scene(d);
  const auto check = [&](Vec3f origin, Vec3f n, Vec3f du, Vec3f dv) {
    const auto hit = trace_ray(scene->view(), origin, {0, 0, 1});
    REQUIRE(hit.has_value());
    const auto y = surface_at(scene->view(), origin, {0, 0, 1}, *hit);
    CHECK(distance(y.ng, n) < 1e-5);
    CHECK(distance(y.ns, n) < 1e-5);
    CHECK(distance(y.dp_du, du) < 1e-4);
    CHECK(distance(y.dp_dv, dv) < 1e-4);
  };
  check({0.3f, 0.2f, -5}, {0.301131f, 0.0501886f, -0.952261f}, {0.628319f, -3.76991f, 0}, {-2.82743f, -1.88496f, -0.993459f});
  check({-3.2f, 0.1f, -5}, {0, 0, 1}, {-2, 0, 0}, {0, 4, 0});
}

TEST_CASE("instancing: sides of surfaces get their materials") {
  for (const NamedTransform& placement : kPlacements) {
    CAPTURE(placement.name);
    const auto make = [&](bool instances) {
      Description d = empty_scene(48, 48);
      d.sampler.sample_count = 16;
      d.integrator.max_depth = 6;
      look_at(d, placement.to_world.point({0, 0, -7}), placement.to_world.point({0, 0, 0}), {0.1f, 1, 0.2f}, 50);
      const std::vector<MaterialId> materials = {
          add_material(d, TwoSidedDescription{add_diffuse_rgb(d, 0.8f, 0.1f, 0.1f), add_diffuse_rgb(d, 0.1f, 0.8f, 0.1f)}),
          add_diffuse(d, 0.7f), add_glass(d), add_mirror(d), add_two_sided(d, add_diffuse(d, 0.5f))};
      std::vector<ShapeDescription> shapes = every_kind(materials);
      // Interpolated normals differ, where they are interpolated before they are stretched.
      std::erase_if(shapes, [](const ShapeDescription& shape) { return std::holds_alternative<Mesh>(shape.geometry); });
      if (instances) {
        add_instance(d, add_group(d, shapes), placement.to_world);
      } else {
        add_copies(d, shapes, placement.to_world);
      }
      add_rectangle(d, placement.to_world * Transform::translate({0, 0, 4}) * Transform::scale({6, 6, 6}),
                    add_two_sided(d, add_diffuse(d, 0.3f)));
      add_constant_light(d, 1);  // one light: choosing among several depends on the scene's bounds
      return render(*compile_scene(d), {}).film.to_image();
    };
    const Image a = make(true), b = make(false);
    int far = 0;
    double difference = 0;
    for (int y = 0; y < a.height; ++y)
      for (int x = 0; x < a.width; ++x)
        for (int c = 0; c < 3; ++c) {
          const double apart = double(a.at(x, y, c)) - b.at(x, y, c);
          far += std::fabs(apart) > 1e-3;
          difference += apart;
        }
    // Few paths take another turn after a rounding error; a wrong side or material would change whole shapes.
    CHECK(far < 0.03 * 3 * a.width * a.height);
    CHECK(std::fabs(difference) < 2e-3 * 3 * a.width * a.height);
  }
}

TEST_CASE("instancing: registers equal single values, plain shapes and instances mixed") {
  Description d = empty_scene(4, 4);
  add_shape(d, SphereShape{}, Transform());
  add_shape(d, smooth_mesh(), Transform());
  const std::uint32_t group = add_group(d, every_kind({}));
  for (const NamedTransform& placement : kPlacements) add_instance(d, group, placement.to_world);
  const auto scene = compile_scene(d);
  const SceneView view = scene->view();
  REQUIRE(view.shape_count == 10);
  double worst = 0;
  for (std::uint32_t i = 0; i < 2000; i += kWidth) {
    const auto at = [i](int lane) { return i + static_cast<std::uint32_t>(lane); };
    const auto shape_of = [&](int lane) { return (at(lane) * 7 + i / 64) % 10; };
    const auto instance_of = [&](int lane) { return shape_of(lane) < 2 ? kNone : at(lane) % 8; };
    const auto hit = wide_record<Vec3>([&](int lane) { return random_direction(64, at(lane)) * 2.0f; });
    const WideFloat u = wide_random(65, i).x * WideFloat(0.5f), v = wide_random(65, i).y * WideFloat(0.5f);
    const auto wide = surface_point<Wide, true>(view, load_shapes<Wide>(view, wide_uints(shape_of)), WideUint(1u), u, v,
                                                hit, wide_uints(instance_of));
    for (int lane = 0; lane < kWidth; ++lane) {
      const auto one = surface_point<Scalar, true>(view, load_shapes<Scalar>(view, shape_of(lane)), 1u, u[lane], v[lane],
                                                   lane_record(hit, lane), instance_of(lane));
      const auto relative = [&](const Vec3<Wide>& a, Vec3f b) { return distance(lane_record(a, lane), b) / (1 + length(b)); };
      worst = std::max({worst, relative(wide.p, one.p), relative(wide.ng, one.ng), relative(wide.ns, one.ns),
                        relative(wide.dp_du, one.dp_du), relative(wide.dp_dv, one.dp_dv),
                        std::fabs(wide.offset[lane] / double(one.offset) - 1)});
    }
  }
  CHECK(worst < 3e-5);
}

TEST_CASE("instancing: thousands of instances, each found where it is") {
  constexpr std::uint32_t kSide = 14, kCount = kSide * kSide * kSide;
  Description d = empty_scene(1, 1);
  add_sphere(d, {-10, -10, -10}, 1);
  Description one, two;
  add_sphere(one, {0, 0, 0}, 0.3f);
  add_sphere(two, {0, 0, 0}, 0.2f);
  add_shape(two, CubeShape{}, Transform::translate({0, 0, 9999}));
  add_group(d, one.shapes);
  add_group(d, two.shapes);
  const auto center = [](std::uint32_t i) {
    return Vec3f{float(i % kSide), float(i / kSide % kSide), float(i / (kSide * kSide))};
  };
  for (std::uint32_t i = 0; i < kCount; ++i) add_instance(d, i % 3 == 0 ? 1 : 0, Transform::translate(center(i)));
  const auto scene = compile_scene(d);
  CHECK(scene->info().instances == kCount);
  CHECK(scene->info().groups == 2);
  CHECK(scene->info().shapes == 4);
  CHECK(scene->info().instanced_triangles == 12 * ((kCount + 2) / 3));
  for (std::uint32_t first = 0; first < kCount; first += kPacketWidth) {
    RayPacket packet;
    const int count = static_cast<int>(std::min<std::uint32_t>(kPacketWidth, kCount - first));
    for (int i = 0; i < count; ++i) {
      const Vec3f from = center(first + static_cast<std::uint32_t>(i));
      packet.origin_x[i] = from.x;
      packet.origin_y[i] = from.y;
      packet.origin_z[i] = from.z - 0.5f;
      packet.direction_z[i] = 1;
      packet.t_far[i] = kInfinity;
    }
    scene->view().accel->intersect(packet, count);
    for (int i = 0; i < count; ++i) {
      const std::uint32_t index = first + static_cast<std::uint32_t>(i);
      CHECK(packet.instance[i] == index);
      CHECK(packet.shape[i] == (index % 3 == 0 ? 2 : 1));
      CHECK(packet.t_far[i] == doctest::Approx(index % 3 == 0 ? 0.3 : 0.2));
      CHECK(packet.normal_z[i] < 0);
    }
  }
  const auto plain = trace_ray(scene->view(), {-10, -10, -15}, {0, 0, 1});
  REQUIRE(plain.has_value());
  CHECK(plain->shape == 0);
  CHECK(plain->instance == kNone);
}

TEST_CASE("instancing: the same bits for any number of threads and wave size, and in every build") {
  Description d = empty_scene(40, 40);
  d.sampler.sample_count = 4;
  look_at(d, {0, 2, -14}, {0, 0, 0}, {0, 1, 0}, 60);
  const std::uint32_t group = add_group(d, every_kind({add_diffuse(d, 0.6f), add_glass(d)}));
  for (const NamedTransform& placement : kPlacements) add_instance(d, group, placement.to_world);
  add_constant_light(d, 1);
  const auto rendered = [&](int threads, int wave_size) {
    RenderOptions options;
    options.threads = threads;
    options.wave_size = wave_size;
    return render(*compile_scene(d), options).film.to_image();
  };
  const Image reference = rendered(1, 256);
  for (const auto& [threads, wave_size] : {std::pair{2, 1024}, std::pair{7, 1600}, std::pair{1, 256}}) {
    const Image image = rendered(threads, wave_size);
    bool same_bits = true;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        for (int c = 0; c < 3; ++c) same_bits = same_bits && same(image.at(x, y, c), reference.at(x, y, c));
    CHECK(same_bits);
  }
}

namespace {

/// Rays that leave a convex shape, to its outer side and through it: how many there were, met it, met it at once.
struct Tally {
  int starts = 0, self_hits = 0, early_hits = 0;
};

Tally shoot(const SceneView& scene, const Transform& to_world, bool closed) {
  Tally tally;
  const float size = length(to_world.vector({1, 1, 1}));
  for (std::uint32_t i = 0; i < 700; ++i) {
    const Vec3f origin = to_world.point(random_direction(81, i) * (i % 4 == 0 ? 500.0f : 3.0f));
    const Vec3f direction = normalize(to_world.point(random_direction(82, i) * 0.6f) - origin);
    const auto hit = trace_ray(scene, origin, direction);
    if (!hit) continue;
    const auto y = surface_at(scene, origin, direction, *hit);
    // Once in a million a ray slips between two triangles and finds a closed shape from inside.
    if (closed && dot(y.ng, direction) > 0) continue;
    const Vec3f outer = dot(y.ng, direction) < 0 ? y.ng : -y.ng;
    ++tally.starts;
    for (std::uint32_t j = 0; j < 4; ++j) {
      const auto random = random4<Scalar>(83, i, j, 0);
      const float z = j < 2 ? random.x : std::pow(10.0f, -1 - 3 * random.x), r = std::sqrt(1 - z * z);
      const float x = r * std::cos(6.2831853f * random.y), w = r * std::sin(6.2831853f * random.y);
      const auto frame = Frame<Scalar>::from_normal(outer);
      const Vec3f away = normalize(frame.to_world({x, w, z})), through = normalize(frame.to_world({x, w, -z}));
      tally.self_hits += trace_ray(scene, offset_origin<Scalar>(y.p, y.ng, y.offset, away), away).has_value();
      if (z < 0.2f) continue;
      const auto in = trace_ray(scene, offset_origin<Scalar>(y.p, y.ng, y.offset, through), through);
      if (!in || in->t > 1e-3f * size) continue;
      const auto behind = surface_at(scene, y.p, through, *in);
      tally.early_hits += dot(behind.ng, y.ng) > 0.999f;
    }
  }
  return tally;
}

}  // namespace

TEST_CASE("instancing: a ray that leaves a convex shape does not meet it again") {
  Mesh triangle;
  triangle.positions = {{-1, -0.9f, 0.3f}, {1, -0.7f, -0.2f}, {0.1f, 0.9f, 0.1f}};
  triangle.triangles = {{{0, 1, 2}}};
  Description kinds;
  add_shape(kinds, SphereShape{}, Transform());
  add_shape(kinds, DiskShape{}, Transform());
  add_shape(kinds, RectangleShape{}, Transform());
  add_shape(kinds, CubeShape{}, Transform::scale({0.7f, 0.7f, 0.7f}));
  add_shape(kinds, triangle, Transform());
  const Transform stretched = Transform::rotate({3, 1, -2}, 40) * Transform::scale({2, 0.4f, 1.1f}) * Transform::rotate({1, 0, 1}, 25);
  for (const float object : {1e-3f, 1.0f, 1e5f})
    for (const float scale : {1e-3f, 1.0f, 1e3f, 1e5f})
      for (const float away : {0.0f, 1000.0f})
        for (const Transform& form : {Transform::rotate({3, 1, 2}, 50), stretched, shear()})
          for (const ShapeDescription& kind : kinds.shapes) {
            CAPTURE(object);
            CAPTURE(scale);
            CAPTURE(away);
            CAPTURE(kind.geometry.index());
            Description d = empty_scene(1, 1);
            ShapeDescription shape = kind;
            const Transform inside = Transform::translate({-3 * object, object, 2 * object}) * Transform::scale({object, object, object});
            shape.to_world = inside * shape.to_world;
            const float size = object * scale;
            const Transform outside = Transform::translate({away * size, -0.7f * away * size, 0.3f * away * size}) * form *
                                      Transform::scale({scale, scale, scale});
            add_instance(d, add_group(d, {shape}), outside);
            const auto scene = compile_scene(d);
            const bool closed = std::holds_alternative<SphereShape>(kind.geometry) || std::holds_alternative<CubeShape>(kind.geometry);
            const Tally tally = shoot(scene->view(), outside * inside, closed);
            CHECK(tally.starts > 100);
            CHECK(tally.self_hits == 0);
            CHECK(tally.early_hits == 0);
          }
}

TEST_CASE("instancing: no path is lost in a closed room that is an instance") {
  constexpr int kDepth = 6;
  for (const bool box : {false, true})
    for (const float scale : {1e-3f, 1.0f, 1e5f}) {
      CAPTURE(box);
      CAPTURE(scale);
      Description d = empty_scene(32, 32), inside;
      d.sampler.sample_count = 16;
      d.integrator.max_depth = d.integrator.rr_depth = kDepth;
      d.integrator.strategy = LightStrategy::kBsdfOnly;
      look_at(d, {0, 0, 0}, Vec3f{0.7f, 0.2f, 0.4f} * scale);
      if (box) {
        add_shape(inside, CubeShape{}, Transform::rotate({1, 2, 3}, 25));
      } else {
        add_shape(inside, SphereShape{}, Transform());
      }
      inside.shapes[0].flip_normals = true;
      inside.shapes[0].material = add_diffuse(d, 0.5f);
      add_instance(d, add_group(d, inside.shapes), Transform::rotate({1, -1, 2}, 70) * Transform::scale({scale, -scale, scale}));
      const RenderResult result = render(*compile_scene(d), {});
      CHECK(result.report.stats.dropped.rays == 0);
      CHECK(result.report.stats.rays.camera == 32 * 32 * 16);
      CHECK(result.report.stats.rays.scatter == 32 * 32 * 16 * (kDepth - 1));
    }
}

TEST_CASE("instancing: bounds, groups of nothing, and what cannot be") {
  Description d = empty_scene(1, 1), ball, flat;
  add_sphere(ball, {1, 0, 0}, 1);
  Mesh line;
  line.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  line.triangles = {{0, 1, 2}};
  add_shape(flat, line, Transform());
  const std::uint32_t nothing = add_group(d, flat.shapes), balls = add_group(d, ball.shapes);
  add_group(d, {});
  add_instance(d, nothing, Transform());
  add_instance(d, balls, Transform::translate({0, 5, 0}) * Transform::scale({-2, 1, 1}));
  const auto scene = compile_scene(d);
  const SceneInfo info = scene->info();
  CHECK(info.instances == 1);
  CHECK(info.groups == 1);
  CHECK(scene->warnings().size() == 2);
  CHECK(distance(info.bounds_min, {-4, 4, -1}) < 1e-4);
  CHECK(distance(info.bounds_max, {0, 6, 1}) < 1e-4);
  CHECK(trace_ray(scene->view(), {-2, 5, -5}, {0, 0, 1}).has_value());
  CHECK_FALSE(trace_ray(scene->view(), {1, 0, -5}, {0, 0, 1}).has_value());

  Description glowing = d;
  glowing.groups[balls].shapes[0].radiance = SpectrumDescription::constant(1);
  CHECK(compile_scene(glowing)->info().lights == 1);
  Description singular = d;
  singular.instances[1].to_world[0] = 0;
  CHECK(test::contains(message_of(singular), "singular"));
  Description far = d;
  far.groups[balls].shapes[0].to_world = Transform::translate({1e12f, 0, 0});
  far.instances[1].to_world[0] = 1e8f;
  const auto without = compile_scene(far);
  CHECK(without->info().instances == 0);
  CHECK(without->warnings().size() == 3);
}

namespace {
const std::string kGroup =
    "<shape type='shapegroup' id='g'><shape type='sphere'><float name='radius' value='2'/></shape>"
    "<shape type='ply'><string name='filename' value='mesh.ply'/><boolean name='face_normals' value='true'/>"
    "<boolean name='flip_normals' value='true'/></shape></shape>\n";
const std::string kPlacedInstance =
    "<shape type='instance'><ref id='g'/><transform name='to_world'><scale x='2'/><translate y='3'/></transform></shape>\n";
}  // namespace

TEST_CASE("instancing: Mitsuba scenes, group first or last") {
  for (const std::string& text : {kGroup + kPlacedInstance + kPlacedInstance, kPlacedInstance + kPlacedInstance + kGroup}) {
    const Description d = test::read_text(test::mitsuba_scene(text + "<shape type='cube'/>"));
    REQUIRE(d.shapes.size() == 1);
    REQUIRE(d.groups.size() == 1);
    CHECK(d.groups[0].id == "g");
    REQUIRE(d.groups[0].shapes.size() == 2);
    CHECK(std::get<SphereShape>(d.groups[0].shapes[0].geometry).radius == 2);
    CHECK(d.groups[0].shapes[1].face_normals);
    CHECK(d.groups[0].shapes[1].flip_normals);
    REQUIRE(d.instances.size() == 2);
    CHECK(d.instances[0].group == 0);
    CHECK(d.instances[1].to_world == std::array<float, 12>{2, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1, 0});
  }
  const Description nested = test::read_text(test::mitsuba_scene(
      "<shape type='instance'><shape type='shapegroup'><shape type='sphere'/></shape></shape>"));
  CHECK(nested.groups.size() == 1);
  CHECK(nested.instances.size() == 1);
  CHECK(nested.shapes.empty());
}

TEST_CASE("instancing: Nori scenes") {
  const Description d = test::read_text(
      "<scene><camera type='perspective'/><integrator type='normals'/>"
      "<mesh type='shapegroup' id='g'><mesh type='sphere'><bsdf type='mirror'/></mesh></mesh>"
      "<mesh type='instance'><ref id='g'/><transform name='toWorld'><translate value='1,2,3'/></transform></mesh></scene>");
  CHECK(d.shapes.empty());
  REQUIRE(d.groups.size() == 1);
  REQUIRE(d.groups[0].shapes.size() == 1);
  CHECK(d.groups[0].shapes[0].material.has_value());
  REQUIRE(d.instances.size() == 1);
  CHECK(d.instances[0].to_world == std::array<float, 12>{1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3});
}

TEST_CASE("instancing: errors name the line") {
  const auto message = [](const std::string& inside) { return test::error_of_text(test::mitsuba_scene(inside)); };
  const std::string group = "<shape type='shapegroup' id='g'><shape type='sphere'/></shape>\n";
  const std::string tests[][2] = {
      {"<shape type='instance'/>", "scene.xml:4: shape 'instance' needs a <ref> to a shapegroup"},
      {group + "<shape type='instance'><ref id='h'/></shape>", "scene.xml:5: no object has the id 'h'"},
      {"<shape type='sphere' id='s'/>\n<shape type='instance'><ref id='s'/></shape>",
       "scene.xml:5: shape 'instance' refers to a 'sphere', expected a 'shapegroup'"},
      {group + "<shape type='instance'><ref id='g'/><ref id='g'/></shape>", "scene.xml:5: shape 'instance' holds 2 nested"},
      {group + "<shape type='instance'><ref id='g'/>\n<bsdf type='diffuse'/></shape>", "scene.xml:6: shape 'instance' takes no nested <bsdf>"},
      {group + "<shape type='instance'><ref id='g'/><boolean name='flip_normals' value='true'/></shape>",
       "scene.xml:5: unknown property 'flip_normals' of shape 'instance'"},
      {group + "<shape type='instance'><ref id='g'/>\n<transform name='to_world'><scale value='1e-12'/></transform></shape>",
       "scene.xml:6: property 'to_world' of shape 'instance' is singular or too extreme"},
      {group + "<shape type='shapegroup' id='h'>\n<shape type='instance'><ref id='g'/></shape></shape>",
       "scene.xml:6: a shape group cannot hold a 'instance'"},
      {"<shape type='shapegroup'>\n<shape type='shapegroup'/></shape>", "scene.xml:5: a shape group cannot hold a 'shapegroup'"},
      {"<shape type='shapegroup' id='g'>\n<ref id='g'/></shape>", "scene.xml:4: a shape group cannot hold a 'shapegroup'"},
      {"<shape type='shapegroup'><bsdf type='diffuse'/></shape>", "takes no nested <bsdf>"},
  };
  for (const auto& [inside, expected] : tests) {
    const std::string found = message(inside);
    INFO(found);
    CHECK(test::contains(found, expected));
  }
}
