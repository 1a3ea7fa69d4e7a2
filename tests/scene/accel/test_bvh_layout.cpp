// Memory layouts of the acceleration structure: the compact one takes less memory and gives the same hits.
#include "scene/compile/compile.h"
#include "scene/compile/geometry/kept_geometry.h"
#include "tests/support/near.h"
#include "tests/support/tiny_scenes.h"
#include "tests/support/trace_testing.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

namespace sheaf::test_bvh_layout {

namespace {

/// Random triangles in a cube: large and small ones for spatial splits, in one mesh and in an instance.
Description triangles() {
  Description d = empty_scene(8, 8);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-1, 1);
  Mesh mesh;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const float size = i % 100 == 0 ? 1.0f : 0.05f;
    const Vec3f center{uniform(random), uniform(random), uniform(random)};
    for (int k = 0; k < 3; ++k)
      mesh.positions.push_back(center + Vec3f{uniform(random), uniform(random), uniform(random)} * size);
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  add_shape(d, mesh, Transform());
  d.groups.emplace_back();
  ShapeDescription part;
  part.geometry = mesh;
  d.groups.back().shapes.push_back(part);
  InstanceDescription instance;
  instance.to_world[3] = 1.5f;
  d.instances.push_back(instance);
  return d;
}

std::unique_ptr<Scene> compile(const Description& d, BvhChoice bvh, bool watertight = false) {
  CompileOptions options;
  options.bvh = bvh;
  options.watertight = watertight;
  return compile_scene(d, options);
}

}  // namespace

TEST_CASE("bvh: the compact layout gives the same hits in less memory") {
  const Description d = triangles();
  for (const bool watertight : {false, true}) {
    CAPTURE(watertight);
    const auto fast = compile(d, BvhChoice::kFast, watertight), compact = compile(d, BvhChoice::kCompact, watertight);
    CHECK(fast->info().bvh == BvhLayout::kFast);
    CHECK(compact->info().bvh == BvhLayout::kCompact);
    CHECK(compact->info().table_bytes == fast->info().table_bytes);
    CHECK(static_cast<double>(compact->info().accel_bytes) < 0.8 * static_cast<double>(fast->info().accel_bytes));
    std::mt19937 random(11);
    std::normal_distribution<float> normal;
    int hits = 0, different = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3f origin{normal(random), normal(random), normal(random)};
      const Vec3f direction = normalize_any(Vec3f{normal(random), normal(random), normal(random)});
      const auto a = trace_ray(fast->view(), origin, direction), b = trace_ray(compact->view(), origin, direction);
      hits += a.has_value() ? 1 : 0;
      const bool same = a.has_value() == b.has_value() &&
                        (!a || (a->t == b->t && a->u == b->u && a->v == b->v && a->primitive == b->primitive &&
                                a->shape == b->shape && a->instance == b->instance));
      different += same ? 0 : 1;
    }
    CHECK(hits > 10000);
    CHECK(different == 0);
  }
}

TEST_CASE("bvh: unused lanes of a packet hold anything and are not traced") {
  const auto scene = compile(triangles(), BvhChoice::kFast);
  const Vec3f origin{0.1f, 0.2f, -9}, forward{0, 0, 1};
  const auto hit = trace_ray(scene->view(), origin, forward);
  REQUIRE(hit);
  constexpr int kUsed = 5;
  const float nan = std::nanf("");
  RayPacket nearest, any;
  for (int i = 0; i < kPacketWidth; ++i)
    for (RayPacket* packet : {&nearest, &any}) packet->set_ray(i, i < kUsed ? origin : Vec3f{nan, 1e30f, nan}, forward);
  scene->view().accel->intersect(nearest, kUsed);
  scene->view().accel->occluded(any, kUsed);
  for (int i = 0; i < kPacketWidth; ++i) {
    CHECK(nearest.t_far[i] == (i < kUsed ? hit->t : -kInfinity));
    CHECK(nearest.shape[i] == (i < kUsed ? hit->shape : kNone));
    CHECK(any.t_far[i] == -kInfinity);
  }
}

TEST_CASE("bvh: the layout is compact by itself if the render leaves too little memory") {
  constexpr double kNoRoom = 1e18;  // more bytes than any machine has
  const Description d = triangles();
  const auto layout_with = [&](double bytes, BvhChoice bvh) {
    CompileOptions options;
    options.bvh = bvh;
    bool has_accel = true;
    options.render_bytes = [&](const Scene& scene) {
      has_accel = scene.view().accel != nullptr;
      CHECK(scene.view().geometry.shape_count == 2);
      return bytes;
    };
    const BvhLayout layout = compile_scene(d, options)->info().bvh;
    CHECK(has_accel == (bvh != BvhChoice::kAuto));
    return layout;
  };
  CHECK(layout_with(0, BvhChoice::kAuto) == BvhLayout::kFast);
  CHECK(layout_with(kNoRoom, BvhChoice::kAuto) == BvhLayout::kCompact);
  CHECK(layout_with(kNoRoom, BvhChoice::kFast) == BvhLayout::kFast);
  CHECK(layout_with(0, BvhChoice::kCompact) == BvhLayout::kCompact);
}

TEST_CASE("bvh: kept geometry is not reused with another layout") {
  const Description d = triangles();
  KeptGeometry kept;
  CompileOptions options;
  options.kept = &kept;
  options.bvh = BvhChoice::kFast;
  keep_geometry(compile_scene(d, options), kept);
  options.bvh = BvhChoice::kCompact;
  auto scene = compile_scene(d, options);
  CHECK(scene->info().bvh == BvhLayout::kCompact);
  const std::size_t bytes = scene->info().accel_bytes;
  keep_geometry(std::move(scene), kept);
  scene = compile_scene(d, options);
  CHECK(scene->info().bvh == BvhLayout::kCompact);
  CHECK(scene->info().accel_bytes == bytes);
}

TEST_CASE("bvh: few rays lead to faster builds unless a layout is chosen, and hit the same triangles") {
  const Description d = triangles();
  CompileOptions options;
  const auto compile_for = [&](double rays, BvhChoice bvh) {
    options.expected_rays = rays;
    options.bvh = bvh;
    return compile_scene(d, options);
  };
  constexpr double kFew = 100'000, kVeryFew = 40'000;  // 5 and 2 for each triangle of a structure
  const auto split = compile_for(kInfinity, BvhChoice::kAuto), unsplit = compile_for(kFew, BvhChoice::kAuto),
             curve = compile_for(kVeryFew, BvhChoice::kAuto);
  CHECK_FALSE(split->info().bvh_along_curve);
  CHECK_FALSE(unsplit->info().bvh_along_curve);
  CHECK(curve->info().bvh_along_curve);
  CHECK_FALSE(compile_for(0, BvhChoice::kFast)->info().bvh_along_curve);
  CHECK(split->info().bvh_splits == BvhSplits::kBuilt);
  CHECK(unsplit->info().bvh_splits == BvhSplits::kLeftOut);
  CHECK(unsplit->info().bvh == BvhLayout::kFast);
  CHECK(compile_for(0, BvhChoice::kFast)->info().bvh_splits == BvhSplits::kBuilt);
  CHECK(compile_for(0, BvhChoice::kFast)->info().bvh == BvhLayout::kFast);
  CHECK(compile_for(0, BvhChoice::kAuto)->info().bvh == BvhLayout::kCompact);
  std::mt19937 random(12);
  std::normal_distribution<float> normal;
  int different = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3f origin{normal(random), normal(random), normal(random)};
    const Vec3f direction = normalize_any(Vec3f{normal(random), normal(random), normal(random)});
    const auto a = trace_ray(split->view(), origin, direction);
    for (const Scene* other : {unsplit.get(), curve.get()}) {
      const auto b = trace_ray(other->view(), origin, direction);
      different += a.has_value() == b.has_value() && (!a || (a->t == b->t && a->primitive == b->primitive)) ? 0 : 1;
    }
  }
  CHECK(different == 0);
}

TEST_CASE("bvh: only sessions take a kept structure with spatial splits for few rays, and none lacks needed ones") {
  constexpr double kFew = 100'000;  // 5 for each triangle of a structure
  const Description d = triangles();
  for (const bool is_session : {false, true}) {
    CAPTURE(is_session);
    KeptGeometry kept;
    kept.expects_changes = is_session;
    const VertexRow* last = nullptr;  // rows of a new structure, which are made before the kept ones are freed
    const auto reuses = [&](double rays) {
      CompileOptions options;
      options.expected_rays = rays;
      options.kept = &kept;
      auto scene = compile_scene(d, options);
      const bool same = scene->view().geometry.vertices == last;
      const bool has_splits = scene->info().bvh_splits == BvhSplits::kBuilt;
      CHECK(has_splits == (rays > kFew || (same && is_session && kept.has(BvhBuild::kSpatial))));
      last = scene->view().geometry.vertices;
      keep_geometry(std::move(scene), kept);
      return same;
    };
    CHECK_FALSE(reuses(kFew));
    CHECK(reuses(kFew - 1));
    CHECK_FALSE(reuses(kInfinity));
    CHECK(reuses(kInfinity));
    CHECK(reuses(kFew) == is_session);
    CHECK(reuses(kInfinity) == is_session);
  }
}

TEST_CASE("bvh: kept structures serve scenes that need the same builds, and in sessions slower rays") {
  using enum BvhBuild;
  for (const bool is_session : {false, true}) {
    CAPTURE(is_session);
    KeptGeometry kept;
    kept.expects_changes = is_session;
    kept.builds = {kSurface, kMorton};
    CHECK(kept.serves({kSurface, kMorton}));
    CHECK(kept.serves({kMorton, kMorton}) == is_session);
    CHECK_FALSE(kept.serves({kSurface, kSurface}));
    CHECK_FALSE(kept.serves({kSpatial, kMorton}));
    CHECK(kept.has(kMorton));
    kept.is_updatable = true;
    CHECK(kept.serves({kSpatial, kSurface}));
    CHECK_FALSE(kept.has(kMorton));
  }
}

TEST_CASE("bvh: a kept fast layout serves few rays, and a compact one is replaced for many") {
  const Description d = triangles();
  KeptGeometry kept;
  kept.expects_changes = true;
  const auto layout_for = [&](double rays) {
    CompileOptions options;
    options.expected_rays = rays;
    options.kept = &kept;
    auto scene = compile_scene(d, options);
    const BvhLayout layout = scene->info().bvh;
    keep_geometry(std::move(scene), kept);
    return layout;
  };
  CHECK(layout_for(0) == BvhLayout::kCompact);
  CHECK(layout_for(kInfinity) == BvhLayout::kFast);
  CHECK(layout_for(0) == BvhLayout::kFast);
}

TEST_CASE("bvh: the memory by cause adds up to the tables and the acceleration structure") {
  const auto scene = compile(triangles(), BvhChoice::kFast);
  double sum = 0;
  for (const MemoryUse& use : scene->memory()) sum += use.bytes;
  const SceneInfo info = scene->info();
  CHECK(sum == near(static_cast<double>(info.table_bytes + info.accel_bytes)));
  CHECK(scene->memory()[0].what == "positions");
  CHECK(scene->memory()[0].bytes >= 12.0 * static_cast<double>(info.vertices));
}

}  // namespace sheaf::test_bvh_layout
