// Stage: resample. Of M light candidates per vertex, one is kept and becomes a shadow ray: resampled importance sampling
// (Talbot, Cline and Egbert 2005, "Importance Resampling for Global Illumination", equation 6), as a weighted reservoir.
//
// With candidates x_i of density p and the target q(x), the kept candidate y and its weight estimate
//     f(y) / q(y) * 1/M sum_i q(x_i) / p(x_i).
// Multiple importance sampling splits the integrand f into parts w_l f, for light sampling, and w_b f, for BSDF
// sampling with density b. Any functions of x alone that add up to one at every x keep the sum unbiased, whatever
// technique then estimates each part: so the density of the kept candidate, which has no closed form, is not needed. The
// weights here are the power heuristic of M p and b, as M candidates are worth up to M samples:
//     w_l = (M p)^2 / ((M p)^2 + b^2),  w_b = 1 - w_l,
// and q is the unshadowed part w_l f, its lanes added up. Lights that BSDF sampling cannot find have w_l = 1. For M = 1 the
// factor is exactly one: plain next-event estimation, bit by bit.
#include "kernels/bsdf/all.h"
#include "kernels/light_weight.h"
#include "kernels/normal_map.h"
#include "kernels/shading_frame.h"
#include "kernels/stage_timer.h"
#include "kernels/stages.h"
#include "scene/shape.h"

namespace sheaf {

namespace {

/// Which candidate is being weighed, of how many.
struct CandidateIndex {
  int index, count;
  bool is_last() const { return index == count - 1; }
};

/// What the candidate in `column` brings if unoccluded, times w_l, over its density; 0 where it is of no use.
template <class L, template <class> class Bsdf>
SHEAF_INLINE Spectrum<L> contribution_of(const SceneView& scene, const Wave& wave, int column, const SurfaceItem<L>& item,
                                         const LightCandidate<L>& light, Spectrum<L> beta, bool mapped, int candidates) {
  using F = Float<L>;
  const Bsdf<L> bsdf = load_bsdf<L, Bsdf>(wave, column);
  const Vec3<L> wi = ShadingFrame<L, Bsdf<L>::kIsAnisotropic>(item).to_local(light.direction);
  BsdfValue<L> value = bsdf.evaluate(item.wo, wi);
  if (mapped) {
    const TexturedItem<L> t = wave.textured.load<L>(column);
    value.f_cos = value.f_cos * shadow_terminator<L>(t.ns_unmapped, t.terminator, light.direction, wi.z);
  }
  const auto usable = light.pdf_solid_angle > F(0.0f);
  const F pdf = select(usable, light.pdf_solid_angle, F(1.0f));
  const auto no_contest = (light.delta > F(0.0f)) | Mask<L>(scene.integrator.strategy == LightStrategy::kLightOnly);
  const F share = select(no_contest, F(1.0f), light_weight(pdf, value.pdf_solid_angle, candidates));
  const Spectrum<L> out = beta * value.f_cos * light.radiance * (share / pdf);
  return select<L>(usable & is_finite(total(out)), out, Spectrum<L>(F(0.0f)));
}

/// Adds a candidate to the reservoir in `column`; returns what is kept.
template <class L>
SHEAF_INLINE ReservoirItem<L> keep_one(const SceneView& scene, Wave& wave, int column, const ThroughputState<L>& path,
                                       Vec3<L> target, Spectrum<L> contribution, bool is_first) {
  using F = Float<L>;
  const F weight = total(contribution);
  ReservoirItem<L> r;
  if (is_first) {
    r.u = draw<L>(scene.sampler, path.pixel, path.sample, path.event(), SampleBlock::kResample).x;
    r.target = target;
    r.contribution = contribution;
    r.weight = r.sum = weight;
    return r;
  }
  r = wave.reservoirs.load<L>(column);
  r.sum = r.sum + weight;
  const F share = weight / max(r.sum, F(1e-37f));
  const auto taken = r.u < share;
  // What is left of u is uniform again.
  const F rest = select(taken, r.u, r.u - share) / max(select(taken, share, F(1.0f) - share), F(1e-37f));
  r.u = clamp(rest, F(0.0f), F(kOneMinusEpsilon));
  r.target = select<L>(taken, target, r.target);
  r.contribution = select<L>(taken, contribution, r.contribution);
  r.weight = select(taken, weight, r.weight);
  return r;
}

template <class L>
SHEAF_INLINE void push_shadow_ray(Wave& wave, const Slot* slots, int count, const SurfaceItem<L>& item, Vec3<L> target,
                                  Spectrum<L> contribution) {
  ShadowItem<L> out;
  out.origin = offset_origin<L>(item.p, item.ng, item.offset, target - item.p);
  out.direction = target - out.origin;
  out.contribution = contribution;
  alignas(kSimdAlignment) std::uint32_t slot_words[L::width];
  for (int lane = 0; lane < L::width; ++lane) slot_words[lane] = slots[lane];
  load(slot_words, out.slot);
  const auto kept = is_finite(out.direction) & is_finite(total(contribution)) & !is_black(contribution) & L::first(count);
  wave.shadow_count += wave.shadows.compress<L>(wave.shadow_count, out, kept);
}

template <class L, template <class> class Bsdf>
SHEAF_INLINE void resample_tile(const SceneView& scene, Wave& wave, const Slot* slots, int column, int count, bool mapped,
                                CandidateIndex candidate) {
  using F = Float<L>;
  const auto item = wave.items.load<L>(column);
  const auto light = wave.candidates.load<L>(column);
  const ThroughputState<L> path = wave.throughput.gather<L>(slots);
  Spectrum<L> contribution =
      contribution_of<L, Bsdf>(scene, wave, column, item, light, path.beta, mapped, candidate.count);
  if (candidate.count == 1) return push_shadow_ray<L>(wave, slots, count, item, light.target, contribution);
  const ReservoirItem<L> r = keep_one<L>(scene, wave, column, path, light.target, contribution, candidate.index == 0);
  if (!candidate.is_last()) return wave.reservoirs.store<L>(column, r);
  const F factor = r.sum / (max(r.weight, F(1e-37f)) * F(static_cast<float>(candidate.count)));
  push_shadow_ray<L>(wave, slots, count, item, r.target, r.contribution * factor);
}

template <class L, template <class> class Bsdf>
void resample_run(const SceneView& scene, Wave& wave, const SurfaceRun& run, CandidateIndex candidate) {
  const bool mapped = (scene.kind_flags[static_cast<int>(Bsdf<L>::kKind)] & kMapped) != 0;
  for_tiles<L>(run.count, [&](int i, int count) {
    resample_tile<L, Bsdf>(scene, wave, wave.sorted.data() + run.slot_begin + i, run.column_begin + i, count, mapped,
                           candidate);
  });
}

}  // namespace

template <class L> void resample(const SceneView& scene, Wave& wave) noexcept {
  if (!samples_lights(scene)) return;
  StageTimer timer(wave.stats, Stage::kResample);
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if constexpr (!Bsdf<L>::kIsSpecular) {
      const SurfaceRun& run = wave.runs[static_cast<int>(kind)];
      timer.count(run.count, L::width);
      resample_run<L, Bsdf>(scene, wave, run, {wave.candidate, scene.integrator.candidates});
    }
  });
}

SHEAF_INSTANTIATE_STAGE(resample);

}  // namespace sheaf
