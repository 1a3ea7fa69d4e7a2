// Evaluates all parts of a blend together. The select_materials stage selects one part, which determines where the path
// continues. Light sampling and scattering use the value of the whole blend, so that the selection adds noise only
// through the sampled direction.
//
// Parts have weights s_j, values f_j and pdfs p_j; f = sum s_j f_j and p = sum s_j p_j. Light sampling uses a BSDF of
// value f and pdf p. A direction sampled from part i, which was selected with probability s_i, has the weight f / p
// instead of f_i / p_i (Veach 1997, section 9.2.4: one-sample model, balance heuristic). Delta lobes are not part of f
// and p. Weights are relative to the parts that exist: a part that is "nothing" does not count.
#pragma once

#include "kernels/wave/context.h"
#include "kernels/wave/wave.h"

namespace sheaf {

/// Sum over the parts for one direction.
template <class L> struct BlendValue {
  /// f times |cos(wi)|, including the shadow terminators of normal maps.
  Spectrum<L> f_cos;
  typename L::Float pdf_solid_angle;  ///< p
  /// The same without dispersive parts. Selecting one of those loses wavelengths, so it keeps its own weight.
  Spectrum<L> mixed_f_cos;
  typename L::Float mixed_pdf;
  typename L::Float guided_weight;  ///< sum of the weights of parts that are neither specular nor dispersive
};

/// Whether vertices of a kind may be on parts of blends.
inline bool has_parts(const SceneView& scene, ClosureKind kind) {
  return (scene.materials.buckets.kind_flags[static_cast<std::size_t>(kind)] & kPart) != 0;
}

/// The vertices at `slots` that are on parts of blends.
template <class L> SHEAF_INLINE Mask<L> on_part(const SceneView& scene, const Wave& wave, const Slot* slots) {
  using U = Uint<L>;
  const HitState<L> hit = wave.hits.gather<L>(slots);
  return (gather_member<L>(scene.materials.rows, &MaterialRow::flags, hit.material) & U(kPart)) != U(0u);
}

/// Whether some of these parts have normal or bump maps.
inline bool has_mapped_parts(const SceneView& scene, ClosureKind kind) {
  return has_parts(scene, kind) && (scene.materials.buckets.kind_flags[static_cast<std::size_t>(kind)] & kMapped) != 0;
}

/// The normal for light selection, for kinds with mapped parts. On blends it must not depend on the part that was
/// selected: otherwise the MIS weights of light and BSDF sampling do not add up to 1. `ns`: VertexItem::ns.
template <class L>
SHEAF_INLINE Vec3<L> receiver_normal(const SceneView& scene, const Wave& wave, const Slot* slots, int column,
                                     Vec3<L> ns) {
  return select<L>(on_part<L>(scene, wave, slots), wave.textured.load<L>(column).ns_unmapped, ns);
}

/// Evaluates the blends at the vertices of `lanes` in direction `wi`, world space. Reads RayState and HitState, so it
/// must be called before the next ray is written.
template <class L>
BlendValue<L> evaluate_blends(const StageContext& context, const Wave& wave, const Slot* slots, Mask<L> lanes,
                              Vec3<L> wi) noexcept;

}  // namespace sheaf
