// Stage: light candidates. Samples one light and a point on it for every non-specular vertex. The resample stage
// evaluates the BSDF.
#include "kernels/bsdf/list.h"
#include "kernels/lights/light_sample.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/stages/blend_value.h"
#include "kernels/stages/light_sample_context.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"

#include <bit>

namespace sheaf {

namespace {

/// Number of registers of vertices that select their lights together.
constexpr int kTogether = 2;

/// Inputs of a register of vertices for one candidate each.
template <class L> struct CandidateTile {
  const Slot* slots;
  int column;
  Random4<L> u;
};

/// The vertices of a tile as light sampling sees them.
template <class L>
SHEAF_INLINE LightSampleContext<L> receivers(const SceneView& scene, const Wave& wave, const CandidateTile<L>& tile,
                                             bool in_medium, bool mapped_parts) {
  const auto item = wave.vertices.load<L>(tile.column);
  if (in_medium) return {item.p, {}};
  return surface_receiver<L>(
      item.p, mapped_parts ? receiver_normal<L>(scene, wave, tile.slots, tile.column, item.ns) : item.ns);
}

/// Selects the lights of adjacent tiles. The first candidate of a vertex stores its cut of the light tree for the
/// others.
template <class L>
SHEAF_INLINE void choose_for(const StageContext& context, Wave& wave, const CandidateTile<L> (&tiles)[kTogether],
                             const LightSampleContext<L> (&at)[kTogether], bool is_first,
                             LightChoice<L> (&choices)[kTogether]) {
  LightTreeCut<L> tops[kTogether];
  Float<L> u[kTogether];
  const bool shares_tops = wave.needs.light_tops && shares_light_tops(context);
  for (int i = 0; i < kTogether; ++i) {
    u[i] = tiles[i].u.x;
    if (!shares_tops) continue;
    const int column = tiles[i].column;
    if (!is_first) {
      tops[i] = wave.light_tops.load<L>(column);
    } else {
      tops[i] = light_tree_top<L>(context.scene.lights.tree, at[i].p, at[i].n, Mask<L>(true));
      wave.light_tops.store<L>(column, tops[i]);
    }
  }
  choose_lights<L>(context.scene, at, u, shares_tops ? tops : nullptr, choices);
}

/// `in_medium`: the vertices lie in media. `drawn`: see LightQuery.
template <class L, ColorMode kMode>
SHEAF_INLINE void candidate_tile(const StageContext& context, Wave& wave, const CandidateTile<L>& tile,
                                 const LightSampleContext<L>& at, const LightChoice<L>& choice, bool in_medium,
                                 const EnvmapDraw<L>* drawn) {
  using F = Float<L>;
  const LightSample<L> light =
      sample_light<L, kMode>(context.scene, at, choice, tile.u, path_times<L>(context.scene, wave, tile.slots),
                             shading_wavelengths<L, kMode>(wave, tile.slots), drawn);
  LightCandidate<L> out;
  out.direction = light.direction;
  out.target = light.target;
  out.radiance = light.radiance;
  out.pdf_solid_angle = select(light.valid & (choice.probability > F(0.0f)), light.pdf_solid_angle, F(0.0f));
  if (context.gathers_photons()) {
    const auto ends = context.photon_maps().ends_at<L>(wave.rays.gather<L>(tile.slots).flags, in_medium);
    out.pdf_solid_angle = select(ends, F(0.0f), out.pdf_solid_angle);
    // With a volume map, paths find the emission of media along their whole rays.
    if (context.photon_maps().covers_media() && context.integrator.strategy == LightStrategy::kMis)
      out.pdf_solid_angle = select(light.target_medium == Uint<L>(kNone), out.pdf_solid_angle, F(0.0f));
  }
  out.delta = select(light.delta, F(1.0f), F(0.0f));
  out.light = choice.light;
  out.target_medium = light.target_medium;
  wave.candidates.store<L>(tile.column, out);
}

template <class L>
SHEAF_INLINE Random4<L> numbers_of(const StageContext& context, Wave& wave, const Slot* slots, SampleSet set) {
  const PathState<L> path = wave.paths.gather<L>(slots);
  return draw<L>(context.sampler, path.pixel, path.sample, path.dimension(), SampleBlock::kLight, set,
                 context.scene.lights.count > 1 ? kAllNumbers : kAllNumbers & ~kNumberX);
}

/// Pipeline steps from tiles to candidates, in groups of kTogether tiles. While one group is at the last step, the
/// following ones are at earlier steps, so that no step waits for memory that the previous one has prefetched.
enum CandidateStep { kCandidates, kColumns, kRows, kNumbers };

/// Not a template over the closure, so that all kinds share one copy of the code. `kDrawsMap`: the scene has an
/// environment map and no bounded lights; the rows and columns of the map are sampled in separate steps.
template <class L, bool kDrawsMap>
void candidate_run(const StageContext& context, Wave& wave, const VertexRun& run, SampleSet set, bool in_medium,
                   bool mapped_parts) {
  const SceneView& scene = context.scene;
  constexpr int kAhead = kDrawsMap ? kNumbers : 1, kRing = std::bit_ceil(kAhead + 1u);
  const Slot* const slots = wave.sorted.data() + run.slot_begin;
  const int tiles = (run.count + L::width - 1) / L::width, groups = (tiles + kTogether - 1) / kTogether;
  CandidateTile<L> ring[kRing][kTogether];
  EnvmapDraw<L> drawn[kDrawsMap ? kRing : 1][kTogether];
  LightChoice<L> choices[kTogether];
  const auto has = [groups](int group) { return group >= 0 && group < groups; };
  with_color_mode(scene, [&]<ColorMode kMode>() {
    for (int group = -kAhead; group < groups; ++group) {
      const int numbers = group + kAhead, rows = group + kRows, columns = group + kColumns;
      // Draw random numbers
      for (int i = 0; i < kTogether && has(numbers); ++i) {
        // With an odd number of tiles, the last group holds the last tile twice.
        const int begin = std::min(numbers * kTogether + i, tiles - 1) * L::width;
        ring[numbers % kRing][i] = {slots + begin, run.column_begin + begin,
                                    numbers_of<L>(context, wave, slots + begin, set)};
      }
      // Sample rows of the environment map
      for (int i = 0; i < kTogether && kDrawsMap && has(rows); ++i) {
        const Random4<L>& u = ring[rows % kRing][i].u;
        drawn[rows % kRing][i] = draw_envmap_row<L>(scene.lights.envmap, u.z);
        prefetch_envmap_column<L>(scene.lights.envmap, u.y, drawn[rows % kRing][i]);
      }
      // Sample columns of the environment map
      for (int i = 0; i < kTogether && kDrawsMap && has(columns); ++i) {
        draw_envmap_column<L>(scene.lights.envmap, ring[columns % kRing][i].u.y, drawn[columns % kRing][i]);
        prefetch_envmap_nodes<L>(scene.lights.envmap, drawn[columns % kRing][i]);
      }
      if (group < 0) continue;
      // Choose lights and sample them
      const CandidateTile<L>(&now)[kTogether] = ring[group % kRing];
      LightSampleContext<L> at[kTogether];
      for (int i = 0; i < kTogether; ++i) at[i] = receivers<L>(scene, wave, now[i], in_medium, mapped_parts);
      choose_for<L>(context, wave, now, at, set.index == 0, choices);
      for (int i = 0; i < kTogether && group * kTogether + i < tiles; ++i)
        candidate_tile<L, kMode>(context, wave, now[i], at[i], choices[i], in_medium,
                                 kDrawsMap ? &drawn[group % kRing][i] : nullptr);
    }
  });
}

}  // namespace

template <class L> void light_candidates(const StageContext& context, Wave& wave, int candidate) noexcept {
  if (!samples_lights(context)) return;
  StageTimer timer(wave.stats, stage_named<L>("light_candidates"));
  const SampleSet set{static_cast<std::uint32_t>(candidate), static_cast<std::uint32_t>(context.candidates)};
  const bool draws_map = context.scene.lights.envmap.columns != nullptr && context.scene.lights.bounded_count == 0;
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if (Bsdf<L>::kIsSpecular && !has_parts(context.scene, kind)) return;
    const VertexRun& run = wave.runs[static_cast<int>(kind)];
    timer.count(run.count, L::width);
    const auto work = draws_map ? candidate_run<L, true> : candidate_run<L, false>;
    work(context, wave, run, set, kIsPhaseFunction<Bsdf<L>>, has_mapped_parts(context.scene, kind));
  });
}

SHEAF_INSTANTIATE_CANDIDATE_STAGE(light_candidates);

}  // namespace sheaf
