// Stage: light candidates. For every vertex that scatters diffusely enough, one light and a direction towards it; what
// the surface makes of it is left to the resample stage.
#include "kernels/bsdf/all.h"
#include "kernels/lights/light_sample.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/stages/blend_value.h"
#include "kernels/stages/light_receiver.h"
#include "kernels/stages/stages.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

namespace {

/// The upper turns in the light tree, which a vertex' first candidate leaves to the others.
template <class L>
SHEAF_INLINE LightTreeTop<L> shared_turns(const StageContext& context, Wave& wave, int column,
                                          const LightReceiver<L>& at, bool is_first) {
  if (!is_first) return wave.light_tops.load<L>(column);
  const auto top = light_tree_top<L>(context.scene.light_tree, at.p, at.n, Mask<L>(true));
  wave.light_tops.store<L>(column, top);
  return top;
}

/// `in_medium`: the vertices scatter to all sides and have no normal.
template <class L, ColorMode Mode>
SHEAF_INLINE void candidate_tile(const StageContext& context, Wave& wave, const Slot* slots, int column,
                                 const Random4<L>& u, bool is_first, bool in_medium, bool mapped_parts) {
  using F = Float<L>;
  const auto item = wave.vertices.load<L>(column);
  const Vec3<L> ns = mapped_parts ? receiver_normal<L>(context.scene, wave, slots, column, item.ns) : item.ns;
  const LightReceiver<L> at = in_medium ? LightReceiver<L>{item.p, {}} : surface_receiver<L>(item.p, ns);
  LightTreeTop<L> top;
  if (wave.needs.light_tops) top = shared_turns<L>(context, wave, column, at, is_first);
  const LightChoice<L> choice = choose_light<L>(context.scene, at, u.x, wave.needs.light_tops ? &top : nullptr);
  const LightSample<L> light =
      sample_light<L, Mode>(context.scene, item.p, choice, u, shading_wavelengths<L, Mode>(wave, slots));
  LightCandidate<L> out;
  out.direction = light.direction;
  out.target = light.target;
  out.radiance = light.radiance;
  out.pdf_solid_angle = select(light.valid & (choice.probability > F(0.0f)), light.pdf_solid_angle, F(0.0f));
  if (context.maps != nullptr) {
    const auto ends = context.maps->ends_at<L>(wave.rays.gather<L>(slots).flags, in_medium);
    out.pdf_solid_angle = select(ends, F(0.0f), out.pdf_solid_angle);
    // With a volume map all of a ray finds what media emit.
    if (context.maps->volume != nullptr && context.transport.strategy == LightStrategy::kMis)
      out.pdf_solid_angle = select(light.target_medium == Uint<L>(kNone), out.pdf_solid_angle, F(0.0f));
  }
  out.delta = select(light.delta, F(1.0f), F(0.0f));
  out.light = choice.light;
  out.target_medium = light.target_medium;
  wave.candidates.store<L>(column, out);
}

template <class L>
SHEAF_INLINE Random4<L> numbers_of(const StageContext& context, Wave& wave, const Slot* slots, SampleSet set) {
  const ThroughputState<L> path = wave.throughput.gather<L>(slots);
  return draw<L>(context.sampler, path.pixel, path.sample, path.event(), SampleBlock::kLight, set);
}

/// Not a template over the closure: one copy of the code serves all kinds. Where an environment map is most of the
/// light, two registers ahead of each tile its tables, and one ahead its nodes, are on their way from memory.
template <class L>
void candidate_run(const StageContext& context, Wave& wave, const VertexRun& run, SampleSet set, bool in_medium,
                   bool mapped_parts) {
  const SceneView& scene = context.scene;
  const bool fetches = scene.envmap.columns != nullptr && scene.bounded_light_count == 0;
  const Slot* const slots = wave.sorted.data() + run.slot_begin;
  const int ahead = fetches ? 2 : 0, tiles = (run.count + L::width - 1) / L::width;
  Random4<L> numbers[4];
  with_color_mode(scene, [&]<ColorMode Mode>() {
    for (int tile = -ahead; tile < tiles; ++tile) {
      if (tile + ahead < tiles) {
        Random4<L>& u = numbers[(tile + ahead) & 3];
        u = numbers_of<L>(context, wave, slots + (tile + ahead) * L::width, set);
        if (fetches) prefetch_envmap_columns<L>(scene.envmap, u.y, u.z);
      }
      if (fetches && tile + 1 >= 0 && tile + 1 < tiles)
        prefetch_envmap_nodes<L>(scene.envmap, numbers[(tile + 1) & 3].y, numbers[(tile + 1) & 3].z);
      if (tile >= 0)
        candidate_tile<L, Mode>(context, wave, slots + tile * L::width, run.column_begin + tile * L::width,
                                numbers[tile & 3], set.index == 0, in_medium, mapped_parts);
    }
  });
}

}  // namespace

template <class L> void light_candidates(const StageContext& context, Wave& wave, int candidate) noexcept {
  if (!samples_lights(context)) return;
  StageTimer timer(wave.stats, Stage::kLightCandidates);
  const SampleSet set{static_cast<std::uint32_t>(candidate),
                      static_cast<std::uint32_t>(context.transport.candidates)};
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if (Bsdf<L>::kIsSpecular && !has_parts(context.scene, kind)) return;
    const VertexRun& run = wave.runs[static_cast<int>(kind)];
    timer.count(run.count, L::width);
    candidate_run<L>(context, wave, run, set, kIsPhaseFunction<Bsdf<L>>, has_mapped_parts(context.scene, kind));
  });
}

SHEAF_INSTANTIATE_CANDIDATE_STAGE(light_candidates);

}  // namespace sheaf
