// Routes paths to queues by what their rays hit.
#pragma once

#include "kernels/wave/wave.h"

namespace sheaf {

/// The hits of the rays of one tile.
template <class L> struct RoutedHits {
  typename L::Mask found;                   ///< false: the ray left the scene
  typename L::Uint light, material, flags;  ///< HitState::light and material, RayState::flags
};

/// Whether materials are thin dielectrics.
template <class L> SHEAF_INLINE Mask<L> is_thin_dielectric(const SceneView& scene, typename L::Uint material) {
  using U = typename L::Uint;
  const U kind = gather_member<L>(scene.materials.rows, &MaterialRow::kind, material);
  Mask<L> found(false);
  for_each_closure([&]<class Closure>(ClosureKind closure, Closure) SHEAF_LAMBDA_INLINE {
    if constexpr (Closure::kInfo.is_thin_dielectric) found = found | (kind == U(static_cast<std::uint32_t>(closure)));
  });
  return found;
}

/// Pushes the slots of `lanes` to the queue of their vertex's material: composite or surface, or finished if the path
/// has reached max_depth. `material`: rows, valid in all lanes. `flags`: RayState::flags.
template <class L>
SHEAF_INLINE void route_vertices(const StageContext& context, Wave& wave, const Slot* slots, std::uint32_t lanes,
                                 Uint<L> material, Uint<L> flags) {
  using U = typename L::Uint;
  std::uint32_t last = mask_bits((flags & U(kRayLast)) != U(0u));
  // Thin dielectrics that cost no depth are left to the scatter stage.
  if (context.integrator.thin_dielectrics_are_free) last &= ~mask_bits(is_thin_dielectric<L>(context.scene, material));
  std::uint32_t composite = 0;
  if (context.scene.materials.has_composites) {
    const U material_flags = gather_member<L>(context.scene.materials.rows, &MaterialRow::flags, material);
    composite = mask_bits((material_flags & U(kComposite)) != U(0u)) & lanes;
  }
  const std::uint32_t shaded = lanes & ~composite;
  wave.composite.push(slots, composite);
  wave.surface.push(slots, shaded & ~last);
  wave.finished.push(slots, shaded & last);
}

/// Pushes the slots of the lanes `good` to miss or emitter, and to the queues of route_vertices().
template <class L>
SHEAF_INLINE void route_hits(const StageContext& context, Wave& wave, const Slot* slots, std::uint32_t good,
                             const RoutedHits<L>& hit) {
  using U = typename L::Uint;
  const std::uint32_t hits = mask_bits(hit.found) & good;
  const std::uint32_t lights = mask_bits(hit.light != U(kNone)) & good;
  const std::uint32_t from_camera = mask_bits((hit.flags & U(kRayFromCamera)) != U(0u));
  // The emission stage continues rays behind hidden lights.
  const std::uint32_t hidden = context.integrator.hide_emitters ? lights & from_camera : 0u;
  wave.miss.push(slots, good & ~hits);
  wave.emitter.push(slots, lights);
  route_vertices<L>(context, wave, slots, hits & ~hidden, select(hit.found, hit.material, U(0u)), hit.flags);
}

}  // namespace sheaf
