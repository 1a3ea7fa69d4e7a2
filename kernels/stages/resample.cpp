// Stage: resample. Resampled importance sampling of light candidates with a weighted reservoir: one of M candidates per
// vertex is kept and becomes a shadow ray (Talbot, Cline and Egbert 2005, "Importance Resampling for Global
// Illumination", equation 6).
//
// With candidates x_i of pdf p and the target function q(x), the kept candidate y gives the estimate
//     f(y) / q(y) * 1/M sum_i q(x_i) / p(x_i).
// MIS splits the integrand f into w_l f for light sampling and w_b f for BSDF sampling with pdf b. Any weights that
// depend only on x and add up to 1 keep the sum unbiased, whatever technique estimates each part. So the pdf of the
// kept candidate, which has no closed form, is not needed. The weights are the power heuristic of M p and b, since M
// candidates are worth up to M samples:
//     w_l = (M p)^2 / ((M p)^2 + b^2),  w_b = 1 - w_l.
// q is the unoccluded part w_l f, lanes added up. Lights that BSDF sampling cannot find have w_l = 1. For M = 1 the
// factor is exactly 1, which is plain next-event estimation, bit by bit.
//
// If shadow rays pass media or surfaces, w_l also depends on them. Then q is unchanged, but the transmittance stage
// receives f and applies w_l.
#include "kernels/bsdf/list.h"
#include "kernels/lights/light_weight.h"
#include "kernels/stages/blend_value.h"
#include "kernels/stages/candidate_moments.h"
#include "kernels/stages/normal_map.h"
#include "kernels/stages/push_shadow_ray.h"
#include "kernels/stages/shading_frame.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/load_bsdf.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

namespace {

/// Index of the candidate to be weighted, and the number of candidates.
struct CandidateIndex {
  int index, count;
  bool is_last() const { return index == count - 1; }
};

/// A candidate with its contribution at a vertex.
template <class L> struct WeighedCandidate {
  Spectrum<L> contribution;      ///< unoccluded radiance over the pdf; 0: not usable
  typename L::Float mis_weight;  ///< w_l if `contribution` does not include it yet, otherwise 1
  typename L::Float pdf_ratio;   ///< see TransmittanceItem
  typename L::Mask single;       ///< only the first of four wavelengths reaches the light, weighted by 4
};

/// The value of a blend where one of its parts keeps only the first of four wavelengths: then the first wavelength of
/// all parts represents the path. Returns the lanes where this is so.
template <class L> SHEAF_INLINE Mask<L> keep_first_of_blend(const BlendValue<L>& blend, Spectrum<L>& f_cos) {
  using F = Float<L>;
  const Spectrum<L>&all = blend.f_cos, &mixed = blend.mixed_f_cos;
  const auto single = (all.c0 > mixed.c0) & (all.c1 == mixed.c1) & (all.c2 == mixed.c2) & (all.c3 == mixed.c3);
  // The dispersive parts already include the factor of 4.
  f_cos = select<L>(single, {fma(F(3.0f), mixed.c0, all.c0), F(0.0f), F(0.0f), F(0.0f)}, f_cos);
  return single;
}

template <class L, template <class> class Bsdf>
SHEAF_INLINE WeighedCandidate<L> weigh(const StageContext& context, const Wave& wave, const Slot* slots, int column,
                                       const VertexItem<L>& item, const LightCandidate<L>& light, Spectrum<L> beta,
                                       bool mapped, bool parts, int candidates) {
  using F = Float<L>;
  // Evaluate the BSDF
  const Bsdf<L> bsdf = load_bsdf<L, Bsdf>(context.scene, wave, column);
  const Vec3<L> wi = ShadingFrame<L, Bsdf<L>::kIsAnisotropic>(item).to_local(light.direction);
  BsdfValue<L> value = bsdf.evaluate(item.wo, wi);
  if (mapped) {
    const TexturedItem<L> t = wave.textured.load<L>(column);
    value.f_cos = value.f_cos * shadow_terminator<L>(t.ns_unmapped, t.terminator, light.direction, wi.z);
  }
  const auto usable = light.pdf_solid_angle > F(0.0f);
  Mask<L> single = loses_wavelengths<L>(bsdf, item.wo, wi);
  // Replace the value by that of the whole blend
  if (parts) {
    const auto lanes = usable & on_part<L>(context.scene, wave, slots);
    if (any(lanes)) {
      const BlendValue<L> blend = evaluate_blends<L>(context, wave, slots, lanes, light.direction);
      value.f_cos = select<L>(lanes, blend.f_cos, value.f_cos);
      value.pdf_solid_angle = select(lanes, blend.pdf_solid_angle, value.pdf_solid_angle);
      single = single & !lanes;
      if (context.scene.color == ColorMode::kSpectral && context.scene.needs_transmittance) {
        Spectrum<L> first = value.f_cos;
        single = single | (lanes & keep_first_of_blend<L>(blend, first));
        value.f_cos = select<L>(lanes, first, value.f_cos);
      }
    }
  }
  // Compute the MIS weight w_l, and w_l f / p
  const F pdf = select(usable, light.pdf_solid_angle, F(1.0f));
  const auto only_light = (light.delta > F(0.0f)) | Mask<L>(context.integrator.strategy == LightStrategy::kLightOnly);
  const F mis_weight = select(only_light, F(1.0f), light_weight(pdf, value.pdf_solid_angle, candidates));
  const bool shared = !context.scene.needs_transmittance;
  const Spectrum<L> out = beta * value.f_cos * light.radiance * ((shared ? mis_weight : F(1.0f)) / pdf);
  const F pdf_ratio = select(only_light, F(0.0f), value.pdf_solid_angle / (pdf * F(static_cast<float>(candidates))));
  // A point in a medium competes with collisions of the path, whose pdf is not known yet.
  const auto in_volume = light.target_medium != Uint<L>(kNone);
  return {select<L>(usable & is_finite(total(out)), out, Spectrum<L>(F(0.0f))),
          select(shared | in_volume, F(1.0f), mis_weight), pdf_ratio, single};
}

/// A reservoir, and whether it has just taken the last candidate.
template <class L> struct Reservoir {
  ReservoirItem<L> item;
  typename L::Mask taken;
};

/// Adds a candidate to the reservoir in `column`; returns the new reservoir.
template <class L>
SHEAF_INLINE Reservoir<L> keep_one(const StageContext& context, Wave& wave, int column, const PathState<L>& path,
                                   const LightCandidate<L>& light, const WeighedCandidate<L>& candidate,
                                   bool is_first) {
  using F = Float<L>;
  using U = Uint<L>;
  const F weight = total(candidate.contribution) * candidate.mis_weight;
  const U single = select(candidate.single, U(1u), U(0u));
  ReservoirItem<L> r;
  if (is_first) {
    // Start the reservoir with the first candidate
    r.u = draw<L>(context.sampler, path.pixel, path.sample, path.dimension(), SampleBlock::kResample, {}, kNumberX).x;
    r.target = light.target;
    r.contribution = candidate.contribution;
    r.weight = r.sum = weight;
    r.pdf_ratio = candidate.pdf_ratio;
    r.light = light.light;
    r.target_medium = light.target_medium;
    r.single = single;
    return {r, Mask<L>(true)};
  }
  // Choose between the kept candidate and this one: P(x_i) = W_i / sum_j<=i W_j
  r = wave.reservoirs.load<L>(column);
  r.sum = r.sum + weight;
  const F probability = weight / max(r.sum, F(1e-37f));
  const auto taken = r.u < probability;
  // The remainder of u is uniform again.
  const F rest =
      select(taken, r.u, r.u - probability) / max(select(taken, probability, F(1.0f) - probability), F(1e-37f));
  r.u = clamp(rest, F(0.0f), F(kOneMinusEpsilon));
  // Replace the kept candidate
  r.target = select<L>(taken, light.target, r.target);
  r.contribution = select<L>(taken, candidate.contribution, r.contribution);
  r.weight = select(taken, weight, r.weight);
  r.pdf_ratio = select(taken, candidate.pdf_ratio, r.pdf_ratio);
  r.light = select(taken, light.light, r.light);
  r.target_medium = select(taken, light.target_medium, r.target_medium);
  r.single = select(taken, single, r.single);
  return {r, taken};
}

template <class L, template <class> class Bsdf>
SHEAF_INLINE void resample_tile(const StageContext& context, Wave& wave, const Slot* slots, int column, int count,
                                bool mapped, bool parts, CandidateIndex candidate) {
  using F = Float<L>;
  const auto item = wave.vertices.load<L>(column);
  const auto light = wave.candidates.load<L>(column);
  const PathState<L> path = wave.paths.gather<L>(slots);
  constexpr bool kInMedium = kIsPhaseFunction<Bsdf<L>>;
  const WeighedCandidate<L> weighed =
      weigh<L, Bsdf>(context, wave, slots, column, item, light, path.beta, mapped, parts, candidate.count);
  if (candidate.count == 1)
    return push_shadow_ray<L>(context.scene, wave, slots, count, item,
                              {light.target, weighed.pdf_ratio, light.light, light.target_medium}, weighed.contribution,
                              kInMedium, weighed.single);
  const Reservoir<L> kept = keep_one<L>(context, wave, column, path, light, weighed, candidate.index == 0);
  const ReservoirItem<L>& r = kept.item;
  if (context.compares_candidates()) [[unlikely]]
    try_candidate<L>(context, wave, slots, column, count, total(weighed.contribution) * weighed.mis_weight,
                     weighed.pdf_ratio, kept.taken, candidate.index);
  if (!candidate.is_last()) return wave.reservoirs.store<L>(column, r);
  // Push the shadow ray with f(y) / q(y) * 1/M sum_i W_i
  const F factor = r.sum / (max(r.weight, F(1e-37f)) * F(static_cast<float>(candidate.count)));
  push_shadow_ray<L>(context.scene, wave, slots, count, item, {r.target, r.pdf_ratio, r.light, r.target_medium},
                     r.contribution * factor, kInMedium, r.single != Uint<L>(0u));
}

template <class L, template <class> class Bsdf>
void resample_run(const StageContext& context, Wave& wave, const VertexRun& run, CandidateIndex candidate) {
  const bool mapped = (context.scene.materials.buckets.kind_flags[static_cast<int>(kKindOf<Bsdf<L>>)] & kMapped) != 0;
  const bool parts = has_parts(context.scene, kKindOf<Bsdf<L>>);
  for_tiles<L>(run.count, [&](int i, int count) {
    resample_tile<L, Bsdf>(context, wave, wave.sorted.data() + run.slot_begin + i, run.column_begin + i, count, mapped,
                           parts, candidate);
  });
}

}  // namespace

template <class L> void resample(const StageContext& context, Wave& wave, int candidate) noexcept {
  if (!samples_lights(context)) return;
  StageTimer timer(wave.stats, stage_named<L>("resample"));
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if (Bsdf<L>::kIsSpecular && !has_parts(context.scene, kind)) return;
    const VertexRun& run = wave.runs[static_cast<int>(kind)];
    timer.count(run.count, L::width);
    resample_run<L, Bsdf>(context, wave, run, {candidate, context.candidates});
  });
}

SHEAF_INSTANTIATE_CANDIDATE_STAGE(resample);

}  // namespace sheaf
