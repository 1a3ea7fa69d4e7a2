// Runs every stage of the light transport passes in SIMD lanes and one path at a time, from the same wave, and compares
// the results.
#include "kernels/guiding/fit_mixture.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/wave_snapshot.h"
#include "scene/data/glasses.h"
#include "tests/support/capture.h"
#include "tests/support/near.h"
#include "tests/support/stages_testing.h"

namespace sheaf::test_stages_lanes {

namespace {

/// Maximum difference between the contents of two waves.
double wave_difference(const Wave& a, const Wave& b) {
  bool same_lists = a.shadow_count == b.shadow_count;
  for (const SlotList PathPool::*list : PathPool::kLists) {
    const auto x = (a.*list).span(), y = (b.*list).span();
    same_lists = same_lists && std::equal(x.begin(), x.end(), y.begin(), y.end());
  }
  if (!same_lists) return kInfinity;
  double worst = 0;
  for (const SlotList* list : {&a.active, &a.miss, &a.surface, &a.finished})
    for (const Slot slot : list->span())
      worst = std::max(
          {worst, record_difference<RayState>(a.rays.get(slot), b.rays.get(slot)),
           record_difference<PathState>(a.paths.get(slot), b.paths.get(slot)),
           record_difference<RadianceState>(a.radiance.get(slot), b.radiance.get(slot)),
           double{float_bits(a.wavelength_samples[slot]) == float_bits(b.wavelength_samples[slot]) ? 0.0f : 1.0f}});
  for (const SlotList* list : {&a.surface, &a.emitter})
    for (const Slot slot : list->span())
      worst = std::max(worst, record_difference<HitState>(a.hits.get(slot), b.hits.get(slot)));
  for (int kind = 0; kind < kClosureKinds; ++kind) {
    if (a.runs[kind].count != b.runs[kind].count || a.runs[kind].column_begin != b.runs[kind].column_begin)
      return kInfinity;
    for (int i = 0; i < a.runs[kind].count; ++i) {
      const int column = a.runs[kind].column_begin + i;
      worst = std::max(
          {worst, record_difference<VertexItem>(a.vertices.load<Scalar>(column), b.vertices.load<Scalar>(column)),
           record_difference<ClosureItem>(a.closures.load<Scalar>(column), b.closures.load<Scalar>(column))});
    }
  }
  for (const Slot slot : a.active.span())
    worst = std::max(worst, record_difference<RescaledPdfs>(a.rescaled_pdfs.get(slot), b.rescaled_pdfs.get(slot)));
  for (int i = 0; i < a.shadow_count; ++i)
    worst = std::max(worst, record_difference<ShadowItem>(a.shadows.load<Scalar>(i), b.shadows.load<Scalar>(i)));
  return worst;
}

}  // namespace

TEST_CASE("stages: SIMD path stages equal scalar ones in both color modes") {
  Description d = mixed_scene();
  d.integrator.rr_depth = 2;
  DielectricDescription glass;
  glass.int_dispersion = *find_dispersion("diamond");
  add_sphere(d, {0.3f, 0.7f, 3}, 0.3f, add_material(d, glass));
  const GuideMixture mixture = first_mixture({0, 0, 0});
  const float unknown = -1;
  struct Case {
    bool hide_emitters, guided;
    ColorMode color;
  };
  for (const auto& [hide_emitters, guided, color] :
       {Case{false, false, ColorMode::kRgb}, Case{true, false, ColorMode::kRgb}, Case{false, true, ColorMode::kRgb},
        Case{true, false, ColorMode::kSpectral}, Case{true, true, ColorMode::kSpectral}}) {
    CAPTURE_BINDING(guided);
    d.integrator.hide_emitters = hide_emitters;
    const auto scene = compile_scene(d, {false, color});
    for (const int paths : {kWidth - 1, kWidth + 1, 250}) {
      TestWave wide(paths, 0), scalar(paths, 0);
      const AovSet aovs = guided ? AovSet() : aovs_from_names("all");
      wide.begin({0, 0, 16, 16}, 0, 2, 16, aovs);
      scalar.begin({0, 0, 16, 16}, 0, 2, 16, aovs);
      StageContext wide_context = wide.context(*scene), scalar_context = scalar.context(*scene);
      if (guided)
        for (StageContext* context : {&wide_context, &scalar_context})
          context->sample_from({.mixtures = &mixture, .means = &unknown});
      for (int bounce = 0; bounce < 12; ++bounce)
        for (std::size_t i = 0; i < kStages<Wide>.size(); ++i) {
          if (!kStages<Wide>[i].takes_part(wide_context)) continue;
          CAPTURE(kStages<Wide>[i].name);
          CAPTURE(bounce);
          WaveSnapshot(wide.wave).restore(scalar.wave);
          scalar.task.cursor = wide.task.cursor;
          kStages<Wide>[i].run(wide_context, wide.wave);
          kStages<Single>[i].run(scalar_context, scalar.wave);
          CHECK(wave_difference(wide.wave, scalar.wave) < 2e-4);
        }
      double worst = 0;
      double worst_layer = 0;
      for (std::size_t sample = 0; sample < 512; ++sample) {
        const float *a = wide.task.samples[sample], *b = scalar.task.samples[sample];
        for (int c = 0; c < wide.task.samples.channels(); ++c) {
          double& of = c < kBeautyChannels ? worst : worst_layer;
          of = std::max(of, difference(a[c], b[c]));
        }
        if (!guided) CHECK(wide.task.samples.surface(sample).shape == scalar.task.samples.surface(sample).shape);
      }
      CHECK(worst_layer < 2e-4);
      // Wavelengths depend on logarithms, which SIMD code rounds differently.
      CHECK(worst < (color == ColorMode::kSpectral ? 1e-5 : 1e-6));
      const auto done = static_cast<int>(wide.wave.stats.samples);
      CHECK(wide.wave.stats.rays.camera ==
            static_cast<std::uint64_t>(std::min(512, done + paths - wide.wave.free.size())));
      CHECK(wide.wave.stats.dropped.samples == 0);
    }
  }
}

TEST_CASE("stages: SIMD photon stages equal scalar ones in both color modes") {
  Description d = mixed_scene();
  d.integrator.rr_depth = 2;
  d.integrator.kind = IntegratorKind::kLightTracer;
  d.camera.aperture_radius = 0.1f;
  d.camera.focus_distance = 3;
  add_media_and_masks(d);
  for (const ColorMode color : {ColorMode::kRgb, ColorMode::kSpectral}) {
    const auto scene = compile_scene(d, {false, color});
    for (const int paths : {kWidth - 1, kWidth + 1, 250}) {
      TestWave wide(paths, 0), scalar(paths, 0);
      const StageContext wide_context = wide.photon_context(*scene, 700);
      const StageContext scalar_context = scalar.photon_context(*scene, 700);
      for (int bounce = 0; bounce < 12; ++bounce)
        for (std::size_t i = 0; i < kStages<Wide>.size(); ++i) {
          if (!kStages<Wide>[i].takes_part(wide_context)) continue;
          CAPTURE(kStages<Wide>[i].name);
          CAPTURE(bounce);
          WaveSnapshot(wide.wave).restore(scalar.wave);
          kStages<Wide>[i].run(wide_context, wide.wave);
          kStages<Single>[i].run(scalar_context, scalar.wave);
          CHECK(wave_difference(wide.wave, scalar.wave) < 2e-4);
          CHECK(wide.photons.left() == scalar.photons.left());
        }
      wide.photons.sort_splats();
      scalar.photons.sort_splats();
      REQUIRE(wide.photons.splats.size() == scalar.photons.splats.size());
      CHECK(wide.photons.splats.size() > static_cast<std::size_t>(std::min(10, paths + 3)));
      for (std::size_t i = 0; i < wide.photons.splats.size(); ++i) {
        const Splat &a = wide.photons.splats[i], &b = scalar.photons.splats[i];
        CHECK(a.order == b.order);
        CHECK(a.x == near(b.x, 1e-4));
        CHECK(a.y == near(b.y, 1e-4));
        for (int c = 0; c < 3; ++c) CHECK(a.rgb[c] == near(b.rgb[c], 1e-3));
      }
    }
  }
}

}  // namespace sheaf::test_stages_lanes
