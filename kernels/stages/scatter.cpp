// Stage: scatter. Samples the BSDF or the guide, applies Russian roulette and spawns the continuation ray.
#include "core/octahedral.h"
#include "kernels/bsdf/all.h"
#include "kernels/film/light_task.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/stages/adjoint.h"
#include "kernels/stages/continue_ray.h"
#include "kernels/stages/guided.h"
#include "kernels/stages/normal_map.h"
#include "kernels/stages/roulette.h"
#include "kernels/stages/stages.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"
#include "scene/tables/shape.h"

namespace sheaf {

namespace {

/// Stores the data that the emission stage needs for the MIS weight of light that the new ray finds.
template <class L>
SHEAF_INLINE void remember_scattering(Wave& wave, const Slot* slots, std::uint32_t lanes, Float<L> pdf_solid_angle,
                                      Vec3<L> ns) {
  alignas(kSimdAlignment) float pdf[L::width];
  alignas(kSimdAlignment) std::uint32_t normal[L::width];
  store(pdf, pdf_solid_angle);
  store(normal, encode_octahedral<L>(ns));
  const auto remember = [&](int lane) SHEAF_LAMBDA_INLINE {
    RadianceState<Scalar>& row = wave.radiance.row(slots[lane]);
    row.scatter_pdf = pdf[lane];
    row.normal = normal[lane];
  };
  if (lanes == (1u << L::width) - 1u) {
    for (int lane = 0; lane < L::width; ++lane) remember(lane);
    return;
  }
  for (; lanes != 0; lanes &= lanes - 1) remember(std::countr_zero(lanes));
}

/// Reduces paths that a dispersive surface has transmitted to a single wavelength.
template <class L> SHEAF_INLINE void keep_first_wavelength(Wave& wave, const Slot* slots, std::uint32_t lanes) {
  for (; lanes != 0; lanes &= lanes - 1) {
    float& hero = wave.wavelength_samples[slots[std::countr_zero(lanes)]];
    hero = bits_float(float_bits(hero) | kSingleWavelength);
  }
}

/// Updates the medium of the new ray and RescaledPdfs, in scenes with SceneView::needs_transmittance. Returns the mean
/// of r_u, by which the throughput must be divided. `single`: only the first wavelength continues. Distances of the
/// path were sampled by it so far, except those of stored photons, which any of the four may have sampled.
/// `null_transmittance`: probability of passing an open pane, which shadow rays pass as well; 0: no open pane was
/// passed.
template <class L>
Float<L> leave_vertex(const StageContext& context, Wave& wave, const Slot* slots, int count, Vec3<L> ng, bool in_medium,
                      Mask<L> single, Float<L> null_transmittance, RayState<L>& ray) {
  using F = Float<L>;
  using U = Uint<L>;
  const SceneView& scene = context.scene;
  const RayState<L> before = wave.rays.gather<L>(slots);
  F distance(0.0f);
  const auto passed = null_transmittance > F(0.0f);
  U flags = before.flags & U(~(kRayFromCamera | kRayLast | kRayFromMedium | kRayHistory));
  flags |= select(passed, before.flags & U(kRayFromMedium), U(0u));
  if (in_medium) {
    flags |= U(kRayFromMedium);
  } else {
    const auto through = dot(before.direction, ng) * dot(ray.direction, ng) > F(0.0f);
    const HitState<L> hit = wave.hits.gather<L>(slots);
    const U boundary = gather_member<L>(scene.geometry.shapes, &ShapeRow::boundary, hit.shape);
    flags = select(through, medium_behind<L>(scene, boundary, ng, ray.direction, flags), flags);
    distance = hit.t;
  }
  ray.flags |= flags;
  RescaledPdfs<L> r = wave.rescaled_pdfs.gather<L>(slots);
  const bool by_any = context.starts_at_lights() && context.photons->stores_photons();
  r.r_u = select<L>(single, Spectrum<L>(by_any ? lane_mean<L>(scene.color, r.r_u) : r.r_u.c0), r.r_u);
  r.r_l = select<L>(passed, r.r_l * (F(1.0f) / select(passed, null_transmittance, F(1.0f))), r.r_u);
  wave.rescaled_pdfs.scatter<L>(slots, count, r);
  const std::uint32_t on = mask_bits(passed & L::first(count));
  add_distance_since_vertex<L>(wave, slots, on, distance);
  for (int lane = 0; lane < count; ++lane)
    if ((on >> lane & 1u) == 0) wave.distance_since_vertex[slots[lane]] = 0.0f;
  return lane_mean<L>(scene.color, r.r_u);
}

/// Replaces the weight and pdf of directions sampled from a part of a blend by those of the whole blend
/// (kernels/stages/blend_value.h), including the pdf without guiding. Returns the lanes whose weight is that of the
/// blend. `Disperses`: the part is dispersive and keeps its own weight.
template <class L, bool Disperses>
SHEAF_INLINE Mask<L> weigh_as_blend(const StageContext& context, const Wave& wave, const Slot* slots, Mask<L> lanes,
                                    GuidedSample<L>& sample) {
  using F = Float<L>;
  BsdfSample<L>& s = sample.bsdf;
  const bool guides = context.guides;
  lanes = lanes & s.valid & (s.pdf_solid_angle > F(0.0f)) & on_part<L>(context.scene, wave, slots);
  if (!any(lanes)) return Mask<L>(false);
  const BlendValue<L> blend = evaluate_blends<L>(context, wave, slots, lanes, sample.direction);
  const F pdf = guides ? whole_pdf<L>(sample.guide, blend) : blend.pdf_solid_angle;
  const F mixed_pdf = guides ? guided_pdf<L>(sample.guide, blend) : blend.mixed_pdf;
  lanes = lanes & (pdf > F(0.0f));
  s.pdf_solid_angle = select(lanes, pdf, s.pdf_solid_angle);
  sample.bsdf_pdf = select(lanes, blend.pdf_solid_angle, sample.bsdf_pdf);
  if (Disperses) return Mask<L>(false);
  lanes = lanes & (mixed_pdf > F(0.0f));
  if (guides)
    sample.guided_pdf_ratio = select(lanes, guided_pdf_ratio<L>(mixed_pdf, blend.mixed_pdf), sample.guided_pdf_ratio);
  s.weight = select<L>(lanes, blend.mixed_f_cos * (F(1.0f) / select(lanes, mixed_pdf, F(1.0f))), s.weight);
  return lanes;
}

template <class L, template <class> class Bsdf>
SHEAF_INLINE void scatter_tile(const StageContext& context, Wave& wave, const Slot* slots, int column, int count,
                               bool mapped, bool parts) {
  using F = Float<L>;
  using U = Uint<L>;
  // Sample the BSDF or the guide
  const auto item = wave.vertices.load<L>(column);
  const Bsdf<L> bsdf = load_bsdf<L, Bsdf>(context.scene, wave, column);
  PathState<L> path = wave.paths.gather<L>(slots);
  const auto u = draw<L>(context.sampler, path.pixel, path.sample, path.dimension(), SampleBlock::kScatter, {},
                         context.guides ? kAllNumbers : numbers_of<Bsdf<L>>() | kNumberW);
  const ShadingFrame<L, Bsdf<L>::kIsAnisotropic> frame(item);
  GuidedSample<L> sample{};
  if (kIsGuided<Bsdf<L>> && context.guides) {
    sample = sample_guided<L>(context, wave, column, count, bsdf, item, u);
  } else {
    sample.bsdf = bsdf.sample(item.wo, u);
    sample.direction = frame.to_world(sample.bsdf.wi);
    if (parts && context.guides)
      sample.guide = guide_value<L>(context, wave, column, sample.bsdf.valid & L::first(count), sample.direction);
  }
  BsdfSample<L>& s = sample.bsdf;
  const Vec3<L> direction = sample.direction;

  // Weight the sample as the whole blend
  Mask<L> blended(false);
  if (parts && !context.starts_at_lights())
    blended = weigh_as_blend<L, kDisperses<Bsdf<L>>>(context, wave, slots, L::first(count), sample);
  if (kIsGuided<Bsdf<L>> && context.trains_guide())
    note_directions<L>(context, wave, slots, column,
                       mask_bits(s.valid & (s.pdf_solid_angle > F(0.0f)) & L::first(count)), item, path, direction,
                       sample.bsdf_pdf);
  if constexpr (NotReciprocal<Bsdf<L>, Vec3<L>>) {
    const Mask<L> usable = s.valid & (s.pdf_solid_angle > F(0.0f));
    if (context.starts_at_lights())
      s.weight = adjoint_f_cos<L>(bsdf, item.wo, s.wi) * (F(1.0f) / select(usable, s.pdf_solid_angle, F(1.0f)));
  }
  // Update the throughput
  const F arrived = total(path.beta);
  path.beta = path.beta * s.weight;
  Mask<L> single(false);
  if constexpr (kDisperses<Bsdf<L>>) {
    single = loses_wavelengths<L>(bsdf, item.wo, s.wi) & L::first(count);
    keep_first_wavelength<L>(wave, slots, mask_bits(single));
  }
  if (!context.starts_at_lights()) {
    if (mapped) {
      const TexturedItem<L> t = wave.textured.load<L>(column);
      const F terminator = shadow_terminator<L>(t.ns_unmapped, t.terminator, direction, s.wi.z);
      path.beta = path.beta * select(blended, F(1.0f), terminator);
    }
    path.eta_scale = path.eta_scale * s.eta_scale * sample.guided_pdf_ratio;
  } else if constexpr (!kIsPhaseFunction<Bsdf<L>>) {
    const Vec3<L> arriving = frame.to_world(item.wo);
    path.beta = path.beta * (adjoint_cosines<L>(item, arriving, direction, s.wi.z) * s.eta_scale);
    if (mapped) {
      const TexturedItem<L> t = wave.textured.load<L>(column);
      path.beta = path.beta * adjoint_terminator<L>(t, arriving, item.wo.z);
      path.beta = select<L>(matches_normal_choice<L>(t, item.ns, direction), path.beta, Spectrum<L>(F(0.0f)));
    }
  }
  // Count depth; thin dielectrics may be free
  auto ended = Mask<L>(false);
  F null_transmittance(0.0f);
  path.depth_and_dimension = path.depth_and_dimension + U(kOneDepth + kOneDimension);
  if constexpr (closure_info(Bsdf<L>::kKind).is_thin_dielectric) {
    if (context.integrator.thin_dielectrics_are_free) {
      const auto passes = item.wo.z * s.wi.z < F(0.0f);
      path.depth_and_dimension = select(passes, path.depth_and_dimension - U(kOneDepth), path.depth_and_dimension);
      if (context.scene.has_open_panes)
        null_transmittance = select(passes, bsdf.passage(item.wo.z).probability, F(0.0f));
      ended = (!passes) & ((wave.rays.gather<L>(slots).flags & U(kRayLast)) != U(0u));
    }
  }
  auto alive = s.valid & (!ended) & !is_black(path.beta) & (path.depth() < U(kLongestPath)) & L::first(count);

  // Spawn the continuation ray
  RayState<L> ray;
  ray.direction = direction;
  ray.origin = offset_origin<L>(item.p, item.ng, item.offset, ray.direction);
  ray.t_max = F(kInfinity);
  const auto max_depth = static_cast<std::uint32_t>(context.integrator.max_depth);  // -1: larger than any depth
  ray.flags = select(path.depth() + U(1u) < U(max_depth), U(0u), U(kRayLast));
  if (context.gathers_photons() || context.starts_at_lights()) {
    const U before = wave.rays.gather<L>(slots).flags;
    // Light sampling passes open panes, so they do not count as specular here.
    const auto specular = (s.pdf_solid_angle == F(0.0f)) & (null_transmittance == F(0.0f));
    const auto passed = null_transmittance > F(0.0f);
    ray.flags |= select(passed, before & U(kRayHistory),
                        history_behind<L, kIsPhaseFunction<Bsdf<L>>>(context, before, specular));
    if (context.gathers_photons())
      alive = alive & ((s.pdf_solid_angle == F(0.0f)) | !context.maps->ends_at<L>(before, kIsPhaseFunction<Bsdf<L>>));
    if (context.starts_at_lights() && context.photons->ends_at_scattering())
      alive = alive & (s.pdf_solid_angle == F(0.0f));
  }
  if (context.integrator.ends_at_diffuse)
    alive = alive & ((s.pdf_solid_angle == F(0.0f)) | (null_transmittance > F(0.0f)));
  F divisor(1.0f);
  if (context.scene.needs_transmittance)
    divisor = leave_vertex<L>(context, wave, slots, count, item.ng, kIsPhaseFunction<Bsdf<L>>, single,
                              null_transmittance, ray);
  // Apply Russian roulette
  F survival = survival_by_throughput<L>(context, path, divisor);
  if (kIsGuided<Bsdf<L>> && context.guides)
    survival = expected_survival<L>(context, wave, slots, column, count, path.depth(), arrived / divisor, survival);
  alive = alive & roulette<L>(path, survival, u.w);
  wave.rays.scatter<L>(slots, count, ray);
  wave.paths.scatter<L>(slots, count, path);
  const std::uint32_t scattered = mask_bits(L::first(count) & (null_transmittance == F(0.0f)));
  const bool mapped_parts = parts && mapped;
  const Vec3<L> ns = mapped_parts ? receiver_normal<L>(context.scene, wave, slots, column, item.ns) : item.ns;
  remember_scattering<L>(wave, slots, scattered, s.pdf_solid_angle, ns);

  const std::uint32_t bits = mask_bits(alive);
  wave.stats.rays.scatter += static_cast<std::uint64_t>(std::popcount(bits));
  wave.active.push(slots, bits);
  wave.finished.push(slots, ~bits & ((1u << count) - 1u));
}

template <class L, template <class> class Bsdf>
void scatter_run(const StageContext& context, Wave& wave, const VertexRun& run) {
  const bool mapped = (context.scene.materials.buckets.kind_flags[static_cast<int>(Bsdf<L>::kKind)] & kMapped) != 0;
  const bool parts = has_parts(context.scene, Bsdf<L>::kKind);
  for_tiles<L>(run.count, [&](int i, int count) {
    scatter_tile<L, Bsdf>(context, wave, wave.sorted.data() + run.slot_begin + i, run.column_begin + i, count, mapped,
                          parts);
  });
}

}  // namespace

template <class L> void scatter(const StageContext& context, Wave& wave) noexcept {
  StageTimer timer(wave.stats, Stage::kScatter);
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    const VertexRun& run = wave.runs[static_cast<int>(kind)];
    timer.count(run.count, L::width);
    scatter_run<L, Bsdf>(context, wave, run);
  });
  wave.sorted.clear();
}

SHEAF_INSTANTIATE_STAGE(scatter);

}  // namespace sheaf
