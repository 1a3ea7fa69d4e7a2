// Stage: scatter. Samples the BSDF, plays Russian roulette and writes the next ray.
#include "core/octahedral.h"
#include "kernels/bsdf/all.h"
#include "kernels/medium_boundary.h"
#include "kernels/normal_map.h"
#include "kernels/path_wavelengths.h"
#include "kernels/route_hits.h"
#include "kernels/shading_frame.h"
#include "kernels/stage_timer.h"
#include "kernels/stages.h"
#include "scene/shape.h"

namespace sheaf {

namespace {

/// Roulette keeps at most this share, so that paths between perfect mirrors end.
constexpr float kLargestSurvival = 0.95f;

/// Paths at depth rr_depth and beyond survive with the probability of their throughput over `divisor`, squared index of
/// refraction taken out, and are weighted by its inverse. Returns who survives.
template <class L>
SHEAF_INLINE Mask<L> roulette(const IntegratorDescription& settings, ThroughputState<L>& path, Float<L> divisor,
                              Float<L> u) {
  using F = Float<L>;
  using U = Uint<L>;
  const auto exempt = path.depth() < U(static_cast<std::uint32_t>(settings.rr_depth));
  const F survival = min(max_component(path.beta) * path.eta_scale / divisor, F(kLargestSurvival));
  const auto survives = exempt | (u < survival);
  const F factor = select(exempt | !survives, F(1.0f), F(1.0f) / survival);
  path.beta = path.beta * factor;
  return survives;
}

/// What emission needs in order to weigh the light that the new ray finds: two words of the radiance state.
template <class L>
SHEAF_INLINE void remember_scattering(Wave& wave, const Slot* slots, std::uint32_t lanes, Float<L> pdf_solid_angle,
                                      Vec3<L> ns) {
  constexpr int kScatterPdfWord = 4, kNormalWord = 5;
  alignas(kSimdAlignment) float pdf[L::width], normal[L::width];
  store(pdf, pdf_solid_angle);
  store(normal, bits_float(encode_octahedral<L>(ns)));
  for (; lanes != 0; lanes &= lanes - 1) {
    const int lane = std::countr_zero(lanes);
    float* row = wave.radiance.row(slots[lane]);
    row[kScatterPdfWord] = pdf[lane];
    row[kNormalWord] = normal[lane];
  }
}

/// Paths that a dispersing surface let through have one wavelength left.
template <class L> SHEAF_INLINE void keep_first_wavelength(Wave& wave, const Slot* slots, std::uint32_t lanes) {
  for (; lanes != 0; lanes &= lanes - 1) {
    float& hero = wave.heroes[slots[std::countr_zero(lanes)]];
    hero = bits_float(float_bits(hero) | kSingleWavelength);
  }
}

/// Scenes with media or surfaces that let shadow rays pass: the medium of the new ray, and ProbabilityState. Returns
/// the mean of the latter, by which throughput is to be divided. `single`: where the first wavelength alone goes on.
/// `open`: with which probability an open pane was passed, as shadow rays might have; 0: it was none.
template <class L>
Float<L> leave_vertex(const SceneView& scene, Wave& wave, const Slot* slots, int count, Vec3<L> ng, bool in_medium,
                      Mask<L> single, Float<L> open, RayState<L>& ray) {
  using F = Float<L>;
  using U = Uint<L>;
  const RayState<L> before = wave.rays.gather<L>(slots);
  F distance(0.0f);
  const auto passed = open > F(0.0f);
  U flags = before.flags & U(~(kRayFromCamera | kRayLast | kRayFromMedium));
  flags |= select(passed, before.flags & U(kRayFromMedium), U(0u));
  if (in_medium) {
    flags |= U(kRayFromMedium);
  } else {
    const auto through = dot(before.direction, ng) * dot(ray.direction, ng) > F(0.0f);
    const HitState<L> hit = wave.hits.gather<L>(slots);
    const U boundary = load_shapes<L>(scene, hit.shape).boundary;
    flags = select(through, medium_behind<L>(scene, boundary, ng, ray.direction, flags), flags);
    distance = hit.t;
  }
  ray.flags |= flags;
  ProbabilityState<L> r = wave.probabilities.gather<L>(slots);
  r.r_u = select<L>(single, Spectrum<L>(r.r_u.c0), r.r_u);
  r.r_l = select<L>(passed, r.r_l * (F(1.0f) / select(passed, open, F(1.0f))), r.r_u);
  wave.probabilities.scatter<L>(slots, count, r);
  alignas(kSimdAlignment) float further[L::width];
  store(further, distance);
  const std::uint32_t on = mask_bits(passed);
  for (int lane = 0; lane < count; ++lane) {
    float& travelled = wave.travelled[slots[lane]];
    travelled = (on >> lane & 1u) != 0 ? travelled + further[lane] : 0.0f;
  }
  return scene.color == ColorMode::kSpectral ? total(r.r_u) * F(0.25f)
                                             : (r.r_u.c0 + r.r_u.c1 + r.r_u.c2) * F(1.0f / 3.0f);
}

template <class L, template <class> class Bsdf>
SHEAF_INLINE void scatter_tile(const SceneView& scene, Wave& wave, const Slot* slots, int column, int count,
                               bool mapped) {
  using F = Float<L>;
  using U = Uint<L>;
  const auto item = wave.items.load<L>(column);
  const Bsdf<L> bsdf = load_bsdf<L, Bsdf>(wave, column);
  ThroughputState<L> path = wave.throughput.gather<L>(slots);
  const auto u = draw<L>(scene.sampler, path.pixel, path.sample, path.event(), SampleBlock::kScatter);
  const BsdfSample<L> s = bsdf.sample(item.wo, u);
  const Vec3<L> direction = ShadingFrame<L, Bsdf<L>::kIsAnisotropic>(item).to_world(s.wi);

  path.beta = path.beta * s.weight;
  Mask<L> single(false);
  if constexpr (kDisperses<Bsdf<L>>) {
    single = (item.wo.z * s.wi.z < F(0.0f)) & L::first(count);
    keep_first_wavelength<L>(wave, slots, mask_bits(single));
  }
  if (mapped) {
    const TexturedItem<L> t = wave.textured.load<L>(column);
    path.beta = path.beta * shadow_terminator<L>(t.ns_unmapped, t.terminator, direction, s.wi.z);
  }
  path.eta_scale = path.eta_scale * s.eta_scale;
  auto ended = Mask<L>(false);
  F open(0.0f);
  path.progress = path.progress + U(kOneDepth + kOneEvent);
  if constexpr (is_pane_kind(Bsdf<L>::kKind)) {
    if (scene.integrator.free_panes) {
      const auto passes = item.wo.z * s.wi.z < F(0.0f);
      path.progress = select(passes, path.progress - U(kOneDepth), path.progress);
      if (scene.has_open_panes) open = select(passes, bsdf.passage(item.wo.z).probability, F(0.0f));
      ended = (!passes) & ((wave.rays.gather<L>(slots).flags & U(kRayLast)) != U(0u));
    }
  }
  auto alive = s.valid & (!ended) & !is_black(path.beta) & (path.depth() < U(kLongestPath)) & L::first(count);

  RayState<L> ray;
  ray.direction = direction;
  ray.origin = offset_origin<L>(item.p, item.ng, item.offset, ray.direction);
  ray.t_max = F(kInfinity);
  const auto max_depth = static_cast<std::uint32_t>(scene.integrator.max_depth);  // -1: larger than any depth
  ray.flags = select(path.depth() + U(1u) < U(max_depth), U(0u), U(kRayLast));
  F divisor(1.0f);
  if (scene.has_transparency)
    divisor = leave_vertex<L>(scene, wave, slots, count, item.ng, kIsPhaseFunction<Bsdf<L>>, single, open, ray);
  alive = alive & roulette<L>(scene.integrator, path, divisor, u.w);
  wave.rays.scatter<L>(slots, count, ray);
  wave.throughput.scatter<L>(slots, count, path);
  const std::uint32_t scattered = mask_bits(L::first(count) & (open == F(0.0f)));
  remember_scattering<L>(wave, slots, scattered, s.pdf_solid_angle, item.ns);

  const std::uint32_t bits = mask_bits(alive);
  wave.stats.rays.scatter += static_cast<std::uint64_t>(std::popcount(bits));
  wave.active.push(slots, bits);
  wave.finished.push(slots, ~bits & ((1u << count) - 1u));
}

template <class L, template <class> class Bsdf>
void scatter_run(const SceneView& scene, Wave& wave, const SurfaceRun& run) {
  const bool mapped = (scene.kind_flags[static_cast<int>(Bsdf<L>::kKind)] & kMapped) != 0;
  for_tiles<L>(run.count, [&](int i, int count) {
    scatter_tile<L, Bsdf>(scene, wave, wave.sorted.data() + run.slot_begin + i, run.column_begin + i, count, mapped);
  });
}

}  // namespace

template <class L> void scatter(const SceneView& scene, Wave& wave) noexcept {
  StageTimer timer(wave.stats, Stage::kScatter);
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    const SurfaceRun& run = wave.runs[static_cast<int>(kind)];
    timer.count(run.count, L::width);
    scatter_run<L, Bsdf>(scene, wave, run);
  });
}

SHEAF_INSTANTIATE_STAGE(scatter);

}  // namespace sheaf
