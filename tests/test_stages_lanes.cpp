// Every stage of the path pass in registers against the same stage one path at a time, from the same wave.
#include "kernels/stages.h"
#include "scene/glasses.h"
#include "tests/stages_testing.h"

namespace sheaf {

namespace {

using StageFunction = void (*)(const SceneView&, Wave&) noexcept;

struct StagePair {
  const char* name;
  StageFunction wide, scalar;
};
constexpr StagePair kStages[] = {{"camera_rays", camera_rays<Wide>, camera_rays<Scalar>},
                                 {"intersect", intersect<Wide>, intersect<Scalar>},
                                 {"emission", emission<Wide>, emission<Scalar>},
                                 {"sort_surfaces", sort_surfaces<Wide>, sort_surfaces<Scalar>},
                                 {"surface_inputs", surface_inputs<Wide>, surface_inputs<Scalar>},
                                 {"light_candidates", light_candidates<Wide>, light_candidates<Scalar>},
                                 {"resample", resample<Wide>, resample<Scalar>},
                                 {"shadow", shadow<Wide>, shadow<Scalar>},
                                 {"scatter", scatter<Wide>, scatter<Scalar>},
                                 {"accumulate", accumulate<Wide>, accumulate<Scalar>}};

template <class From, class To, class F> void zip_lists(From& a, To& b, F&& f) {
  f(a.free, b.free);
  f(a.active, b.active);
  f(a.miss, b.miss);
  f(a.emitter, b.emitter);
  f(a.surface, b.surface);
  f(a.finished, b.finished);
  f(a.sorted, b.sorted);
}

template <template <class> class Record> void copy_columns(const Soa<Record>& from, Soa<Record>& to) {
  for (int i = 0; i < from.capacity(); ++i) to.template store<Scalar>(i, from.template load<Scalar>(i));
}

/// Makes `to`, of the same capacity, a copy of `from`.
void copy_wave(const Wave& from, Wave& to) {
  for (int i = 0; i < from.capacity; ++i) {
    const auto slot = static_cast<Slot>(i);
    to.rays.set(slot, from.rays.get(slot));
    to.hits.set(slot, from.hits.get(slot));
    to.throughput.set(slot, from.throughput.get(slot));
    to.radiance.set(slot, from.radiance.get(slot));
    to.heroes[slot] = from.heroes[slot];
  }
  zip_lists(from, to, [](const SlotList& a, SlotList& b) {
    std::copy(a.span().begin(), a.span().end(), b.data());
    b.resize(a.size());
    b.pad();
  });
  std::copy(std::begin(from.runs), std::end(from.runs), to.runs);
  copy_columns(from.items, to.items);
  copy_columns(from.closures, to.closures);
  copy_columns(from.candidates, to.candidates);
  copy_columns(from.reservoirs, to.reservoirs);
  copy_columns(from.shadows, to.shadows);
  to.shadow_count = from.shadow_count;
  to.next_sample = from.next_sample;
}

/// Largest difference between what two waves hold.
double wave_difference(const Wave& a, const Wave& b) {
  bool same_lists = a.shadow_count == b.shadow_count && a.next_sample == b.next_sample;
  zip_lists(a, b, [&](const SlotList& x, const SlotList& y) {
    same_lists = same_lists && std::equal(x.span().begin(), x.span().end(), y.span().begin(), y.span().end());
  });
  if (!same_lists) return kInfinity;
  double worst = 0;
  for (const SlotList* list : {&a.active, &a.miss, &a.surface, &a.finished})
    for (const Slot slot : list->span())
      worst = std::max({worst, record_difference<RayState>(a.rays.get(slot), b.rays.get(slot)),
                        record_difference<ThroughputState>(a.throughput.get(slot), b.throughput.get(slot)),
                        record_difference<RadianceState>(a.radiance.get(slot), b.radiance.get(slot)),
                        double{float_bits(a.heroes[slot]) == float_bits(b.heroes[slot]) ? 0.0f : 1.0f}});
  for (const SlotList* list : {&a.surface, &a.emitter})
    for (const Slot slot : list->span())
      worst = std::max(worst, record_difference<HitState>(a.hits.get(slot), b.hits.get(slot)));
  for (int kind = 0; kind < kClosureKinds; ++kind) {
    if (a.runs[kind].count != b.runs[kind].count || a.runs[kind].column_begin != b.runs[kind].column_begin)
      return kInfinity;
    for (int i = 0; i < a.runs[kind].count; ++i) {
      const int column = a.runs[kind].column_begin + i;
      worst =
          std::max({worst, record_difference<SurfaceItem>(a.items.load<Scalar>(column), b.items.load<Scalar>(column)),
                    record_difference<ClosureItem>(a.closures.load<Scalar>(column), b.closures.load<Scalar>(column))});
    }
  }
  for (int i = 0; i < a.shadow_count; ++i)
    worst = std::max(worst, record_difference<ShadowItem>(a.shadows.load<Scalar>(i), b.shadows.load<Scalar>(i)));
  return worst;
}

}  // namespace

TEST_CASE("stages: registers do what single paths do, stage by stage, in both colour modes") {
  Description d = mixed_scene();
  d.integrator.rr_depth = 2;
  DielectricDescription glass;
  glass.int_dispersion = *find_dispersion("diamond");
  add_sphere(d, {0.3f, 0.7f, 3}, 0.3f, add_material(d, glass));
  for (const auto& [hide_emitters, color] :
       {std::pair{false, ColorMode::kRgb}, std::pair{true, ColorMode::kRgb}, std::pair{true, ColorMode::kSpectral}}) {
    d.integrator.hide_emitters = hide_emitters;
    const auto scene = compile_scene(d, {false, color});
    for (const int paths : {kWidth - 1, kWidth + 1, 250}) {
      Wave wide(paths), scalar(paths);
      std::vector<FilmSample> from_wide(512), from_scalar(512);
      wide.begin({{0, 0, 16, 16}, 0, 2, 16}, from_wide.data());
      scalar.begin({{0, 0, 16, 16}, 0, 2, 16}, from_scalar.data());
      for (int bounce = 0; bounce < 12; ++bounce)
        for (const StagePair& stage : kStages) {
          CAPTURE(stage.name);
          CAPTURE(bounce);
          copy_wave(wide, scalar);
          stage.wide(scene->view(), wide);
          stage.scalar(scene->view(), scalar);
          CHECK(wave_difference(wide, scalar) < 2e-4);
        }
      double worst = 0;
      for (std::size_t i = 0; i < from_wide.size(); ++i) {
        worst = std::max({worst, difference(from_wide[i].r, from_scalar[i].r),
                          difference(from_wide[i].g, from_scalar[i].g), difference(from_wide[i].b, from_scalar[i].b),
                          difference(from_wide[i].alpha, from_scalar[i].alpha)});
      }
      // Wavelengths come from logarithms, which registers round in their own way.
      CHECK(worst < (color == ColorMode::kSpectral ? 1e-5 : 1e-6));
      CHECK(wide.stats.rays.camera ==
            static_cast<std::uint64_t>(std::min(512, static_cast<int>(wide.stats.samples) + paths - wide.free.size())));
      CHECK(wide.stats.dropped.samples == 0);
    }
  }
}

}  // namespace sheaf
