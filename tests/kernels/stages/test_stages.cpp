// The stages at both ends of a path: camera rays, intersection, debug images and the sample buffer; and all stages in
// SIMD lanes against one path at a time.
#include "kernels/guiding/guide_record.h"
#include "kernels/passes/passes.h"
#include "kernels/photons/photon_maps.h"
#include "tests/support/capture.h"
#include "tests/support/near.h"
#include "tests/support/stages_testing.h"
#include "tests/support/trace_testing.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <set>

namespace sheaf::test_stages {

TEST_CASE_TEMPLATE("camera rays: every sample of the task starts once in order and inside its pixel", L,
                   SHEAF_STAGE_LANES) {
  Description d = empty_scene(40, 30);
  look_at(d, {1, 2, 3}, {-1, 0, 4});
  const auto scene = compile_scene(d);
  const SceneView view = scene->view();
  for (const int paths : kTailSizes) {
    TestWave test(paths);
    Wave& wave = test.wave;
    test.begin({7, 11, 7 + paths, 13}, 4, 3, 64);
    const StageContext context = test.context(*scene);
    const int total = test.task.total();
    CHECK(total == paths * 2 * 3);
    int started = 0;
    while (started < total) {
      const int room = wave.free.size();
      camera_rays<L>(context, wave);
      CHECK(wave.active.size() == std::min(room, total - started));
      check_conservation(wave);
      for (const Slot slot : wave.active.span()) {
        const auto path = wave.paths.get(slot);
        const auto ray = wave.rays.get(slot);
        const auto radiance = wave.radiance.get(slot);
        const auto index = static_cast<std::uint32_t>(started++);
        const std::uint32_t pixel = index / 3, x = 7 + pixel % static_cast<std::uint32_t>(paths),
                            y = 11 + pixel / static_cast<std::uint32_t>(paths);
        CHECK(path.pixel == y * 64 + x);
        CHECK(path.sample == 4 + index % 3);
        CHECK(path.depth_and_dimension == 0u);
        CHECK(path.eta_scale == 1.0f);
        CHECK(record_difference<Spectrum>(path.beta, {1, 1, 1, 0}) == 0.0);
        CHECK(radiance.task_sample == index);
        CHECK(radiance.scatter_pdf == 0.0f);
        CHECK((radiance.task_sample & kTransparent) == 0);
        CHECK(radiance.weight == near(1));
        CHECK(is_black(radiance.radiance));
        CHECK(ray.flags == kRayFromCamera);
        CHECK(ray.t_max == kInfinity);
        CHECK(ray.origin == view.sensor.camera.origin);
        // The direction passes through the pixel.
        const Vec3f normal = normalize(cross(view.sensor.camera.dx, view.sensor.camera.dy));
        const Vec3f on_film = ray.direction * (dot(view.sensor.camera.corner, normal) / dot(ray.direction, normal)) -
                              view.sensor.camera.corner;
        const float film_x = dot(on_film, view.sensor.camera.dx) / length_squared(view.sensor.camera.dx);
        const float film_y = dot(on_film, view.sensor.camera.dy) / length_squared(view.sensor.camera.dy);
        CHECK(std::fabs(film_x - static_cast<float>(x) - 0.5f) <= 0.5001f);
        CHECK(std::fabs(film_y - static_cast<float>(y) - 0.5f) <= 0.5001f);
      }
      for (const Slot slot : wave.active.span()) wave.free.push(slot);
      wave.active.clear();
    }
    camera_rays<L>(context, wave);
    CHECK(wave.active.empty());
    CHECK(wave.stats.rays.camera == static_cast<std::uint64_t>(total));
  }
}

TEST_CASE_TEMPLATE("camera rays: partial tiles leave other slots unchanged and a crop changes no ray", L,
                   SHEAF_STAGE_LANES) {
  Description d = empty_scene(64, 64);
  d.film.filter.kind = PixelFilter::Kind::kLanczos;
  d.integrator.max_depth = 1;
  const auto scene = compile_scene(d);
  TestWave whole(64 * 64);
  whole.begin({0, 0, 64, 64}, 2, 1, 64);
  camera_rays<L>(whole.context(*scene), whole.wave);
  for (const int paths : kTailSizes) {
    TestWave part(paths);
    part.begin({9, 20, 9 + paths, 21}, 2, 1, 64);
    camera_rays<L>(part.context(*scene), part.wave);
    CHECK(part.spare_rows_untouched());
    for (int i = 0; i < paths; ++i) {
      const Slot a = part.wave.active[i], b = whole.wave.active[20 * 64 + 9 + i];
      CHECK(part.wave.rays.get(a).direction == whole.wave.rays.get(b).direction);
      CHECK(part.wave.rays.get(a).flags == (kRayFromCamera | kRayLast));
      CHECK(part.wave.paths.get(a).pixel == whole.wave.paths.get(b).pixel);
      CHECK(part.wave.radiance.get(a).weight == whole.wave.radiance.get(b).weight);
    }
  }
}

namespace {

/// A diffuse square at z = 2 and an emissive square at z = 4 beside it, in an otherwise empty scene.
std::unique_ptr<Scene> two_squares(bool hide_emitters = false) {
  Description d = empty_scene(8, 8);
  d.integrator.hide_emitters = hide_emitters;
  add_rectangle(d, Transform::translate({0, 0, 2}) * Transform::rotate({0, 1, 0}, 180),
                add_material(d, TwoSidedDescription{add_diffuse(d, 0.2f), add_diffuse(d, 0.7f)}));
  emit(add_rectangle(d, Transform::translate({3, 0, 4}) * Transform::rotate({0, 1, 0}, 180), add_diffuse(d, 0.4f)), 2);
  return compile_scene(d);
}

const Vec3f kForward{0, 0, 1};

}  // namespace

TEST_CASE_TEMPLATE("intersect: paths are pushed to the queue that matches their hit", L, SHEAF_STAGE_LANES) {
  const auto scene = two_squares();
  for (const int paths : kTailSizes) {
    TestWave test(paths);
    Wave& wave = test.wave;
    int surfaces = 0, lights = 0, misses = 0, last = 0;
    for (int i = 0; i < paths; ++i) {
      const float x = 0.01f * static_cast<float>(i % 7);
      const std::uint32_t flags = i % 5 == 4 ? kRayLast : 0u;
      test.add_active({static_cast<float>(i % 3) * 3 + x, 0.1f, 0}, kForward, flags);
      misses += i % 3 == 2;
      lights += i % 3 == 1;
      surfaces += i % 3 != 2 && flags == 0;
      last += i % 3 != 2 && flags != 0;
    }
    const std::vector<Slot> slots(wave.active.span().begin(), wave.active.span().end());
    intersect<L>(test.context(*scene), wave);
    CHECK(wave.active.empty());
    CHECK(wave.miss.size() == misses);
    CHECK(wave.emitter.size() == lights);
    CHECK(wave.surface.size() == surfaces);
    CHECK(wave.finished.size() == last);
    check_conservation(wave);
    CHECK(test.spare_rows_untouched());
    for (std::size_t i = 0; i < slots.size(); ++i) {
      const auto hit = wave.hits.get(slots[i]);
      CHECK(contains(wave.miss, slots[i]) == (i % 3 == 2));
      CHECK(contains(wave.emitter, slots[i]) == (i % 3 == 1));
      if (i % 3 == 2) continue;
      CHECK(hit.t == near(i % 3 == 0 ? 2 : 4));
      CHECK(hit.shape == i % 3);
      CHECK(hit.light == (i % 3 == 1 ? 0u : kNone));
    }
    CHECK(wave.stats.dropped.rays == 0);
    CHECK(wave.stats[stage_named("intersect")].items == static_cast<std::uint64_t>(paths));
  }
}

TEST_CASE_TEMPLATE("intersect: each side of a surface has its own material", L, SHEAF_STAGE_LANES) {
  const auto scene = two_squares();
  const SceneView view = scene->view();
  TestWave test(2);
  const Slot front = test.add_active({0, 0, 0}, kForward), back = test.add_active({0, 0, 3}, {0, 0, -1});
  intersect<L>(test.context(*scene), test.wave);
  const MaterialRow& seen = view.materials.rows[test.wave.hits.get(front).material];
  const MaterialRow& behind = view.materials.rows[test.wave.hits.get(back).material];
  CHECK(seen.words[0] == 0.2f);
  CHECK(behind.words[0] == 0.7f);
}

TEST_CASE_TEMPLATE("intersect: non-finite rays are dropped and counted and reported while their neighbors are traced",
                   L, SHEAF_STAGE_LANES) {
  const auto scene = two_squares();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<std::pair<Vec3f, Vec3f>> bad = {
      {{nan, 0, 0}, kForward},        {{0, nan, 0}, kForward},        {{0, 0, nan}, kForward},
      {{kInfinity, 0, 0}, kForward},  {{0, 0, -kInfinity}, kForward}, {{0, 1e30f, 0}, kForward},
      {{0, 0, 0}, {nan, 0, 1}},       {{0, 0, 0}, {0, nan, 1}},       {{0, 0, 0}, {0, 0, nan}},
      {{0, 0, 0}, {0, 0, kInfinity}}, {{0, 0, 0}, {0, 0, 0}}};
  for (std::size_t position = 0; position < bad.size(); ++position) {
    const int paths = 21, at = 3 + static_cast<int>(position);
    TestWave test(paths);
    Wave& wave = test.wave;
    Slot dropped = 0;
    for (int i = 0; i < paths; ++i) {
      const Slot slot =
          i == at ? test.add_active(bad[position].first, bad[position].second) : test.add_active({0, 0, 0}, kForward);
      if (i == at) dropped = slot;
    }
    intersect<L>(test.context(*scene), wave);
    CAPTURE(position);
    CHECK(wave.finished.size() == 1);
    CHECK(wave.finished[0] == dropped);
    CHECK(wave.surface.size() == paths - 1);
    CHECK(wave.stats.dropped.rays == 1);
    CHECK(wave.first_dropped.any);
    CHECK(wave.first_dropped.pixel == static_cast<std::uint32_t>(at));
    check_conservation(wave);
  }
}

TEST_CASE_TEMPLATE("intersect: hidden lights are left to emission", L, SHEAF_STAGE_LANES) {
  const auto scene = two_squares(true);
  TestWave test(3);
  Wave& wave = test.wave;
  const Slot hidden = test.add_active({3, 0, 0}, kForward, kRayFromCamera), seen = test.add_active({3, 0, 0}, kForward);
  const Slot hidden_last = test.add_active({3, 0, 0}, kForward, kRayFromCamera | kRayLast);
  intersect<L>(test.context(*scene), wave);
  CHECK(wave.emitter.size() == 3);
  CHECK(wave.surface.size() == 1);
  CHECK(wave.surface[0] == seen);
  CHECK(wave.finished.empty());
  emission<L>(test.context(*scene), wave);
  CHECK(wave.active.size() == 2);
  CHECK(contains(wave.active, hidden));
  CHECK(contains(wave.active, hidden_last));
  CHECK(wave.rays.get(hidden).origin.z > 4.0f);
  CHECK(wave.rays.get(hidden).origin.z < 4.001f);
  CHECK(wave.rays.get(hidden).flags == kRayFromCamera);
  CHECK(is_black(wave.radiance.get(hidden).radiance));
  CHECK(wave.radiance.get(seen).radiance.c0 == near(2));
  check_conservation(wave);
  // There is nothing behind it, so the sample is transparent.
  intersect<L>(test.context(*scene), wave);
  emission<L>(test.context(*scene), wave);
  CHECK(wave.finished.size() == 2);
  CHECK((wave.radiance.get(hidden).task_sample & kTransparent) != 0);
  CHECK((wave.radiance.get(seen).task_sample & kTransparent) == 0);
}

TEST_CASE_TEMPLATE("camera rays: a list of pixels can have individual sample ranges", L, SHEAF_STAGE_LANES) {
  const auto scene = compile_scene(empty_scene(10, 10));
  const std::vector<PixelSamples> pixels = {{0, 3, 0}, {57, 2, 5}, {3, 0, 1}, {98, 7, 0}, {12, 1, 40}, {99, 0, 0}};
  TestWave test(20);
  Wave& wave = test.wave;
  test.task.begin(pixels, {10}, kBeautyChannels);
  CHECK(test.task.total() == 46);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> expected, started;
  for (const PixelSamples& p : pixels)
    for (std::uint32_t i = 0; i < p.sample_count; ++i) expected.emplace_back(p.pixel, p.first_sample + i);
  while (test.task.left() > 0) {
    camera_rays<L>(test.context(*scene), wave);
    for (const Slot slot : wave.active.span()) {
      CHECK(wave.radiance.get(slot).task_sample == started.size());
      started.emplace_back(wave.paths.get(slot).pixel, wave.paths.get(slot).sample);
      wave.free.push(slot);
    }
    wave.active.clear();
  }
  CHECK(started == expected);
}

TEST_CASE_TEMPLATE("stages: empty queues do no work", L, SHEAF_STAGE_LANES) {
  const auto scene = compile_scene(mixed_scene());
  TestWave test(9);
  Wave& wave = test.wave;
  while (test.task.left() > 0) test.task.advance();
  for (const StageEntry& stage : kStages<L>) {
    CAPTURE(stage.name);
    const StageContext context = test.context(*scene);
    if (!stage.takes_part(context)) continue;
    stage.run(context, wave);
    check_conservation(wave);
    CHECK(wave.free.size() == wave.capacity);
    CHECK(wave.stats[stage.stage].items == 0);
  }
  CHECK(test.spare_rows_untouched());
  CHECK(wave.shadow_count == 0);
}

namespace {

/// Runs a stage. Checks that it changes only the queues that it consumes or produces, and empties those that it
/// consumes.
void run_and_check_queues(const StageEntry& stage, const StageContext& context, Wave& wave) {
  CAPTURE(stage.name);
  std::vector<std::vector<Slot>> before;
  for (const SlotList PathPool::*list : PathPool::kLists)
    before.emplace_back((wave.*list).span().begin(), (wave.*list).span().end());
  const int shadows = wave.shadow_count;
  stage.run(context, wave);
  check_conservation(wave);
  for (int i = 0; i < kSlotLists; ++i) {
    CAPTURE(i);
    const auto queue = static_cast<Queue>(i);
    const SlotList& list = wave.*PathPool::kLists[i];
    const auto& old = before[static_cast<std::size_t>(i)];
    if (stage.produces.contains(queue)) continue;
    if (!stage.consumes.contains(queue))
      CHECK(std::equal(old.begin(), old.end(), list.span().begin(), list.span().end()));
    else if (!stage.is_source())
      CHECK(list.empty());
  }
  if (stage.consumes.contains(Queue::kShadows))
    CHECK(wave.shadow_count == 0);
  else if (!stage.produces.contains(Queue::kShadows))
    CHECK(wave.shadow_count == shadows);
}

}  // namespace

TEST_CASE_TEMPLATE("stages: only declared queues change and consumed queues are empty afterwards", L,
                   SHEAF_STAGE_LANES) {
  Description d = mixed_scene();
  add_media_and_masks(d);
  Photon photon;
  photon.p = {0, -1.5f, 4};
  const PhotonMap map({{photon}}, 1, 10, PhotonKernel::kDisc);
  const VolumePhotonMaps volume{VolumePhotonMap({{photon}}, 1, 10, PhotonKernel::kDisc), {}};
  struct Case {
    IntegratorKind kind;
    bool from_lights, with_volume, guided = false;
  };
  const GuideMixture mixture;
  const float unknown = -1;
  TrainingSamples log;
  log.begin(512);
  for (const auto& [kind, from_lights, with_volume, guided] :
       {Case{IntegratorKind::kPath, false, false}, Case{IntegratorKind::kPath, false, false, true},
        Case{IntegratorKind::kNormals, false, false}, Case{IntegratorKind::kVisibility, false, false},
        Case{IntegratorKind::kPhotonMapper, false, false}, Case{IntegratorKind::kPhotonMapper, false, true},
        Case{IntegratorKind::kPhotonMapper, true, false}, Case{IntegratorKind::kLightTracer, true, false}}) {
    CAPTURE_BINDING(kind);
    CAPTURE_BINDING(from_lights);
    CAPTURE_BINDING(with_volume);
    CAPTURE_BINDING(guided);
    const PhotonMaps maps{map.view(),
                          {},
                          with_volume ? PhotonGathering::kIndirect : PhotonGathering::kAll,
                          with_volume ? &volume : nullptr};
    d.integrator.kind = kind;
    const auto scene = compile_scene(d);
    TestWave test(70);
    Wave& wave = test.wave;
    test.begin({0, 0, 16, 16}, 0, 2, 16);
    StageContext context = from_lights ? test.photon_context(*scene, 1000) : test.context(*scene);
    if (kind == IntegratorKind::kPhotonMapper && !from_lights) context.gather_from(maps);
    if (guided) {
      context.sample_from({.mixtures = &mixture, .means = &unknown});
      context.record_in(log);
    }
    std::set<Stage> worked;
    for (int step = 0; step < 20; ++step)
      for (const StageEntry& stage : kStages<L>) {
        if (!stage.takes_part(context)) continue;
        run_and_check_queues(stage, context, wave);
        if (wave.stats[stage.stage].items > 0) worked.insert(stage.stage);
      }
    for (const StageEntry& stage : kStages<L>) {
      CAPTURE(stage.name);
      CHECK(worked.contains(stage.stage) == stage.takes_part(context));
    }
  }
}

TEST_CASE_TEMPLATE("debug view: normals and depth of the first surface are shown", L, SHEAF_STAGE_LANES) {
  Description d = empty_scene(4, 4);
  add_sphere(d, {0, 0, 5}, 2);
  for (const IntegratorKind kind : {IntegratorKind::kNormals, IntegratorKind::kDepth}) {
    d.integrator.kind = kind;
    const auto scene = compile_scene(d);
    for (const int paths : kTailSizes) {
      TestWave test(paths);
      Wave& wave = test.wave;
      for (int i = 0; i < paths; ++i) test.add_active({i % 4 == 3 ? 9.0f : 1.2f, 0, 0}, kForward, kRayFromCamera);
      intersect<L>(test.context(*scene), wave);
      debug_view<L>(test.context(*scene), wave);
      check_conservation(wave);
      CHECK(test.spare_rows_untouched());
      REQUIRE(wave.finished.size() == paths);
      for (const Slot slot : wave.finished.span()) {
        const auto r = wave.radiance.get(slot);
        const bool missed = r.task_sample % 4 == 3;
        CHECK(((r.task_sample & kTransparent) != 0) == missed);
        if (missed)
          CHECK(is_black(r.radiance));
        else if (kind == IntegratorKind::kDepth)
          CHECK(record_difference<Spectrum>(r.radiance, {3.4f, 3.4f, 3.4f, 0}) < 1e-5);
        else
          CHECK(record_difference<Spectrum>(r.radiance, {0.6f, 0, 0.8f, 0}) < 1e-5);
      }
    }
  }
}

TEST_CASE_TEMPLATE("accumulate: finished paths add their weighted radiance to their own samples", L,
                   SHEAF_STAGE_LANES) {
  const auto scene = compile_scene(empty_scene(4, 4));
  for (const int paths : kTailSizes) {
    TestWave test(paths);
    Wave& wave = test.wave;
    for (int i = 0; i < paths; ++i) {
      const Slot slot = test.add({0, 0, 0}, kForward);
      const auto value = static_cast<float>(i + 1);
      const std::uint32_t transparent = i % 2 == 0 ? kTransparent : 0u;
      wave.radiance.set(slot,
                        {{value, 2 * value, 3 * value, 0}, 0, 0, -0.25f, static_cast<std::uint32_t>(i) | transparent});
      wave.finished.push(slot);
    }
    accumulate<L>(test.context(*scene), wave);
    CHECK(wave.finished.empty());
    CHECK(wave.free.size() == wave.capacity);
    check_conservation(wave);
    CHECK(wave.stats.samples == static_cast<std::uint64_t>(paths));
    for (int i = 0; i < paths; ++i) {
      const float* s = test.task.samples[static_cast<std::size_t>(i)];
      const auto value = static_cast<float>(i + 1);
      CHECK(s[kRed] == -0.25f * value);
      CHECK(s[kGreen] == -0.5f * value);
      CHECK(s[kBlue] == -0.75f * value);
      CHECK(s[kAlpha] == (i % 2 == 0 ? 0.0f : -0.25f));
    }
  }
}

TEST_CASE_TEMPLATE("accumulate: non-finite and negative samples are dropped and reported", L, SHEAF_STAGE_LANES) {
  const auto scene = compile_scene(empty_scene(4, 4));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Spectrum4> bad = {{nan, 0, 0, 0}, {0, nan, 0, 0},    {0, 0, nan, 0}, {kInfinity, 0, 0, 0},
                                      {-1, 5, 5, 0},  {1, -1e-3f, 1, 0}, {1, 1, -1, 0},  {kInfinity, 0, -kInfinity, 0}};
  TestWave test(static_cast<int>(bad.size()) + 2);
  Wave& wave = test.wave;
  for (std::size_t i = 0; i < bad.size() + 2; ++i) {
    const Slot slot = test.add({0, 0, 0}, kForward);
    const bool good = i == 0 || i == bad.size() + 1;
    wave.radiance.set(slot, {good ? Spectrum4(1.0f) : bad[i - 1], 0, 0, 1, static_cast<std::uint32_t>(i)});
    wave.finished.push(slot);
  }
  accumulate<L>(test.context(*scene), wave);
  CHECK(wave.stats.samples == 2);
  CHECK(wave.stats.dropped.samples == bad.size());
  CHECK(wave.first_dropped.any);
  CHECK(wave.first_dropped.pixel == 1u);
  for (std::size_t i = 0; i < bad.size() + 2; ++i)
    CHECK(test.task.samples.is_dropped(i) == (i != 0 && i != bad.size() + 1));
  CHECK(wave.free.size() == wave.capacity);
}

TEST_CASE_TEMPLATE("stages: a ray recorder sees every ray", L, SHEAF_STAGE_LANES) {
  struct Counter : RayRecorder {
    int nearest = 0, any = 0;
    void record(const RayPacket&, int count, Query query) override {
      (query == Query::kNearest ? nearest : any) += count;
    }
  } counter;
  const auto scene = compile_scene(mixed_scene());
  TestWave test(100);
  test.begin({0, 0, 16, 16}, 0, 1, 16);
  test.wave.recorder = &counter;
  run_pass<L>(test.context(*scene), test.wave);
  const auto& rays = test.wave.stats.rays;
  CHECK(rays.camera == 256);
  CHECK(static_cast<std::uint64_t>(counter.nearest) == rays.camera + rays.scatter);
  CHECK(static_cast<std::uint64_t>(counter.any) == rays.shadow);
  CHECK(rays.shadow > 50);
  CHECK(test.wave.free.size() == test.wave.capacity);
}

TEST_CASE_TEMPLATE("stages: the samples of a task do not depend on the size of the wave", L, SHEAF_STAGE_LANES) {
  Description d = mixed_scene();
  d.integrator.max_depth = 12;
  const auto scene = compile_scene(d);
  std::vector<std::vector<float>> results;
  for (const int capacity : {1, 7, 64, 1000}) {
    TestWave test(capacity, 0);
    test.begin({0, 0, 16, 16}, 0, 2, 16);
    run_pass<L>(test.context(*scene), test.wave);
    CHECK(test.wave.stats.samples == 512);
    results.emplace_back(test.task.samples[0], test.task.samples[512]);
    CHECK(std::memcmp(results.front().data(), results.back().data(), 512 * kBeautyChannels * sizeof(float)) == 0);
  }
}

}  // namespace sheaf::test_stages
