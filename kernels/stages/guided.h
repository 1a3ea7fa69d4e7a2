// Path guiding: vertices sample directions from the guide as well as from their BSDF.
//
// A direction has pdf p = a p_b + (1 - a) p_g, with p_b that of the BSDF, p_g that of the guide, and a the probability
// of sampling the BSDF. Its weight is f cos / p, whichever of both it was sampled from (one-sample model with the
// balance heuristic, Veach 1997, section 9.2.4). The MIS weights of next-event estimation use p_b instead of p: any
// weights that add up to 1 are unbiased, and light sampling then need not evaluate the guide. The guide cannot sample
// delta lobes: if the BSDF samples one, its weight is divided by a. Specular closures are not guided. Dispersive
// closures are not guided either, as the sampled direction splits their wavelengths.
//
// On blends p_b is the pdf of all guided parts, and p_g is multiplied by the sum of their weights, because each of them
// may have sampled the guide.
#pragma once

#include "core/sampling/octahedral.h"
#include "core/soa/lane_array.h"
#include "kernels/bsdf/list.h"
#include "kernels/guiding/glow_lobes.h"
#include "kernels/guiding/guide_record.h"
#include "kernels/guiding/guide_sample.h"
#include "kernels/stages/blend_value.h"
#include "kernels/stages/roulette.h"
#include "kernels/stages/shading_frame.h"
#include "kernels/wave/lane_mean.h"

namespace sheaf {

/// Whether vertices with this closure may sample the guide.
template <class Bsdf> inline constexpr bool kIsGuided = !Bsdf::kIsSpecular && !kDisperses<Bsdf>;

/// Extinction of the media that the vertices of the columns from `column` on lie in, 1/m; negative outside of fog.
/// Valid if the glow of lights is sampled instead of the guide.
template <class L> SHEAF_INLINE Float<L> glow_extinction(const Wave& wave, int column) {
  return bits_float(wave.guide_cells.load<L>(column).row);
}

/// The guide's value for a direction, at those vertices of the columns from `column` on that are set in `lanes`.
template <class L>
SHEAF_INLINE GuideValue<L> guide_value(const StageContext& context, const Wave& wave, int column, Mask<L> lanes,
                                       Vec3<L> direction) {
  if (context.samples_guide())
    return evaluate_guide<L>(context.guide(), wave.guide_cells.load<L>(column).row, mask_bits(lanes), direction);
  const Float<L> extinction = select(lanes, glow_extinction<L>(wave, column), Float<L>(-1.0f));
  return evaluate_glow<L>(context.scene.lights.tree, wave.vertices.load<L>(column).p, extinction, direction);
}

/// Chooses between BSDF and guide for the first `count` vertices of the columns from `column` on.
template <class L>
SHEAF_INLINE GuideSample<L> choose_guided(const StageContext& context, const Wave& wave, int column, int count,
                                          const Random4<L>& u) {
  if (context.samples_guide()) return sample_guide<L>(context.guide(), wave.guide_cells.load<L>(column).row, count, u);
  const Float<L> extinction = select(L::first(count), glow_extinction<L>(wave, column), Float<L>(-1.0f));
  return sample_glow<L>(context.scene.lights.tree, wave.vertices.load<L>(column).p, extinction, u);
}

/// Pdf of the guided parts of a blend.
template <class L> SHEAF_INLINE Float<L> guided_pdf(const GuideValue<L>& guide, const BlendValue<L>& blend) {
  return guide.mixed(blend.mixed_pdf, blend.guided_weight);
}

/// Pdf that MIS weights use for a direction that a guided vertex samples: that of the BSDF, but above 0, which stands
/// for delta lobes.
template <class L> SHEAF_INLINE Float<L> mis_pdf(Float<L> bsdf_pdf) { return max(bsdf_pdf, Float<L>(1e-10f)); }

/// BsdfSample::eta_scale of a direction: the squared index of refraction if it crosses the surface, otherwise 1.
template <class L, template <class> class Bsdf>
SHEAF_INLINE Float<L> eta_scale_of(const Bsdf<L>& bsdf, Vec3<L> wo, Vec3<L> wi) {
  using F = Float<L>;
  if constexpr (requires { bsdf.squared_index(wo); })
    return select(wo.z * wi.z < F(0.0f), bsdf.squared_index(wo), F(1.0f));
  else
    return F(1.0f);
}

/// GuidedSample::guided_pdf_ratio of a direction sampled with pdf `pdf`. At most 1e4, as the BSDF's own pdf may be
/// close to 0.
template <class L> SHEAF_INLINE Float<L> guided_pdf_ratio(Float<L> pdf, Float<L> bsdf_pdf) {
  using F = Float<L>;
  return min(pdf / max(bsdf_pdf, F(1e-10f)), F(1e4f));
}

/// A sampled direction, and the guide's value for it.
template <class L> struct GuidedSample {
  BsdfSample<L> bsdf;  ///< weight of BSDF and guide combined; pdf_solid_angle is mis_pdf(), or 0 for a delta lobe
  Vec3<L> direction;   ///< world space
  GuideValue<L> guide;
  typename L::Float bsdf_pdf;  ///< pdf of BSDF sampling only; 0: delta lobe
  /// Combined pdf over that of the BSDF. Russian roulette multiplies the throughput by it: guiding lowers the
  /// throughput of directions that it samples often, and these paths are the important ones.
  typename L::Float guided_pdf_ratio = typename L::Float(1.0f);
};

/// Samples directions at the vertices in the columns from `column` on.
template <class L, template <class> class Bsdf>
[[gnu::noinline]] GuidedSample<L> sample_guided(const StageContext& context, const Wave& wave, int column, int count,
                                                const Bsdf<L>& bsdf, const VertexItem<L>& item, Random4<L> u) {
  using F = Float<L>;
  const ShadingFrame<L, Bsdf<L>::kIsAnisotropic> frame(item);
  // Choose between guide and BSDF, and sample both
  const GuideSample<L> of_guide = choose_guided<L>(context, wave, column, count, u);
  u.x = of_guide.bsdf_u;
  GuidedSample<L> out;
  BsdfSample<L>& s = out.bsdf;
  s = bsdf.sample(item.wo, u);
  out.direction = frame.to_world(s.wi);
  Spectrum<L> f_cos = s.weight * s.pdf_solid_angle;
  // Evaluate the BSDF for directions of the guide
  if (any(of_guide.taken)) {
    const Vec3<L> wi = frame.to_local(of_guide.direction);
    const BsdfValue<L> value = bsdf.evaluate(item.wo, wi);
    out.direction = select<L>(of_guide.taken, of_guide.direction, out.direction);
    s.wi = select<L>(of_guide.taken, wi, s.wi);
    f_cos = select<L>(of_guide.taken, value.f_cos, f_cos);
    s.pdf_solid_angle = select(of_guide.taken, value.pdf_solid_angle, s.pdf_solid_angle);
    s.eta_scale = select(of_guide.taken, eta_scale_of<L>(bsdf, item.wo, wi), s.eta_scale);
    s.valid = s.valid | of_guide.taken;
  }
  // Combine the pdfs and the weight
  out.bsdf_pdf = s.pdf_solid_angle;
  const auto smooth = of_guide.taken | (s.valid & (s.pdf_solid_angle > F(0.0f)));
  // The weight of a delta lobe needs bsdf_probability as well.
  out.guide = guide_value<L>(context, wave, column, s.valid & L::first(count), out.direction);
  const F pdf = out.guide.mixed(s.pdf_solid_angle);
  s.valid = s.valid & ((!smooth) | (pdf > F(0.0f)));
  s.weight = select<L>(smooth, f_cos * (F(1.0f) / select(pdf > F(0.0f), pdf, F(1.0f))),
                       s.weight * (F(1.0f) / out.guide.bsdf_probability));
  out.guided_pdf_ratio = select(smooth, guided_pdf_ratio<L>(pdf, out.bsdf_pdf), out.guide.bsdf_probability);
  s.pdf_solid_angle = select(smooth, mis_pdf<L>(out.bsdf_pdf), F(0.0f));
  return out;
}

/// Russian roulette by expected contribution (Vorba and Krivanek, "Adjoint-Driven Russian Roulette and Splitting in
/// Light Transport Simulation", 2016; without splitting). A vertex of throughput b in a cell that scatters the mean
/// radiance M is expected to contribute b M. Roulette starts where this falls below half the path's first such
/// expectation, as roulette by throughput does (kernels/stages/roulette.h). Unlike that, it may terminate paths below
/// depth rr_depth; from there on the survival probability is below 1. Returns survival probabilities, or
/// `default_value` if the cell has no mean or the path no reference. `sum`: the lanes of the throughput added up.
template <class L>
Float<L> expected_survival(const StageContext& context, Wave& wave, const Slot* slots, int column, int count,
                           Uint<L> depth, Float<L> sum, Float<L> default_value) {
  using F = Float<L>;
  constexpr float kMin = 1.0f / 3.0f;
  const F mean = gather(context.guide().means, wave.guide_cells.load<L>(column).row);
  LaneArray<F> references;
  const LaneArray<F> expected(sum * mean);
  for (int lane = 0; lane < L::width; ++lane) references[lane] = wave.guide_references[slots[lane]];
  for (int lane = 0; lane < count; ++lane)
    if (references[lane] == 0.0f && expected[lane] > 0.0f)
      references[lane] = wave.guide_references[slots[lane]] = expected[lane];
  const F reference = references.load();
  const auto known = (mean >= F(0.0f)) & (reference > F(0.0f));
  const F ratio = sum * mean / select(known, reference * F(kSurfaceRouletteThreshold), F(1.0f));
  const F max_ratio = select(depth < Uint<L>(static_cast<std::uint32_t>(context.integrator.roulette_depth())), F(1.0f),
                             F(kLargestSurvival));
  return select(known, clamp(ratio, F(kMin), max_ratio), default_value);
}

/// Records the directions sampled at the vertices of `lanes`. Must be called before throughput and RescaledPdfs change.
template <class L>
void note_directions(const StageContext& context, const Wave& wave, const Slot* slots, int column, std::uint32_t lanes,
                     const VertexItem<L>& item, const PathState<L>& path, Vec3<L> direction, Float<L> bsdf_pdf) {
  using F = Float<L>;
  F divisor(1.0f);
  if (context.scene.needs_transmittance)
    divisor = lane_mean<L>(context.scene.color, wave.rescaled_pdfs.gather<L>(slots).r_u);
  const LaneRows<L, Vec3> p(item.p);
  const LaneArray<F> pdf(bsdf_pdf), per_throughput(divisor / total(path.beta));
  const LaneArray<Uint<L>> directions(encode_octahedral<L>(direction)), side(wave.guide_cells.load<L>(column).side),
      dimension(path.dimension());
  for_each_lane(lanes, [&](int lane) SHEAF_LAMBDA_INLINE {
    if (dimension[lane] >= TrainingSamples::kMaxVertices) return;
    const RadianceState<Scalar>& row = wave.radiance.row(slots[lane]);
    context.training_samples().add(
        {p[lane], directions[lane], per_throughput[lane], pdf[lane], side[lane], row.task_sample & ~kTransparent},
        total(row.radiance));
  });
}

}  // namespace sheaf
