// Renders of shape groups, and rays that leave instances.
#include "core/math/frame.h"
#include "kernels/render/render.h"
#include "scene/compile/compile.h"
#include "tests/support/instancing_testing.h"
#include "tests/support/records_testing.h"
#include "tests/support/trace_testing.h"

#include <doctest/doctest.h>

#include <cmath>

namespace sheaf::test_instancing_render {

namespace {

/// Rays that leave a convex shape to its outside and through its inside: their number, hits of the shape, hits at
/// distance zero.
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
    // About one ray in a million slips between two triangles and sees a closed shape from inside.
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

TEST_CASE("instancing: both sides of surfaces have their materials") {
  for (const NamedTransform& placement : kPlacements) {
    CAPTURE(placement.name);
    const auto make = [&](bool instances) {
      Description d = empty_scene(48, 48);
      d.sampler.sample_count = 16;
      d.integrator.max_depth = 6;
      look_at(d, placement.to_world.point({0, 0, -7}), placement.to_world.point({0, 0, 0}), {0.1f, 1, 0.2f}, 50);
      const std::vector<MaterialId> materials = {
          add_material(d,
                       TwoSidedDescription{add_diffuse_rgb(d, 0.8f, 0.1f, 0.1f), add_diffuse_rgb(d, 0.1f, 0.8f, 0.1f)}),
          add_diffuse(d, 0.7f), add_glass(d), add_mirror(d), add_two_sided(d, add_diffuse(d, 0.5f))};
      std::vector<ShapeDescription> shapes = every_kind(materials);
      // Interpolated normals differ if they are interpolated before a non-uniform scale.
      std::erase_if(shapes, [](const ShapeDescription& shape) { return std::holds_alternative<Mesh>(shape.geometry); });
      if (instances) {
        add_instance(d, add_group(d, shapes), placement.to_world);
      } else {
        add_copies(d, shapes, placement.to_world);
      }
      add_rectangle(d, placement.to_world * Transform::translate({0, 0, 4}) * Transform::scale({6, 6, 6}),
                    add_two_sided(d, add_diffuse(d, 0.3f)));
      add_constant_light(d, 1);  // one light: the choice among several depends on the bounds of the scene
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
    // Few paths diverge after a rounding error. A wrong side or material would change whole shapes.
    CHECK(far < 0.03 * 3 * a.width * a.height);
    CHECK(std::fabs(difference) < 2e-3 * 3 * a.width * a.height);
  }
}

TEST_CASE("instancing: the bits do not depend on threads or wave size or BVH build") {
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

TEST_CASE("instancing: a ray that leaves a convex shape does not hit it again") {
  Mesh triangle;
  triangle.positions = {{-1, -0.9f, 0.3f}, {1, -0.7f, -0.2f}, {0.1f, 0.9f, 0.1f}};
  triangle.triangles = {{{0, 1, 2}}};
  Description kinds;
  add_shape(kinds, SphereShape{}, Transform());
  add_shape(kinds, DiskShape{}, Transform());
  add_shape(kinds, RectangleShape{}, Transform());
  add_shape(kinds, CubeShape{}, Transform::scale({0.7f, 0.7f, 0.7f}));
  add_shape(kinds, triangle, Transform());
  const Transform stretched =
      Transform::rotate({3, 1, -2}, 40) * Transform::scale({2, 0.4f, 1.1f}) * Transform::rotate({1, 0, 1}, 25);
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
            const Transform inside =
                Transform::translate({-3 * object, object, 2 * object}) * Transform::scale({object, object, object});
            shape.to_world = inside * shape.to_world;
            const float size = object * scale;
            const Transform outside = Transform::translate({away * size, -0.7f * away * size, 0.3f * away * size}) *
                                      form * Transform::scale({scale, scale, scale});
            add_instance(d, add_group(d, {shape}), outside);
            const auto scene = compile_scene(d);
            const bool closed =
                std::holds_alternative<SphereShape>(kind.geometry) || std::holds_alternative<CubeShape>(kind.geometry);
            const Tally tally = shoot(scene->view(), outside * inside, closed);
            CHECK(tally.starts > 100);
            CHECK(tally.self_hits == 0);
            CHECK(tally.early_hits == 0);
          }
}

TEST_CASE("instancing: no path escapes from a closed room that is an instance") {
  constexpr int kDepth = 6;
  for (const bool box : {false, true})
    for (const float scale : {1e-3f, 1.0f, 1e5f}) {
      CAPTURE(box);
      CAPTURE(scale);
      Description d = empty_scene(32, 32), inside;
      d.sampler.sample_count = 16;
      d.integrator.max_depth = kDepth;
      d.integrator.rr_depth = kDepth;
      d.integrator.strategy = LightStrategy::kBsdfOnly;
      look_at(d, {0, 0, 0}, Vec3f{0.7f, 0.2f, 0.4f} * scale);
      if (box) {
        add_shape(inside, CubeShape{}, Transform::rotate({1, 2, 3}, 25));
      } else {
        add_shape(inside, SphereShape{}, Transform());
      }
      inside.shapes[0].flip_normals = true;
      inside.shapes[0].material = add_diffuse(d, 0.5f);
      add_instance(d, add_group(d, inside.shapes),
                   Transform::rotate({1, -1, 2}, 70) * Transform::scale({scale, -scale, scale}));
      const RenderResult result = render(*compile_scene(d), {});
      CHECK(result.report.stats.dropped.rays == 0);
      CHECK(result.report.stats.rays.camera == 32 * 32 * 16);
      CHECK(result.report.stats.rays.scatter == 32 * 32 * 16 * (kDepth - 1));
    }
}

}  // namespace sheaf::test_instancing_render
