// All parts of a blend at once. The select_materials stage has chosen one of them, and where paths go is up to that
// one; but light is sampled for all, and scattering counts as all together would have scattered, so that of the choice
// no noise is left but where it leads.
//
// With shares s_j, values f_j and densities p_j of the parts, and f = sum s_j f_j, p = sum s_j p_j, light sampling is
// that of a BSDF of value f and density p; and a direction sampled from part i, which was chosen with probability s_i,
// has the weight f / p in place of f_i / p_i (Veach 1997, section 9.2.4: one-sample model, balance heuristic). Delta
// lobes are no part of f and p. Shares are those among the parts that are there: nothing may be one of them.
#pragma once

#include "kernels/wave/context.h"
#include "kernels/wave/wave.h"

namespace sheaf {

/// The sum over the parts in a direction.
template <class L> struct BlendValue {
  Spectrum<L> f_cos;                  ///< f times |cos(wi)|, edges of shadows softened as maps say
  typename L::Float pdf_solid_angle;  ///< p
  /// The same without the parts that disperse: where one of these is chosen, wavelengths are lost, so it counts alone.
  Spectrum<L> mixed_f_cos;
  typename L::Float mixed_pdf;
  typename L::Float guided_share;  ///< of the parts that neither are specular nor disperse
};

/// Whether the vertices of a kind may be on parts of blends.
inline bool has_parts(const SceneView& scene, ClosureKind kind) {
  return (scene.kind_flags[static_cast<std::size_t>(kind)] & kPart) != 0;
}

/// Which of the vertices at `slots` are on parts of blends.
template <class L> SHEAF_INLINE Mask<L> on_part(const SceneView& scene, const Wave& wave, const Slot* slots) {
  using U = Uint<L>;
  const HitState<L> hit = wave.hits.gather<L>(slots);
  return (gather_member<L>(scene.materials, &MaterialRow::flags, hit.material) & U(kPart)) != U(0u);
}

/// Whether some of these parts have maps.
inline bool has_mapped_parts(const SceneView& scene, ClosureKind kind) {
  return has_parts(scene, kind) && (scene.kind_flags[static_cast<std::size_t>(kind)] & kMapped) != 0;
}

/// The normal by which lights are chosen, of kinds that have mapped parts: on blends it must not depend on the part
/// that was chosen, as the weights of light and BSDF sampling would not add up. `ns`: the item's.
template <class L>
SHEAF_INLINE Vec3<L> receiver_normal(const SceneView& scene, const Wave& wave, const Slot* slots, int column,
                                     Vec3<L> ns) {
  return select<L>(on_part<L>(scene, wave, slots), wave.textured.load<L>(column).ns_unmapped, ns);
}

/// The blends at the vertices of `lanes`, in direction `wi`, world space. Reads ray and hit state, so it must come
/// before the next ray is written.
template <class L>
BlendValue<L> evaluate_blends(const StageContext& context, const Wave& wave, const Slot* slots, Mask<L> lanes,
                              Vec3<L> wi) noexcept;

}  // namespace sheaf
