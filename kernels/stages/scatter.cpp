// Stage: scatter. Samples the BSDF or the guide, updates the throughput, beta *= f |cos| / p (PBR 13.4), applies
// Russian roulette and spawns the continuation ray.
#include "core/sampling/octahedral.h"
#include "core/soa/lane_array.h"
#include "kernels/bsdf/list.h"
#include "kernels/photons/light_task.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/stages/adjoint.h"
#include "kernels/stages/chain_state.h"
#include "kernels/stages/continue_ray.h"
#include "kernels/stages/guided.h"
#include "kernels/stages/normal_map.h"
#include "kernels/stages/roulette.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/load_bsdf.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"
#include "scene/surfaces/shape.h"

namespace sheaf {

namespace {

/// Vertices of one closure kind that fill a register.
struct ScatterTile {
  const Slot* slots;  ///< of their paths
  int column, count;  ///< their columns are [column, column + count)
  bool is_mapped;     ///< some materials of the kind have mapped normals
  bool has_parts;     ///< some materials of the kind are parts of blends
};

/// Stores the pdf and the normal, which the emission stage needs for the MIS weight of light that the new ray hits.
template <class L>
SHEAF_INLINE void remember_scattering(Wave& wave, const Slot* slots, std::uint32_t lanes, Float<L> pdf_solid_angle,
                                      Vec3<L> ns) {
  const LaneArray<Float<L>> pdf(pdf_solid_angle);
  const LaneArray<Uint<L>> normal(encode_octahedral<L>(ns));
  const auto remember = [&](int lane) SHEAF_LAMBDA_INLINE {
    RadianceState<Scalar>& row = wave.radiance.row(slots[lane]);
    row.scatter_pdf = pdf[lane];
    row.normal = normal[lane];
  };
  if (lanes == (1u << L::width) - 1u) {
    for (int lane = 0; lane < L::width; ++lane) remember(lane);
    return;
  }
  for_each_lane(lanes, remember);
}

/// Reduces paths that a dispersive surface has transmitted to a single wavelength.
template <class L> SHEAF_INLINE void keep_first_wavelength(Wave& wave, const Slot* slots, std::uint32_t lanes) {
  for_each_lane(lanes, [&](int lane) SHEAF_LAMBDA_INLINE {
    float& hero = wave.wavelength_samples[slots[lane]];
    hero = bits_float(float_bits(hero) | kSingleWavelength);
  });
}

/// Updates the medium of the new ray and RescaledPdfs, in scenes with SceneView::needs_transmittance. Returns the mean
/// of r_u, by which the throughput must be divided. `single`: only the first wavelength continues. Distances of the
/// path were sampled by it so far, except those of stored photons, which any of the four may have sampled.
/// `null_transmittance`: probability of passing a thin dielectric that shadow rays pass as well; 0: none was passed.
template <class L>
Float<L> leave_vertex(const StageContext& context, Wave& wave, const Slot* slots, int count, Vec3<L> ng, bool in_medium,
                      Mask<L> single, Float<L> null_transmittance, RayState<L>& ray) {
  using F = Float<L>;
  using U = Uint<L>;
  const SceneView& scene = context.scene;
  const RayState<L> before = wave.rays.gather<L>(slots);
  F distance(0.0f);
  const auto passed = null_transmittance > F(0.0f);
  // Find the medium of the new ray
  U flags = before.flags & U(~(kRayFromCamera | kRayLast | kRayFromMedium | kRayHistory));
  flags |= select(passed, before.flags & U(kRayFromMedium), U(0u));
  if (in_medium) {
    flags |= U(kRayFromMedium);
  } else {
    const auto through = dot(before.direction, ng) * dot(ray.direction, ng) > F(0.0f);
    const HitState<L> hit = wave.hits.gather<L>(slots);
    const U boundary = gather_member<L>(scene.geometry.shapes, &ShapeRow::boundary, hit.shape);
    const BoundaryCrossing<L> at{boundary, hit.instance, path_times<L>(scene, wave, slots)};
    flags = select(through, medium_behind<L>(scene, at, ng, ray.direction, flags), flags);
    distance = hit.t;
  }
  ray.flags |= flags;
  // Update the rescaled pdfs
  RescaledPdfs<L> r = wave.rescaled_pdfs.gather<L>(slots);
  const bool by_any = context.starts_at_lights() && context.light_task().stores_photons();
  r.r_u = select<L>(single, Spectrum<L>(by_any ? lane_mean<L>(scene.color, r.r_u) : r.r_u.c0), r.r_u);
  r.r_l = select<L>(passed, r.r_l * (F(1.0f) / select(passed, null_transmittance, F(1.0f))), r.r_u);
  wave.rescaled_pdfs.scatter<L>(slots, count, r);
  // Update the distance since the last vertex
  const std::uint32_t on = mask_bits(passed & L::first(count));
  add_distance_since_vertex<L>(wave, slots, on, distance);
  for (int lane = 0; lane < count; ++lane)
    if ((on >> lane & 1u) == 0) wave.distance_since_vertex[slots[lane]] = 0.0f;
  return lane_mean<L>(scene.color, r.r_u);
}

/// Replaces the weight and pdf of directions sampled from a part of a blend by those of the whole blend
/// (kernels/stages/blend_value.h), including the pdf without guiding. Returns the lanes whose weight is that of the
/// blend. `kPartDisperses`: the part is dispersive and keeps its own weight.
template <class L, bool kPartDisperses>
SHEAF_INLINE Mask<L> weigh_as_blend(const StageContext& context, const Wave& wave, const Slot* slots, Mask<L> lanes,
                                    GuidedSample<L>& sample) {
  using F = Float<L>;
  BsdfSample<L>& s = sample.bsdf;
  const bool guides = guides_directions(context);
  lanes = lanes & s.valid & (s.pdf_solid_angle > F(0.0f)) & on_part<L>(context.scene, wave, slots);
  if (!any(lanes)) return Mask<L>(false);
  const BlendValue<L> blend = evaluate_blends<L>(context, wave, slots, lanes, sample.direction);
  const F pdf = guides ? mis_pdf<L>(blend.pdf_solid_angle) : blend.pdf_solid_angle;
  const F mixed_pdf = guides ? guided_pdf<L>(sample.guide, blend) : blend.mixed_pdf;
  lanes = lanes & (pdf > F(0.0f));
  s.pdf_solid_angle = select(lanes, pdf, s.pdf_solid_angle);
  sample.bsdf_pdf = select(lanes, blend.pdf_solid_angle, sample.bsdf_pdf);
  if (kPartDisperses) return Mask<L>(false);
  lanes = lanes & (mixed_pdf > F(0.0f));
  if (guides)
    sample.guided_pdf_ratio = select(lanes, guided_pdf_ratio<L>(mixed_pdf, blend.mixed_pdf), sample.guided_pdf_ratio);
  s.weight = select<L>(lanes, blend.mixed_f_cos * (F(1.0f) / select(lanes, mixed_pdf, F(1.0f))), s.weight);
  return lanes;
}

/// The shading frame that a BSDF needs.
template <class L, template <class> class Bsdf> using FrameOf = ShadingFrame<L, Bsdf<L>::kIsAnisotropic>;

/// Samples the BSDF, or BSDF and guide together.
template <class L, template <class> class Bsdf>
SHEAF_INLINE GuidedSample<L> sample_bsdf_or_guide(const StageContext& context, const Wave& wave,
                                                  const ScatterTile& tile, const Bsdf<L>& bsdf,
                                                  const VertexItem<L>& item, const FrameOf<L, Bsdf>& frame,
                                                  Random4<L> u) {
  if (kIsGuided<Bsdf<L>> && guides_directions(context))
    return sample_guided<L>(context, wave, tile.column, tile.count, bsdf, item, u);
  GuidedSample<L> sample{};
  sample.bsdf = bsdf.sample(item.wo, u);
  sample.direction = frame.to_world(sample.bsdf.wi);
  if (tile.has_parts && guides_directions(context))
    sample.guide =
        guide_value<L>(context, wave, tile.column, sample.bsdf.valid & L::first(tile.count), sample.direction);
  return sample;
}

/// Photons: replaces the weight of BSDFs that are not reciprocal by that of the adjoint BSDF.
template <class L, template <class> class Bsdf>
SHEAF_INLINE void weigh_as_adjoint(const StageContext& context, const Bsdf<L>& bsdf, Vec3<L> wo, BsdfSample<L>& s) {
  using F = Float<L>;
  if constexpr (NotReciprocal<Bsdf<L>, Vec3<L>>) {
    const Mask<L> usable = s.valid & (s.pdf_solid_angle > F(0.0f));
    if (context.starts_at_lights())
      s.weight = adjoint_f_cos<L>(bsdf, wo, s.wi) * (F(1.0f) / select(usable, s.pdf_solid_angle, F(1.0f)));
  }
}

/// Reduces paths to a single wavelength where a dispersive surface scatters the others into other directions. Returns
/// these lanes.
template <class L, template <class> class Bsdf>
SHEAF_INLINE Mask<L> lose_wavelengths(Wave& wave, const ScatterTile& tile, const Bsdf<L>& bsdf, Vec3<L> wo,
                                      Vec3<L> wi) {
  Mask<L> single(false);
  if constexpr (kDisperses<Bsdf<L>>) {
    single = loses_wavelengths<L>(bsdf, wo, wi) & L::first(tile.count);
    keep_first_wavelength<L>(wave, tile.slots, mask_bits(single));
  }
  return single;
}

/// Camera paths: updates throughput and eta scale. `blended`: lanes whose weight includes the shadow terminator, see
/// weigh_as_blend().
template <class L>
SHEAF_INLINE void scatter_radiance(const Wave& wave, const ScatterTile& tile, const GuidedSample<L>& sample,
                                   Mask<L> blended, PathState<L>& path) {
  const BsdfSample<L>& s = sample.bsdf;
  path.beta = path.beta * s.weight;
  if (tile.is_mapped) {
    const TexturedItem<L> t = wave.textured.load<L>(tile.column);
    const Float<L> terminator = shadow_terminator<L>(t.ns_unmapped, t.terminator, sample.direction, s.wi.z);
    path.beta = path.beta * select(blended, Float<L>(1.0f), terminator);
  }
  path.eta_scale = path.eta_scale * s.eta_scale * sample.guided_pdf_ratio;
}

/// Photons: updates the throughput, with the adjoint corrections at surfaces (kernels/stages/adjoint.h).
template <class L, template <class> class Bsdf>
SHEAF_INLINE void scatter_photon(const Wave& wave, const ScatterTile& tile, const VertexItem<L>& item,
                                 const FrameOf<L, Bsdf>& frame, const GuidedSample<L>& sample, PathState<L>& path) {
  const BsdfSample<L>& s = sample.bsdf;
  path.beta = path.beta * s.weight;
  if constexpr (!kIsPhaseFunction<Bsdf<L>>) {
    const Vec3<L> arriving = frame.to_world(item.wo);
    path.beta = path.beta * (adjoint_cosines<L>(item, arriving, sample.direction, s.wi.z) * s.eta_scale);
    if (tile.is_mapped) {
      const TexturedItem<L> t = wave.textured.load<L>(tile.column);
      path.beta = path.beta * adjoint_terminator<L>(t, arriving, item.wo.z);
      path.beta =
          select<L>(matches_normal_choice<L>(t, item.ns, sample.direction), path.beta, Spectrum<L>(Float<L>(0.0f)));
    }
  }
}

/// Paths at a thin dielectric that costs no depth.
template <class L> struct FreePassage {
  /// Probability of passing a thin dielectric that shadow rays pass as well; 0: none was passed.
  typename L::Float null_transmittance = typename L::Float(0.0f);
  typename L::Mask ended = typename L::Mask(false);  ///< reflected, although the ray was the last of its path
};

/// Counts depth and random-number dimension. Thin dielectrics that light passes may be free.
template <class L, template <class> class Bsdf>
SHEAF_INLINE FreePassage<L> count_depth(const StageContext& context, const Wave& wave, const ScatterTile& tile,
                                        const Bsdf<L>& bsdf, Vec3<L> wo, Vec3<L> wi, PathState<L>& path) {
  using F = Float<L>;
  using U = Uint<L>;
  FreePassage<L> out;
  path.depth_and_dimension = path.depth_and_dimension + U(kOneDepth + kOneDimension);
  if constexpr (Bsdf<L>::Closure::kInfo.is_thin_dielectric) {
    if (context.integrator.thin_dielectrics_are_free) {
      const auto passes = wo.z * wi.z < F(0.0f);
      path.depth_and_dimension = select(passes, path.depth_and_dimension - U(kOneDepth), path.depth_and_dimension);
      if (context.scene.shadow_rays_pass_thin_dielectrics)
        out.null_transmittance = select(passes, bsdf.passage(wo.z).probability, F(0.0f));
      out.ended = (!passes) & ((wave.rays.gather<L>(tile.slots).flags & U(kRayLast)) != U(0u));
    }
  }
  return out;
}

/// The ray from the vertex along `direction`, without its medium and history.
template <class L>
SHEAF_INLINE RayState<L> spawn_ray(const StageContext& context, const VertexItem<L>& item, Vec3<L> direction,
                                   const PathState<L>& path) {
  using U = Uint<L>;
  RayState<L> ray;
  ray.direction = direction;
  ray.origin = offset_origin<L>(item.p, item.ng, item.offset, ray.direction);
  ray.t_max = Float<L>(kInfinity);
  const auto max_depth = static_cast<std::uint32_t>(context.max_depth);  // -1: larger than any depth
  ray.flags = select(path.depth() + U(1u) < U(max_depth), U(0u), U(kRayLast));
  return ray;
}

/// Adds the path's history to the flags of the ray, if photon maps need it. Returns the paths that
/// the integrator continues behind a vertex that samples directions with `pdf_solid_angle`.
template <class L, bool kInMedium>
SHEAF_INLINE Mask<L> track_history(const StageContext& context, const Wave& wave, const ScatterTile& tile,
                                   Float<L> pdf_solid_angle, Float<L> null_transmittance, RayState<L>& ray) {
  using F = Float<L>;
  using U = Uint<L>;
  Mask<L> continues(true);
  const auto is_delta = pdf_solid_angle == F(0.0f), passed = null_transmittance > F(0.0f);
  if (context.gathers_photons() || context.starts_at_lights()) {
    const U before = wave.rays.gather<L>(tile.slots).flags;
    // Light sampling passes such thin dielectrics, so they do not count as specular here.
    const auto specular = is_delta & (null_transmittance == F(0.0f));
    ray.flags |= select(passed, before & U(kRayHistory), history_behind<L, kInMedium>(context, before, specular));
    if (context.gathers_photons())
      continues = continues & (is_delta | !context.photon_maps().ends_at<L>(before, kInMedium));
    if (context.starts_at_lights() && context.light_task().ends_at_scattering()) continues = continues & is_delta;
  }
  if (context.integrator.ends_at_diffuse) continues = continues & (is_delta | passed);
  return continues;
}

/// Queues the paths of `alive` for intersection, and the others as finished.
SHEAF_INLINE void queue_paths(Wave& wave, const ScatterTile& tile, std::uint32_t alive) {
  wave.stats.rays.scatter += static_cast<std::uint64_t>(std::popcount(alive));
  wave.active.push(tile.slots, alive);
  wave.finished.push(tile.slots, ~alive & ((1u << tile.count) - 1u));
}

template <class L, template <class> class Bsdf>
SHEAF_INLINE void scatter_tile(const StageContext& context, Wave& wave, const ScatterTile& tile) {
  using F = Float<L>;
  constexpr bool kInMedium = kIsPhaseFunction<Bsdf<L>>;
  const Slot* const slots = tile.slots;
  const int column = tile.column, count = tile.count;
  const auto item = wave.vertices.load<L>(column);
  const Bsdf<L> bsdf = load_bsdf<L, Bsdf>(context.scene, wave, column);
  const FrameOf<L, Bsdf> frame(item);
  PathState<L> path = wave.paths.gather<L>(slots);

  // Sample the BSDF or the guide
  const auto u = draw<L>(context.sampler, path.pixel, path.sample, path.dimension(), SampleBlock::kScatter, {},
                         guides_directions(context) ? kAllNumbers : numbers_of<Bsdf<L>>() | kNumberW);
  GuidedSample<L> sample = sample_bsdf_or_guide<L, Bsdf>(context, wave, tile, bsdf, item, frame, u);
  BsdfSample<L>& s = sample.bsdf;

  // Weight the sample as the whole blend, or by the adjoint BSDF
  Mask<L> blended(false);
  if (tile.has_parts && !context.starts_at_lights())
    blended = weigh_as_blend<L, kDisperses<Bsdf<L>>>(context, wave, slots, L::first(count), sample);
  if (kIsGuided<Bsdf<L>> && context.trains_guide())
    note_directions<L>(context, wave, slots, column,
                       mask_bits(s.valid & (s.pdf_solid_angle > F(0.0f)) & L::first(count)), item, path,
                       sample.direction, sample.bsdf_pdf);
  weigh_as_adjoint<L, Bsdf>(context, bsdf, item.wo, s);

  // Update the throughput and count depth
  const F arrived = total(path.beta);
  const Mask<L> single = lose_wavelengths<L, Bsdf>(wave, tile, bsdf, item.wo, s.wi);
  if (context.starts_at_lights())
    scatter_photon<L, Bsdf>(wave, tile, item, frame, sample, path);
  else
    scatter_radiance<L>(wave, tile, sample, blended, path);
  const FreePassage<L> passage = count_depth<L, Bsdf>(context, wave, tile, bsdf, item.wo, s.wi, path);
  Mask<L> alive =
      s.valid & (!passage.ended) & !is_black(path.beta) & (path.depth() < Uint<L>(kLongestPath)) & L::first(count);

  // Spawn the continuation ray
  RayState<L> ray = spawn_ray<L>(context, item, sample.direction, path);
  alive = alive & track_history<L, kInMedium>(context, wave, tile, s.pdf_solid_angle, passage.null_transmittance, ray);
  if (!kInMedium && context.connects_caustics())
    follow_chain<L>(context, wave, slots, count, {item.ng, s.pdf_solid_angle == F(0.0f), item.wo.z * s.wi.z < F(0.0f)},
                    ray);
  F divisor(1.0f);
  if (context.scene.needs_transmittance)
    divisor = leave_vertex<L>(context, wave, slots, count, item.ng, kInMedium, single, passage.null_transmittance, ray);

  // Apply Russian roulette
  F survival = survival_by_throughput<L>(context, path, divisor);
  if (kIsGuided<Bsdf<L>> && context.samples_guide())
    survival = expected_survival<L>(context, wave, slots, column, count, path.depth(), arrived / divisor, survival);
  alive = alive & roulette<L>(path, survival, u.w);

  // Store the states and queue the paths
  wave.rays.scatter<L>(slots, count, ray);
  wave.paths.scatter<L>(slots, count, path);
  const std::uint32_t scattered = mask_bits(L::first(count) & (passage.null_transmittance == F(0.0f)));
  const bool mapped_parts = tile.has_parts && tile.is_mapped;
  const Vec3<L> ns = mapped_parts ? receiver_normal<L>(context.scene, wave, slots, column, item.ns) : item.ns;
  remember_scattering<L>(wave, slots, scattered, s.pdf_solid_angle, ns);
  queue_paths(wave, tile, mask_bits(alive));
}

template <class L, template <class> class Bsdf>
void scatter_run(const StageContext& context, Wave& wave, const VertexRun& run) {
  const bool mapped = (context.scene.materials.buckets.kind_flags[static_cast<int>(kKindOf<Bsdf<L>>)] & kMapped) != 0;
  const bool parts = has_parts(context.scene, kKindOf<Bsdf<L>>);
  for_tiles<L>(run.count, [&](int i, int count) {
    scatter_tile<L, Bsdf>(context, wave,
                          {wave.sorted.data() + run.slot_begin + i, run.column_begin + i, count, mapped, parts});
  });
}

}  // namespace

template <class L> void scatter(const StageContext& context, Wave& wave) noexcept {
  StageTimer timer(wave.stats, stage_named<L>("scatter"));
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    const VertexRun& run = wave.runs[static_cast<int>(kind)];
    timer.count(run.count, L::width);
    scatter_run<L, Bsdf>(context, wave, run);
  });
  wave.sorted.clear();
}

SHEAF_INSTANTIATE_STAGE(scatter);

}  // namespace sheaf
