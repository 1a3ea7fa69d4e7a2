// Stage: light candidates. Samples one light and a point on it for every non-specular vertex: candidate x_i of
// resampled importance sampling with pdf p = p(light) p(point | light) (PBR 12.6, 13.2). The resample stage evaluates
// the BSDF.
#include "kernels/bsdf/list.h"
#include "kernels/lights/light_sample.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/stages/blend_value.h"
#include "kernels/stages/light_sample_context.h"
#include "kernels/stages/segment_mis.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"

#include <bit>

namespace sheaf {

namespace {

/// Registers of vertices whose lights are selected in one call, to hide the latency of the light tree.
constexpr int kTilesPerGroup = 2;

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
SHEAF_INLINE void choose_for(const StageContext& context, Wave& wave, const CandidateTile<L> (&tiles)[kTilesPerGroup],
                             const LightSampleContext<L> (&at)[kTilesPerGroup], bool is_first,
                             LightChoice<L> (&choices)[kTilesPerGroup]) {
  LightTreeCut<L> cuts[kTilesPerGroup];
  Float<L> u[kTilesPerGroup];
  const bool uses_cuts = wave.needs.light_cuts && shares_light_cut(context);
  for (int i = 0; i < kTilesPerGroup; ++i) {
    u[i] = tiles[i].u.x;
    if (!uses_cuts) continue;
    const int column = tiles[i].column;
    if (!is_first) {
      cuts[i] = wave.light_cuts.load<L>(column);
    } else {
      cuts[i] = light_tree_cut<L>(context.scene.lights.tree, at[i].p, at[i].n, Mask<L>(true));
      wave.light_cuts.store<L>(column, cuts[i]);
    }
  }
  choose_lights<L>(context.scene, at, u, uses_cuts ? cuts : nullptr, choices);
}

/// Samples a point on the chosen light of each vertex and stores the candidate. `in_medium`: the vertices lie in media.
/// `drawn`: see LightQuery.
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
  // Drop candidates whose light photon maps or the path itself contribute
  if (context.gathers_photons()) {
    const auto ends = context.photon_maps().ends_at<L>(wave.rays.gather<L>(tile.slots).flags, in_medium);
    out.pdf_solid_angle = select(ends, F(0.0f), out.pdf_solid_angle);
    // With a volume map, paths find the emission of media along their whole rays.
    if (context.photon_maps().covers_media() && context.integrator.strategy == LightStrategy::kMis)
      out.pdf_solid_angle = select(light.target_medium == Uint<L>(kNone), out.pdf_solid_angle, F(0.0f));
  }
  // Share the light with the segment that the vertex lies on
  if (in_medium && connects_segments(context)) {
    const F scale = segment_pdf_scale<L>(context.scene, wave, tile.slots, at.p, choice.light, choice.probability,
                                         (out.pdf_solid_angle > F(0.0f)) & (light.target_medium == Uint<L>(kNone)));
    out.pdf_solid_angle = out.pdf_solid_angle * scale;
    out.radiance = out.radiance * (F(1.0f) / scale);
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

/// The steps from vertices to candidates. While one group of tiles is at the last step, the next groups are at earlier
/// steps, so that no step waits for memory that the previous one has prefetched. Values: number of groups ahead.
enum CandidateStep : int { kSampleLights, kSampleColumns, kSampleRows, kDrawNumbers };

/// Runs the steps over the groups of a run. `kDrawsMap`: the scene has an environment map and no bounded lights; the
/// rows and columns of the map are sampled in steps of their own.
template <class L, bool kDrawsMap> class CandidatePipeline {
 public:
  CandidatePipeline(const StageContext& context, Wave& wave, const VertexRun& run, SampleSet set, bool in_medium,
                    bool mapped_parts)
      : context_(context),
        wave_(wave),
        run_(run),
        set_(set),
        in_medium_(in_medium),
        mapped_parts_(mapped_parts),
        tile_count_((run.count + L::width - 1) / L::width) {}

  template <ColorMode kMode> void execute() {
    const int groups = (tile_count_ + kTilesPerGroup - 1) / kTilesPerGroup;
    const auto has = [groups](int group) SHEAF_LAMBDA_INLINE { return group >= 0 && group < groups; };
    for (int group = -kFirstStep; group < groups; ++group) {
      if (has(group + kFirstStep)) draw_numbers(group + kFirstStep);
      if constexpr (kDrawsMap) {
        if (has(group + kSampleRows)) sample_rows(group + kSampleRows);
        if (has(group + kSampleColumns)) sample_columns(group + kSampleColumns);
      }
      if (group >= 0) sample_lights<kMode>(group);
    }
  }

 private:
  static constexpr int kFirstStep = kDrawsMap ? kDrawNumbers : 1;
  static constexpr int kRing = std::bit_ceil(kFirstStep + 1u);

  SHEAF_INLINE void draw_numbers(int group) {
    const Slot* const slots = wave_.sorted.data() + run_.slot_begin;
    for (int i = 0; i < kTilesPerGroup; ++i) {
      // With an odd number of tiles, the last group holds the last tile twice.
      const int begin = std::min(group * kTilesPerGroup + i, tile_count_ - 1) * L::width;
      tiles_[group % kRing][i] = {slots + begin, run_.column_begin + begin,
                                  numbers_of<L>(context_, wave_, slots + begin, set_)};
    }
  }

  SHEAF_INLINE void sample_rows(int group) {
    for (int i = 0; i < kTilesPerGroup; ++i) {
      const Random4<L>& u = tiles_[group % kRing][i].u;
      drawn_[group % kRing][i] = draw_envmap_row<L>(context_.scene.lights.envmap, u.z);
      prefetch_envmap_column<L>(context_.scene.lights.envmap, u.y, drawn_[group % kRing][i]);
    }
  }

  SHEAF_INLINE void sample_columns(int group) {
    for (int i = 0; i < kTilesPerGroup; ++i) {
      draw_envmap_column<L>(context_.scene.lights.envmap, tiles_[group % kRing][i].u.y, drawn_[group % kRing][i]);
      prefetch_envmap_nodes<L>(context_.scene.lights.envmap, drawn_[group % kRing][i]);
    }
  }

  template <ColorMode kMode> SHEAF_INLINE void sample_lights(int group) {
    const CandidateTile<L>(&tiles)[kTilesPerGroup] = tiles_[group % kRing];
    LightSampleContext<L> at[kTilesPerGroup];
    for (int i = 0; i < kTilesPerGroup; ++i)
      at[i] = receivers<L>(context_.scene, wave_, tiles[i], in_medium_, mapped_parts_);
    LightChoice<L> choices[kTilesPerGroup];
    choose_for<L>(context_, wave_, tiles, at, set_.index == 0, choices);
    for (int i = 0; i < kTilesPerGroup && group * kTilesPerGroup + i < tile_count_; ++i)
      candidate_tile<L, kMode>(context_, wave_, tiles[i], at[i], choices[i], in_medium_,
                               kDrawsMap ? &drawn_[group % kRing][i] : nullptr);
  }

  const StageContext& context_;
  Wave& wave_;
  const VertexRun& run_;
  const SampleSet set_;
  const bool in_medium_, mapped_parts_;
  const int tile_count_;
  CandidateTile<L> tiles_[kRing][kTilesPerGroup];
  EnvmapDraw<L> drawn_[kDrawsMap ? kRing : 1][kTilesPerGroup];
};

/// Not a template over the closure, so that all kinds share one copy of the code.
template <class L, bool kDrawsMap>
void candidate_run(const StageContext& context, Wave& wave, const VertexRun& run, SampleSet set, bool in_medium,
                   bool mapped_parts) {
  CandidatePipeline<L, kDrawsMap> pipeline(context, wave, run, set, in_medium, mapped_parts);
  with_color_mode(context.scene, [&]<ColorMode kMode>() { pipeline.template execute<kMode>(); });
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
