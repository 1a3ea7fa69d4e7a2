// Stage: light candidates. One light per vertex, sampled by power, weighted by multiple importance sampling against
// BSDF sampling; what would arrive becomes a shadow ray.
#include "kernels/bsdf/all.h"
#include "kernels/light_sample.h"
#include "kernels/normal_map.h"
#include "kernels/shading_frame.h"
#include "kernels/stage_timer.h"
#include "kernels/stages.h"

namespace sheaf {

namespace {

template <class L, template <class> class Bsdf>
SHEAF_INLINE void light_tile(const SceneView& scene, Wave& wave, const Slot* slots, int column, int count, bool mapped) {
  using F = Float<L>;
  const auto item = wave.items.load<L>(column);
  const Bsdf<L> bsdf = load_bsdf<L, Bsdf>(wave, column);
  const ThroughputState<L> path = wave.throughput.gather<L>(slots);
  const auto u = draw<L>(scene.sampler, path.pixel, path.sample, path.event(), SampleBlock::kLight);
  const LightSample<L> light = sample_light<L>(scene, item.p, u);

  const Vec3<L> wi = ShadingFrame<L, Bsdf<L>::kIsAnisotropic>(item).to_local(light.direction);
  BsdfValue<L> value = bsdf.evaluate(item.wo, wi);
  if (mapped) {
    const TexturedItem<L> t = wave.textured.load<L>(column);
    value.f_cos = value.f_cos * shadow_terminator<L>(t.ns_unmapped, t.terminator, light.direction, wi.z);
  }
  const auto usable = light.valid & (light.pdf_solid_angle > F(0.0f));
  const F pdf_light = select(usable, light.pdf_solid_angle, F(1.0f));
  const auto no_contest = light.delta | Mask<L>(scene.integrator.strategy == LightStrategy::kLightOnly);
  const F weight = select(no_contest, F(1.0f), power_heuristic(pdf_light, value.pdf_solid_angle)) / pdf_light;

  ShadowItem<L> out;
  out.origin = offset_origin<L>(item.p, item.ng, item.offset, light.direction);
  out.direction = light.target - out.origin;
  out.contribution = path.beta * value.f_cos * light.radiance * weight;
  alignas(kSimdAlignment) std::uint32_t slot_words[L::width];
  for (int lane = 0; lane < L::width; ++lane) slot_words[lane] = slots[lane];
  load(slot_words, out.slot);
  const auto traceable = is_finite(out.direction) & is_finite(out.contribution.c0 + out.contribution.c1 + out.contribution.c2);
  const auto kept = usable & traceable & !is_black(out.contribution) & L::first(count);
  wave.shadow_count += wave.shadows.compress<L>(wave.shadow_count, out, kept);
}

template <class L, template <class> class Bsdf> void light_run(const SceneView& scene, Wave& wave, const SurfaceRun& run) {
  const bool mapped = (scene.kind_flags[static_cast<int>(Bsdf<L>::kKind)] & kMapped) != 0;
  for_tiles<L>(run.count, [&](int i, int count) {
    light_tile<L, Bsdf>(scene, wave, wave.sorted.data() + run.slot_begin + i, run.column_begin + i, count, mapped);
  });
}

}  // namespace

template <class L> void light_candidates(const SceneView& scene, Wave& wave) noexcept {
  if (scene.light_count == 0 || scene.integrator.strategy == LightStrategy::kBsdfOnly) return;
  StageTimer timer(wave.stats, Stage::kLightCandidates);
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if constexpr (!Bsdf<L>::kIsSpecular) {
      const SurfaceRun& run = wave.runs[static_cast<int>(kind)];
      timer.count(run.count, L::width);
      light_run<L, Bsdf>(scene, wave, run);
    }
  });
}

SHEAF_INSTANTIATE_STAGE(light_candidates);

}  // namespace sheaf
