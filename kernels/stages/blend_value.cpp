// Evaluates the parts of blends one material row at a time for a whole register of vertices, and sums them by weight.
#include "kernels/stages/blend_value.h"

#include "core/soa/lane_array.h"
#include "kernels/bsdf/list.h"
#include "kernels/stages/normal_map.h"
#include "kernels/stages/ray_footprint.h"
#include "kernels/stages/shading_texture.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/path_wavelengths.h"
#include "scene/surfaces/shape.h"

#include <array>
#include <bit>

namespace sheaf {

namespace {

/// Inputs that all parts at a register of vertices share.
template <class L> struct BlendPoint {
  SurfacePoint<L> y;
  Vec3<L> from;  ///< direction of the incoming ray
  Vec3<L> wi;
  TextureQuery<L> query;
  Spectrum<L> lambda;  ///< spectral mode
};

/// Offsets of the spectra among the parameters of each kind.
const auto kSpectraOf = [] {
  std::array<ClosureSpectra, kClosureKinds> found{};
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    found[static_cast<std::size_t>(kind)] = closure_spectra<Bsdf>();
  });
  return found;
}();

/// Computes the parameters of a part's closure from its material row and textures. All kinds share this code, as most
/// of it is texture lookups.
template <class L, ColorMode kMode>
[[gnu::noinline]] void part_words(const SceneView& scene, std::uint32_t row, const BlendPoint<L>& at,
                                  Float<L> (&words)[kMaxClosureWords]) {
  const MaterialRow& m = scene.materials.rows[row];
  for (int k = 0; k < kMaxClosureWords; ++k) words[k] = Float<L>(m.words[k]);
  const auto put = [&words](std::uint32_t word, std::uint32_t count, const Spectrum<L>& value) {
    const Float<L> channels[4] = {value.c0, value.c1, value.c2, value.c3};
    for (std::uint32_t k = 0; k < count; ++k) words[word + k] = channels[k];
  };
  if constexpr (kMode == ColorMode::kSpectral) {
    const ClosureSpectra& spectra = kSpectraOf[static_cast<std::size_t>(m.kind)];
    for (int k = 0; k < spectra.count; ++k)
      put(static_cast<std::uint32_t>(spectra.word[k]), 4, closure_spectrum<L>(scene, Uint<L>(row), k, at.lambda));
  }
  for (std::uint32_t b = 0; b < m.binding_count; ++b) {
    const TextureBinding& binding = scene.materials.bindings[m.first_binding + b];
    put(binding.word, binding.words, shading_texture<L, kMode>(scene, binding, at.query, at.lambda));
  }
}

/// Directions in the shading frame of a part, and its shadow terminator.
template <class L> struct PartFrame {
  Vec3<L> wo, wi;
  Float<L> softened;    ///< factor on the part's value
  Float<L> handedness;  ///< see handedness_of()
};

/// The shading frame of a part, with its normal flipped for two-sided materials and mapped.
template <class L>
[[gnu::noinline]] PartFrame<L> part_frame(const SceneView& scene, const MaterialRow& m, const BlendPoint<L>& at,
                                          Mask<L> lanes) {
  using F = Float<L>;
  const auto flipped = Mask<L>((m.flags & kTwoSided) != 0) & (dot(at.y.ns, at.from) > F(0.0f));
  const Vec3<L> base = select<L>(flipped, -at.y.ns, at.y.ns);
  Vec3<L> n = base;
  F terminator(0.0f);
  if (m.flags & kMapped) {
    const NormalMapRow& map = scene.materials.normal_maps[m.map];
    Mask<L> usable(false);
    n = perturbed_normal<L>(scene.textures, map, at.query, base, select(flipped, F(-1.0f), F(1.0f)), at.y.dp_du,
                            at.y.dp_dv, lanes, usable);
    if (map.flags & NormalMapRow::kFixInvalid)
      n = select<L>(faces_away<L>(n, base, -at.from), mirrored_normal<L>(n, base), n);
    if (map.flags & NormalMapRow::kSoften) terminator = terminator_of(dot(n, base));
  }
  const ShadingFrame<L, true> frame(n, tangent_of<L>(Frame<L>::from_normal(n), at.y.dp_du));
  const Vec3<L> wi = frame.to_local(at.wi);
  const F softened = m.flags & kMapped ? shadow_terminator<L>(base, terminator, at.wi, wi.z) : F(1.0f);
  return {frame.to_local(-at.from), wi, softened, handedness_of<L>(base, at.y.dp_du, at.y.dp_dv)};
}

/// Sums the parts of one blend. All of `lanes` are on this blend and on the same side of it.
template <class L> struct BlendSum {
  using F = typename L::Float;
  const SceneView& scene;
  const BlendPoint<L>& at;
  Mask<L> lanes;
  bool behind;
  BlendValue<L> sum{Spectrum<L>(F(0.0f)), F(0.0f), Spectrum<L>(F(0.0f)), F(0.0f), F(0.0f)};
  /// Sum of the weights of all parts except "nothing".
  F there = F(0.0f);

  void add(std::uint32_t row, F weight) {
    if (row == MaterialRow::kNothing || !any(lanes & (weight > F(0.0f)))) return;
    if (behind) row = scene.materials.rows[row].back;
    const MaterialRow& m = scene.materials.rows[row];
    if ((m.flags & kComposite) == 0) return add_part(row, weight);
    F second(m.second_weight());
    if (m.binding_count > 0)
      second = lookup_scalar<L>(scene.textures, scene.materials.bindings[m.first_binding].texture, at.query);
    second = clamp(second, F(0.0f), F(1.0f));
    add(m.choice[0], weight * (F(1.0f) - second));
    add(m.choice[1], weight * second);
  }

 private:
  void add_part(std::uint32_t row, F weight) {
    there = there + weight;
    for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
      if constexpr (!Bsdf<L>::kIsSpecular && !kIsPhaseFunction<Bsdf<L>>) {
        if (kind != scene.materials.rows[row].kind) return;
        // Load the BSDF of the part
        F words[kMaxClosureWords];
        if (scene.color == ColorMode::kSpectral)
          part_words<L, ColorMode::kSpectral>(scene, row, at, words);
        else
          part_words<L, ColorMode::kRgb>(scene, row, at, words);
        const MaterialRow& m = scene.materials.rows[row];
        const PartFrame<L> frame = part_frame<L>(scene, m, at, lanes);
        if (const std::uint32_t word = m.flags >> kRotationWordShift; word != 0)
          words[word - 1] = words[word - 1] * frame.handedness;
        const auto bsdf = bsdf_of_words<Bsdf<L>>(scene.materials.closure_tables,
                                                 [&words](int k, F& word) SHEAF_LAMBDA_INLINE { word = words[k]; });
        // Add its value times its weight
        BsdfValue<L> value = bsdf.evaluate(frame.wo, frame.wi);
        value.f_cos = value.f_cos * frame.softened;
        sum.f_cos = sum.f_cos + value.f_cos * weight;
        sum.pdf_solid_angle = sum.pdf_solid_angle + value.pdf_solid_angle * weight;
        if (kDisperses<Bsdf<L>>) return;
        sum.mixed_f_cos = sum.mixed_f_cos + value.f_cos * weight;
        sum.mixed_pdf = sum.mixed_pdf + value.pdf_solid_angle * weight;
        sum.guided_weight = sum.guided_weight + weight;
      }
    });
  }
};

}  // namespace

template <class L>
BlendValue<L> evaluate_blends(const StageContext& context, const Wave& wave, const Slot* slots, Mask<L> lanes,
                              Vec3<L> wi) noexcept {
  using F = Float<L>;
  using U = Uint<L>;
  const SceneView& scene = context.scene;
  const RayState<L> ray = wave.rays.gather<L>(slots);
  const HitState<L> hit = wave.hits.gather<L>(slots);
  const ShapeRecord<L> shape = gather_rows<L>(scene.geometry.shapes, hit.shape);
  BlendPoint<L> at{surface_point<L, true>(scene, shape, hit.primitive, hit.u, hit.v, ray.origin + ray.direction * hit.t,
                                          hit.instance, path_times<L>(scene, wave, slots)),
                   ray.direction,
                   wi,
                   {},
                   {}};
  const RayFootprint<L> footprint = ray_footprint<L>(context, wave, slots, ray, hit.t, at.y);
  at.query = {at.y.uv, hit.shape, hit.primitive, hit.u, hit.v, at.y.p, footprint.squared_lengths, footprint.axis};
  const auto behind = dot(at.y.ng, ray.direction) > F(0.0f);
  BlendValue<L> out{Spectrum<L>(F(0.0f)), F(0.0f), Spectrum<L>(F(0.0f)), F(0.0f), F(0.0f)};
  const LaneArray<U> roots(shape.material);
  with_color_mode(scene, [&]<ColorMode kMode>() { at.lambda = shading_wavelengths<L, kMode>(wave, slots); });
  // Evaluate one blend at a time, for all lanes on the same side of it.
  while (any(lanes)) {
    const int first = std::countr_zero(mask_bits(lanes));
    const bool is_behind = (mask_bits(behind) >> first & 1u) != 0;
    const Mask<L> same = lanes & (shape.material == U(roots[first])) & (is_behind ? behind : !behind);
    BlendSum<L> blend{scene, at, same, is_behind};
    blend.add(roots[first], F(1.0f));
    const F scale = F(1.0f) / max(blend.there, F(1e-20f));
    out.f_cos = select<L>(same, blend.sum.f_cos * scale, out.f_cos);
    out.pdf_solid_angle = select(same, blend.sum.pdf_solid_angle * scale, out.pdf_solid_angle);
    out.mixed_f_cos = select<L>(same, blend.sum.mixed_f_cos * scale, out.mixed_f_cos);
    out.mixed_pdf = select(same, blend.sum.mixed_pdf * scale, out.mixed_pdf);
    out.guided_weight = select(same, blend.sum.guided_weight * scale, out.guided_weight);
    lanes = lanes & !same;
  }
  return out;
}

template BlendValue<SHEAF_STAGE_LANE> evaluate_blends<SHEAF_STAGE_LANE>(const StageContext&, const Wave&, const Slot*,
                                                                        Mask<SHEAF_STAGE_LANE>,
                                                                        Vec3<SHEAF_STAGE_LANE>) noexcept;

}  // namespace sheaf
