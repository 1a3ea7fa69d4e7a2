// Stage: guide. Looks up the guide cell of every vertex. The side of a surface is given by the geometric normal, which
// all parts of a blend share. Without a guide, marks vertices in media that glow around lights
// (kernels/guiding/glow_lobes.h).
#include "kernels/stages/guided.h"
#include "kernels/stages/segment_mis.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

namespace {

/// Stores the extinction of the media that vertices lie in, if they sample the glow of lights; see glow_extinction().
template <class L> SHEAF_INLINE void mark_glow(const StageContext& context, Wave& wave, const Slot* slots, int column) {
  using F = Float<L>;
  using U = Uint<L>;
  const U medium = wave.rays.gather<L>(slots).flags >> kRayMediumShift;
  const auto inside = medium != U(0u);
  const U row = select(inside, medium - U(1u), U(0u));
  const MediumRow* const rows = context.scene.media.rows;
  const auto is_marked = inside & ((gather_member<L>(rows, &MediumRow::flags, row) & U(kMediumConnects)) != U(0u)) &
                         (wave.paths.gather<L>(slots).depth() < U(kConnectedDepth));
  const F extinction = select(is_marked, gather_member<L>(rows, &MediumRow::mean_extinction, row), F(-1.0f));
  wave.guide_cells.store<L>(column, {float_bits(extinction), U(kGuideMedia)});
}

/// Not a template over the closure, so that all kinds share one copy of the code.
template <class L> void guide_run(const StageContext& context, Wave& wave, const VertexRun& run, bool in_medium) {
  using U = Uint<L>;
  for_tiles<L>(run.count, [&](int i, int) {
    const int column = run.column_begin + i;
    const Slot* const slots = wave.sorted.data() + run.slot_begin + i;
    if (!context.samples_guide()) return mark_glow<L>(context, wave, slots, column);
    const auto item = wave.vertices.load<L>(column);
    U side(kGuideMedia);
    if (!in_medium) {
      const RayState<L> ray = wave.rays.gather<L>(slots);
      side = guide_side<L>(select<L>(dot(item.ng, ray.direction) > Float<L>(0.0f), -item.ng, item.ng));
    }
    wave.guide_cells.store<L>(column,
                              {guide_row<L>(context.guide(), side, guide_code<L>(context.guide(), item.p)), side});
  });
}

}  // namespace

template <class L> void guide(const StageContext& context, Wave& wave) noexcept {
  StageTimer timer(wave.stats, stage_named<L>("guide"));
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if (!kIsGuided<Bsdf<L>> && !has_parts(context.scene, kind)) return;
    const VertexRun& run = wave.runs[static_cast<int>(kind)];
    timer.count(run.count, L::width);
    guide_run<L>(context, wave, run, kIsPhaseFunction<Bsdf<L>>);
  });
}

SHEAF_INSTANTIATE_STAGE(guide);

}  // namespace sheaf
