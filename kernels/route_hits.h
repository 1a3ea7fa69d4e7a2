// Where paths go once it is known what their rays run into: the lists that later stages work on.
#pragma once

#include "kernels/wave.h"

namespace sheaf {

/// Rays of one tile at what they hit.
template <class L> struct RoutedHits {
  typename L::Mask found;      ///< false: the ray leaves the scene
  typename L::Uint light, material, flags;  ///< HitState::light and material, RayState::flags
};

/// Whether materials are thin panes.
template <class L> SHEAF_INLINE Mask<L> is_pane(const SceneView& scene, typename L::Uint material) {
  using U = typename L::Uint;
  constexpr auto kRowWords = static_cast<std::uint32_t>(sizeof(MaterialRow) / sizeof(std::uint32_t));
  static_assert(offsetof(MaterialRow, kind) == 0);
  const U kind = gather(reinterpret_cast<const std::uint32_t*>(scene.materials), material * U(kRowWords));
  return (kind == U(static_cast<std::uint32_t>(ClosureKind::kThinDielectric))) |
         (kind == U(static_cast<std::uint32_t>(ClosureKind::kDispersiveThinDielectric)));
}

/// Pushes the slots of the lanes `good` to miss, emitter, composite, surface and finished.
template <class L>
SHEAF_INLINE void route_hits(const SceneView& scene, Wave& wave, const Slot* slots, std::uint32_t good,
                             const RoutedHits<L>& hit) {
  using U = typename L::Uint;
  constexpr auto kRowWords = static_cast<std::uint32_t>(sizeof(MaterialRow) / sizeof(std::uint32_t));
  const std::uint32_t hits = mask_bits(hit.found) & good;
  const std::uint32_t lights = mask_bits(hit.light != U(kNone)) & good;
  std::uint32_t last = mask_bits((hit.flags & U(kRayLast)) != U(0u));
  const std::uint32_t from_camera = mask_bits((hit.flags & U(kRayFromCamera)) != U(0u));
  // Hidden lights are left to the emission stage, which sends the ray on behind them.
  const std::uint32_t hidden = scene.integrator.hide_emitters ? lights & from_camera : 0u;
  // Panes that cost no depth are left to the scatter stage.
  if (scene.integrator.free_panes) last &= ~mask_bits(is_pane<L>(scene, select(hit.found, hit.material, U(0u))));
  std::uint32_t composite = 0;
  if (scene.has_composites) {
    const auto* materials = reinterpret_cast<const std::uint32_t*>(scene.materials);
    const U material_flags = gather(materials + offsetof(MaterialRow, flags) / sizeof(std::uint32_t),
                                    select(hit.found, hit.material, U(0u)) * U(kRowWords));
    composite = mask_bits((material_flags & U(kComposite)) != U(0u)) & hits & ~hidden;
  }
  const std::uint32_t shaded = hits & ~hidden & ~composite;
  wave.miss.push(slots, good & ~hits);
  wave.emitter.push(slots, lights);
  wave.composite.push(slots, composite);
  wave.surface.push(slots, shaded & ~last);
  wave.finished.push(slots, shaded & last);
}

}  // namespace sheaf
