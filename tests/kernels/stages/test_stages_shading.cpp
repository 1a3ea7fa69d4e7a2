// The stages between a hit and the next ray: sorting, surface inputs, light sampling, shadow rays, emission,
// scattering.
#include "kernels/bsdf/list.h"
#include "kernels/lights/light_sample.h"
#include "tests/support/near.h"
#include "tests/support/stages_testing.h"
#include "tests/support/statistics.h"

#include <cmath>
#include <map>

namespace sheaf::test_stages_shading {

namespace {

/// Squares at z = 2 that face -z, at x = 0, 3, 6 ...: gray, mirror, glass, light gray, and a turned one that shows its
/// back, which is brighter than its front. A point light of intensity 10 is at (0, 0, -1).
constexpr int kSquares = 5;
enum Square { kGray, kMirror, kGlass, kLightGray, kRotated };

Description squares(bool with_light = true) {
  Description d = empty_scene(8, 8);
  const MaterialId materials[] = {add_diffuse(d, 0.25f), add_mirror(d, 0.5f), add_glass(d), add_diffuse(d, 0.75f),
                                  add_material(d, TwoSidedDescription{add_diffuse(d, 0.1f), add_diffuse(d, 0.6f)})};
  for (int i = 0; i < kSquares; ++i)
    add_rectangle(
        d,
        Transform::translate({3 * static_cast<float>(i), 0, 2}) * Transform::rotate({0, 1, 0}, i == kRotated ? 0 : 180),
        materials[i]);
  if (with_light) add_point_light(d, {0, 0, -1}, 10);
  return d;
}

/// A wave whose path i has hit square `square_of(i)` at an angle, after sorting and the evaluation of surface inputs.
template <class L> class ShadedWave : public TestWave {
 public:
  template <class F> ShadedWave(const Scene& scene, int paths, F&& square_of) : TestWave(paths) {
    for (int i = 0; i < paths; ++i) {
      const float x = 3 * static_cast<float>(square_of(i)), shift = 0.03f * static_cast<float>(i % 11);
      const Slot slot = add_active({x + shift - 0.4f, 0.2f, 0}, normalize(Vec3f{0.1f, -0.05f, 1}));
      square_of_slot[slot] = square_of(i);
    }
    const StageContext all = context(scene);
    intersect<L>(all, wave);
    sort_surfaces<L>(all, wave);
    surface_inputs<L>(all, wave);
  }
  std::map<Slot, int> square_of_slot;
};

int mixed(int i) { return (i * 3 + i / 4) % kSquares; }

ClosureKind kind_of(int square) {
  return square == kMirror  ? kClosureKind<ConductorClosure>
         : square == kGlass ? kClosureKind<DielectricClosure>
                            : kClosureKind<DiffuseClosure>;
}
double reflectance_of(int square) {
  constexpr double kReflectance[] = {0.25, 0.5, 1, 0.75, 0.6};
  return kReflectance[square];
}

/// Calls f(slot, column, kind) for every item of every run.
template <class F> void for_each_item(const Wave& wave, F&& f) {
  for (int kind = 0; kind < kClosureKinds; ++kind)
    for (int i = 0; i < wave.runs[kind].count; ++i)
      f(wave.sorted[wave.runs[kind].slot_begin + i], wave.runs[kind].column_begin + i, static_cast<ClosureKind>(kind));
}

}  // namespace

TEST_CASE_TEMPLATE("sort: hits are sorted by kind and material and the sort is stable", L, SHEAF_STAGE_LANES) {
  const auto scene = compile_scene(squares());
  for (const int paths : kTailSizes) {
    ShadedWave<L> test(*scene, paths, mixed);
    const Wave& wave = test.wave;
    check_conservation(wave);
    CHECK(wave.surface.empty());
    CHECK(wave.sorted.size() == paths);
    int total = 0, column = 0;
    for (const VertexRun& run : wave.runs) {
      CHECK(run.slot_begin == total);
      CHECK(run.column_begin % kWidth == 0);
      CHECK(run.column_begin >= column);
      total += run.count;
      column = run.column_begin + run.count;
    }
    CHECK(total == paths);
    std::uint32_t last_bucket = 0, last_pixel = 0;
    for_each_item(wave, [&](Slot slot, int, ClosureKind kind) {
      CHECK(kind == kind_of(test.square_of_slot[slot]));
      const std::uint32_t bucket = scene->view().materials.rows[wave.hits.get(slot).material].bucket,
                          pixel = wave.paths.get(slot).pixel;
      CHECK(bucket >= last_bucket);
      if (bucket == last_bucket) CHECK(pixel >= last_pixel);
      last_bucket = bucket;
      last_pixel = pixel;
    });
  }
}

TEST_CASE_TEMPLATE("sort: ranges of kinds without hits are empty", L, SHEAF_STAGE_LANES) {
  const auto scene = compile_scene(squares());
  for (const int square : {kGray, kMirror, kGlass})
    for (const int paths : kTailSizes) {
      ShadedWave<L> test(*scene, paths, [square](int) { return square; });
      for (int kind = 0; kind < kClosureKinds; ++kind)
        CHECK(test.wave.runs[kind].count == (static_cast<ClosureKind>(kind) == kind_of(square) ? paths : 0));
    }
}

TEST_CASE_TEMPLATE("surface inputs: positions and frames and parameters are set for every hit", L, SHEAF_STAGE_LANES) {
  const auto scene = compile_scene(squares());
  for (const int paths : kTailSizes) {
    ShadedWave<L> test(*scene, paths, mixed);
    Wave& wave = test.wave;
    CHECK(test.spare_rows_untouched());
    for_each_item(wave, [&](Slot slot, int column, ClosureKind) {
      const int square = test.square_of_slot[slot];
      const auto item = wave.vertices.template load<Scalar>(column);
      const auto ray = wave.rays.get(slot);
      const auto hit = wave.hits.get(slot);
      CHECK(record_difference<Vec3>(item.p, ray.origin + ray.direction * hit.t) < 1e-6);
      CHECK(item.p.z == near(2));
      CHECK(item.ng.z == near(square == kRotated ? 1 : -1));
      CHECK(item.ns.z == near(-1));
      CHECK(item.wo.z == near(ray.direction.z));
      CHECK(record_difference<Vec3>(Frame<Scalar>::from_normal(item.ns).to_world(item.wo), -ray.direction) < 1e-6);
      CHECK(item.offset > 0.0f);
      CHECK(item.offset < 1e-4f);
      const MaterialRow& material = scene->view().materials.rows[hit.material];
      const auto closure = wave.closures.template load<Scalar>(column);
      const int words = kind_of(square) == kClosureKind<DiffuseClosure>     ? 4
                        : kind_of(square) == kClosureKind<ConductorClosure> ? 12
                                                                            : 9;
      for (int k = 0; k < words; ++k) CHECK(closure.words[k] == material.words[k]);
      if (kind_of(square) == kClosureKind<DiffuseClosure>) CHECK(closure.words[1] == near(reflectance_of(square)));
    });
  }
}

/// The stages of the path pass between surface inputs and shadow rays.
template <class L> void sample_lights(const StageContext& context, Wave& wave) {
  for (int candidate = 0; candidate < context.candidates; ++candidate) {
    light_candidates<L>(context, wave, candidate);
    resample<L>(context, wave, candidate);
  }
}

TEST_CASE_TEMPLATE("light candidates: a point light matches its closed form and specular surfaces get none", L,
                   SHEAF_STAGE_LANES) {
  const auto scene = compile_scene(squares());
  const Vec3f light{0, 0, -1};
  for (const int paths : kTailSizes) {
    ShadedWave<L> test(*scene, paths, mixed);
    Wave& wave = test.wave;
    for (auto& [slot, square] : test.square_of_slot) {
      auto path = wave.paths.get(slot);
      path.beta = {0.5f, 0.25f, 2, 0};
      wave.paths.set(slot, path);
    }
    sample_lights<L>(test.context(*scene), wave);
    CHECK(wave.shadow_count == wave.runs[0].count);
    check_conservation(wave);
    CHECK(test.spare_rows_untouched());
    int i = 0;
    for_each_item(wave, [&](Slot slot, int column, ClosureKind kind) {
      if (kind != kClosureKind<DiffuseClosure>) return;
      const auto ray = wave.shadows.template load<Scalar>(i++);
      const auto item = wave.vertices.template load<Scalar>(column);
      CHECK(ray.slot == slot);
      CHECK(ray.origin.z < 2.0f);
      CHECK(length(ray.origin - item.p) <= item.offset * 1.01f);
      CHECK(length(ray.origin + ray.direction - light) < 1e-6f);
      const Vec3f d = light - item.p;
      const double squared = length_squared(d), cos_theta = -d.z / std::sqrt(squared);
      const double expected = reflectance_of(test.square_of_slot[slot]) / 3.14159265358979 * cos_theta * 10 / squared;
      CHECK(ray.contribution.c0 == near(0.5 * expected, 1e-5));
      CHECK(ray.contribution.c1 == near(0.25 * expected, 1e-5));
      CHECK(ray.contribution.c2 == near(2 * expected, 1e-5));
    });
  }
}

TEST_CASE_TEMPLATE("light candidates: each sampling strategy applies its MIS weight", L, SHEAF_STAGE_LANES) {
  Description d = squares(false);
  emit(add_shape(d, DiskShape{}, Transform::translate({1, 0, -1})), 4);
  std::vector<ShadowItem<Scalar>> alone, mis;
  for (const LightStrategy strategy : {LightStrategy::kBsdfOnly, LightStrategy::kLightOnly, LightStrategy::kMis}) {
    d.integrator.strategy = strategy;
    const auto scene = compile_scene(d);
    ShadedWave<L> test(*scene, 37, [](int) { return 0; });
    sample_lights<L>(test.context(*scene), test.wave);
    if (strategy == LightStrategy::kBsdfOnly) CHECK(test.wave.shadow_count == 0);
    for (int i = 0; i < test.wave.shadow_count; ++i)
      (strategy == LightStrategy::kMis ? mis : alone).push_back(test.wave.shadows.template load<Scalar>(i));
  }
  REQUIRE(alone.size() == 37);
  REQUIRE(mis.size() == 37);
  for (std::size_t i = 0; i < 37; ++i) {
    // The light, a disk of radius 1, is parallel to the surface, so that both cosines are equal.
    const double squared = length_squared(alone[i].direction), cos_theta = -alone[i].direction.z / std::sqrt(squared);
    const double pdf_light = squared / cos_theta / 3.14159265358979, pdf_bsdf = cos_theta / 3.14159265358979;
    CHECK(alone[i].contribution.c0 == near(0.25 / 3.14159265358979 * cos_theta * 4 / pdf_light, 1e-4));
    const double weight = pdf_light * pdf_light / (pdf_light * pdf_light + pdf_bsdf * pdf_bsdf);
    CHECK(mis[i].contribution.c0 == near(alone[i].contribution.c0 * weight, 1e-4));
  }
}

TEST_CASE_TEMPLATE("light candidates: unlit and backfacing and black surfaces get no shadow rays", L,
                   SHEAF_STAGE_LANES) {
  Description dark = squares(false), behind = squares(false), black = squares();
  add_point_light(behind, {0, 0, 5}, 10);
  for (MaterialDescription& m : black.materials) m.model = DiffuseDescription{SpectrumDescription::constant(0)};
  for (const Description& d : {dark, behind, black}) {
    const auto scene = compile_scene(d);
    ShadedWave<L> test(*scene, 21, [](int i) { return i % 2 == 0 ? kGray : kLightGray; });
    sample_lights<L>(test.context(*scene), test.wave);
    CHECK(test.wave.shadow_count == 0);
  }
}

TEST_CASE_TEMPLATE("shadow: unoccluded contributions are added to their own paths", L, SHEAF_STAGE_LANES) {
  Description d = empty_scene(4, 4);
  add_rectangle(d, Transform::translate({0, 0, 1}));
  const auto scene = compile_scene(d);
  for (const int paths : kTailSizes) {
    TestWave test(paths);
    Wave& wave = test.wave;
    std::vector<Slot> slots;
    for (int i = 0; i < paths; ++i) {
      const Slot slot = test.add({0, 0, 0}, {0, 0, 1});
      auto r = wave.radiance.get(slot);
      r.radiance = {1, 2, 3, 0};
      wave.radiance.set(slot, r);
      wave.surface.push(slot);
      slots.push_back(slot);
      // Through the square, past it, and ending just before it.
      const Vec3f origin{i % 3 == 1 ? 3.0f : 0.1f, 0.1f, 0}, direction{0, 0, i % 3 == 2 ? 0.99f : 4.0f};
      wave.shadows.template store<Scalar>(i, {origin, direction, {0.5f, 0.25f, static_cast<float>(i), 0}, slot, 0});
    }
    wave.shadow_count = paths;
    shadow<L>(test.context(*scene), wave);
    CHECK(wave.shadow_count == 0);
    CHECK(wave.stats.rays.shadow == static_cast<std::uint64_t>(paths));
    check_conservation(wave);
    CHECK(test.spare_rows_untouched());
    for (int i = 0; i < paths; ++i) {
      const auto r = wave.radiance.get(slots[static_cast<std::size_t>(i)]);
      const bool blocked = i % 3 == 0;
      CHECK(r.radiance.c0 == (blocked ? 1.0f : 1.5f));
      CHECK(r.radiance.c1 == (blocked ? 2.0f : 2.25f));
      CHECK(r.radiance.c2 == (blocked ? 3.0f : 3.0f + static_cast<float>(i)));
      CHECK((r.task_sample & kTransparent) == 0);
      CHECK(r.task_sample == static_cast<std::uint32_t>(i));
    }
  }
}

TEST_CASE_TEMPLATE("scatter: every path continues by its own closure", L, SHEAF_STAGE_LANES) {
  const auto scene = compile_scene(squares());
  for (const int paths : kTailSizes) {
    ShadedWave<L> test(*scene, paths, mixed);
    Wave& wave = test.wave;
    std::map<Slot, Vec3f> before, point;
    for (const auto& [slot, square] : test.square_of_slot) before[slot] = wave.rays.get(slot).direction;
    for_each_item(
        wave, [&](Slot slot, int column, ClosureKind) { point[slot] = wave.vertices.template load<Scalar>(column).p; });
    scatter<L>(test.context(*scene), wave);
    check_conservation(wave);
    CHECK(test.spare_rows_untouched());
    CHECK(wave.active.size() == paths);
    CHECK(wave.stats.rays.scatter == static_cast<std::uint64_t>(paths));
    for (const auto& [slot, square] : test.square_of_slot) {
      const auto ray = wave.rays.get(slot);
      const auto path = wave.paths.get(slot);
      const Vec3f in = before[slot];
      CHECK(path.depth_and_dimension == kOneDepth + kOneDimension);
      CHECK(ray.flags == 0u);
      CHECK(ray.t_max == kInfinity);
      CHECK(length(ray.direction) == near(1, 1e-6));
      CHECK(length(ray.origin - point[slot]) < 1e-4f);
      CHECK((ray.origin.z - 2) * ray.direction.z > 0.0f);
      const float pdf = wave.radiance.get(slot).scatter_pdf;
      if (kind_of(square) == kClosureKind<DiffuseClosure>) {
        CHECK(ray.direction.z < 0.0f);
        CHECK(pdf == near(-ray.direction.z * kInvPi, 1e-4));
      } else {
        CHECK(pdf == 0.0f);
      }
      if (kind_of(square) == kClosureKind<ConductorClosure>)
        CHECK(record_difference<Vec3>(ray.direction, {in.x, in.y, -in.z}) < 1e-6);
      if (square == kGlass && ray.direction.z > 0) {
        CHECK(record_difference<Vec3>({ray.direction.x * 1.5f, ray.direction.y * 1.5f, 0}, {in.x, in.y, 0}) < 1e-6);
        CHECK(path.eta_scale == near(2.25));
        CHECK(path.beta.c0 == near(1 / 2.25));
      } else {
        CHECK(path.eta_scale == 1.0f);
        CHECK(path.beta.c0 == near(reflectance_of(square)));
      }
    }
  }
}

TEST_CASE_TEMPLATE("scatter: absorbed paths and paths of maximum depth end", L, SHEAF_STAGE_LANES) {
  Description d = squares();
  d.materials[0].model = DiffuseDescription{SpectrumDescription::constant(0)};
  d.shapes[kMirror].to_world = Transform::translate({3, 0, 2});  // shows its back, which is black
  const auto scene = compile_scene(d);
  ShadedWave<L> test(*scene, 37, [](int i) { return i % 4; });
  Wave& wave = test.wave;
  for (const auto& [slot, square] : test.square_of_slot) {
    auto path = wave.paths.get(slot);
    path.depth_and_dimension = square == kGlass ? kLongestPath - 1 : 0;
    wave.paths.set(slot, path);
  }
  scatter<L>(test.context(*scene), wave);
  check_conservation(wave);
  for (const auto& [slot, square] : test.square_of_slot) {
    CHECK(contains(wave.active, slot) == (square == kLightGray));
    CHECK(contains(wave.finished, slot) == (square != kLightGray));
  }
}

TEST_CASE_TEMPLATE("scatter: the ray that reaches max_depth is the last", L, SHEAF_STAGE_LANES) {
  for (const int max_depth : {-1, 2, 3, 4, 100})
    for (const std::uint32_t depth : {0u, 1u, 2u, 40u}) {
      Description d = squares();
      d.integrator.max_depth = max_depth;
      d.integrator.rr_depth = 1000;
      const auto scene = compile_scene(d);
      ShadedWave<L> test(*scene, 5, mixed);
      for (const auto& [slot, square] : test.square_of_slot) {
        auto path = test.wave.paths.get(slot);
        path.depth_and_dimension = depth * (kOneDepth + kOneDimension);
        test.wave.paths.set(slot, path);
      }
      scatter<L>(test.context(*scene), test.wave);
      // The next ray ends a path of depth + 2 edges, including the one from the camera.
      const bool last = max_depth >= 0 && static_cast<int>(depth) + 2 >= max_depth;
      for (const Slot slot : test.wave.active.span()) CHECK(test.wave.rays.get(slot).flags == (last ? kRayLast : 0u));
    }
}

TEST_CASE_TEMPLATE("scatter: Russian roulette follows the throughput and reweights survivors", L, SHEAF_STAGE_LANES) {
  Description d = squares();
  d.integrator.rr_depth = 3;
  const auto scene = compile_scene(d);
  constexpr int kPaths = 4000;
  struct Case {
    std::uint32_t depth;
    float beta;
    bool is_photon;
  };
  constexpr Case kCases[] = {{1, 0.8f, false},  {1, 40.0f, false}, {2, 0.8f, false}, {2, 2.0f, false},
                             {2, 40.0f, false}, {2, 0.8f, true},   {2, 2.0f, true}};
  for (const auto& [depth, beta, is_photon] : kCases) {
    ShadedWave<L> test(*scene, kPaths, [](int) { return static_cast<int>(kLightGray); });
    Wave& wave = test.wave;
    for (const auto& [slot, square] : test.square_of_slot) {
      auto path = wave.paths.get(slot);
      path.beta = {0.1f * beta, beta, 0.5f * beta, 0};
      path.eta_scale = 0.5f;
      path.depth_and_dimension = depth;
      wave.paths.set(slot, path);
    }
    scatter<L>(is_photon ? test.photon_context(*scene, kPaths) : test.context(*scene), wave);
    check_conservation(wave);
    // Depth counts the current vertex: at 2 the path has depth 3 and undergoes Russian roulette. Its survival
    // probability is relative to a throughput of one half; that of photons to 1.
    const double survival = depth < 2 ? 1 : std::min(0.75 * beta * 0.5 / (is_photon ? 1 : 0.5), 0.99);
    const double error = std::sqrt(kPaths * survival * (1 - survival));
    CHECK(std::fabs(wave.active.size() - kPaths * survival) <=
          student_t_threshold(significance_of_each(static_cast<int>(std::size(kCases))), kPaths) * error);
    for (const Slot slot : wave.active.span()) {
      const auto path = wave.paths.get(slot);
      CHECK(path.beta.c1 == near(0.75 * beta / survival, 1e-5));
      CHECK(path.beta.c0 == near(0.075 * beta / survival, 1e-5));
    }
  }
}

namespace {

/// The MIS weight of emission that is hit with pdf `scatter_pdf` where light sampling has pdf `light_pdf`.
double emission_weight(LightStrategy strategy, double scatter_pdf, double light_pdf) {
  if (scatter_pdf == 0 || strategy == LightStrategy::kBsdfOnly) return 1;
  if (strategy == LightStrategy::kLightOnly) return 0;
  return scatter_pdf * scatter_pdf / (scatter_pdf * scatter_pdf + light_pdf * light_pdf);
}

constexpr LightStrategy kStrategies[] = {LightStrategy::kMis, LightStrategy::kBsdfOnly, LightStrategy::kLightOnly};

}  // namespace

TEST_CASE_TEMPLATE("emission: the environment is weighted against light sampling", L, SHEAF_STAGE_LANES) {
  for (const LightStrategy strategy : kStrategies)
    for (const bool hide : {false, true}) {
      Description d = empty_scene(4, 4);
      add_constant_light(d, 2);
      d.integrator.strategy = strategy;
      d.integrator.hide_emitters = hide;
      const auto scene = compile_scene(d);
      for (const int paths : kTailSizes) {
        TestWave test(paths);
        Wave& wave = test.wave;
        for (int i = 0; i < paths; ++i) {
          const Slot slot = test.add({0, 0, 0}, {0, 0, 1}, i % 3 == 0 ? kRayFromCamera : 0u);
          auto r = wave.radiance.get(slot);
          r.radiance = Spectrum4(0.25f);
          r.scatter_pdf = i % 3 == 2 ? 0.3f : 0.0f;
          wave.radiance.set(slot, r);
          auto path = wave.paths.get(slot);
          path.beta = {1, 0.5f, static_cast<float>(i), 0};
          wave.paths.set(slot, path);
          wave.miss.push(slot);
        }
        emission<L>(test.context(*scene), wave);
        check_conservation(wave);
        CHECK(test.spare_rows_untouched());
        REQUIRE(wave.finished.size() == paths);
        for (const Slot slot : wave.finished.span()) {
          const auto r = wave.radiance.get(slot);
          const auto i = static_cast<int>(r.task_sample & ~kTransparent);
          const bool hidden = hide && i % 3 == 0;
          const double weight = hidden ? 0 : emission_weight(strategy, i % 3 == 2 ? 0.3 : 0, 0.25 * kInvPi);
          CHECK(r.radiance.c0 == near(0.25 + 2 * weight, 1e-5));
          CHECK(r.radiance.c1 == near(0.25 + weight, 1e-5));
          CHECK(r.radiance.c2 == near(0.25 + 2 * i * weight, 1e-5));
          CHECK(((r.task_sample & kTransparent) != 0) == hidden);
        }
      }
    }
}

TEST_CASE_TEMPLATE("emission: area lights emit from their front and are weighted against light sampling", L,
                   SHEAF_STAGE_LANES) {
  for (const LightStrategy strategy : kStrategies) {
    Description d = empty_scene(4, 4);
    d.integrator.strategy = strategy;
    d.integrator.light_selector = LightSelector::kPower;
    // Disks of radius 1
    const MaterialId black = add_diffuse(d, 0);
    emit(add_shape(d, DiskShape{}, Transform::translate({0, 0, 2}) * Transform::rotate({0, 1, 0}, 180), black), 3);
    emit(add_shape(d, DiskShape{}, Transform::translate({5, 0, 2}), black), 3);
    const auto scene = compile_scene(d);
    for (const int paths : kTailSizes) {
      TestWave test(paths);
      Wave& wave = test.wave;
      for (int i = 0; i < paths; ++i) {
        const Slot slot = test.add_active({i % 4 == 3 ? 5.0f : 0.0f, 0, 0},
                                          normalize(Vec3f{0.1f * static_cast<float>(i % 4), 0, 1}), kRayLast);
        auto r = wave.radiance.get(slot);
        r.scatter_pdf = i % 2 == 0 ? 0.2f : 0.0f;
        wave.radiance.set(slot, r);
      }
      intersect<L>(test.context(*scene), wave);
      emission<L>(test.context(*scene), wave);
      check_conservation(wave);
      CHECK(test.spare_rows_untouched());
      REQUIRE(wave.finished.size() == paths);
      for (const Slot slot : wave.finished.span()) {
        const auto r = wave.radiance.get(slot);
        const auto i = r.task_sample;
        const double z = wave.rays.get(slot).direction.z, t = 2 / z;
        const double light_pdf = 0.5 / 3.14159265358979 * t * t / z;
        const double weight = i % 4 == 3 ? 0 : emission_weight(strategy, i % 2 == 0 ? 0.2 : 0, light_pdf);
        CHECK(r.radiance.c1 == near(3 * weight, 1e-4));
      }
    }
  }
}

}  // namespace sheaf::test_stages_shading
