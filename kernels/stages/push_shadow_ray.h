// Pushes shadow rays from vertices to the queue of the shadow stages: rays to lights, and rays to the camera.
#pragma once

#include "core/soa/lane_array.h"
#include "kernels/stages/medium_boundary.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/wave.h"
#include "scene/surfaces/shape.h"

namespace sheaf {

/// Bits of TransmittanceItem::flags. They reuse bits that shadow rays do not need. The first two are for rays to the
/// camera if lights are hidden: camera rays pass hidden lights until they hit a thin dielectric; they see lights behind
/// it.
enum ShadowFlags : std::uint32_t {
  kShadowFromHiddenLight = kRayFromCamera,  ///< starts on a hidden light and has passed no thin dielectric
  kShadowPassedHiddenLight = kRayLast,
  kShadowFromSegment = kRayFromMedium,  ///< starts on a segment of a path, not at a vertex
};
inline constexpr std::uint32_t kShadowFlags = kShadowFromHiddenLight | kShadowPassedHiddenLight | kShadowFromSegment;

/// Added to the dimension of a path for shadow rays from its segments: their random numbers are independent of those of
/// its vertices.
inline constexpr std::uint32_t kSegmentDimension = 0x8000u;

/// The end of a shadow ray; see TransmittanceItem.
template <class L> struct ShadowEnd {
  Vec3<L> target;
  typename L::Float pdf_ratio;
  typename L::Uint light, medium;
  typename L::Uint flags = typename L::Uint(0u);  ///< ShadowFlags
};

/// Pushes the TransmittanceItem of those shadow rays that push_shadow_ray() keeps. `single`: lanes where only the first
/// of four wavelengths continues, so that the mean pdf becomes the pdf of that wavelength.
template <class L>
void push_transmittance(const SceneView& scene, Wave& wave, const Slot* slots, const VertexItem<L>& item,
                        const ShadowItem<L>& shadow, const ShadowEnd<L>& end, bool in_medium, Mask<L> single,
                        Mask<L> kept) {
  using F = Float<L>;
  using U = Uint<L>;
  const RayState<L> ray = wave.rays.gather<L>(slots);
  TransmittanceItem<L> out;
  const Spectrum<L> r_u = wave.rescaled_pdfs.gather<L>(slots).r_u;
  out.r_u = out.r_l = select<L>(single, {r_u.c0 * F(4.0f), F(0.0f), F(0.0f), F(0.0f)}, r_u);
  out.pdf_ratio = end.pdf_ratio;
  out.target_medium = end.medium;
  out.flags = ray.flags;
  if (!in_medium) {
    const auto through = dot(ray.direction, item.ng) * dot(shadow.direction, item.ng) > F(0.0f);
    const HitState<L> hit = wave.hits.gather<L>(slots);
    const U boundary = gather_member<L>(scene.geometry.shapes, &ShapeRow::boundary, hit.shape);
    const BoundaryCrossing<L> at{boundary, hit.instance, path_times<L>(scene, wave, slots)};
    out.flags = select(through, medium_behind<L>(scene, at, item.ng, shadow.direction, out.flags), out.flags);
  }
  out.flags = (out.flags & U(~kShadowFlags)) | end.flags;
  wave.transmittances.compress<L>(wave.shadow_count, out, kept);
}

template <class L>
SHEAF_INLINE void push_shadow_ray(const SceneView& scene, Wave& wave, const Slot* slots, int count,
                                  const VertexItem<L>& item, const ShadowEnd<L>& end, Spectrum<L> contribution,
                                  bool in_medium, Mask<L> single = Mask<L>(false)) {
  const Vec3<L> target = end.target;
  ShadowItem<L> out;
  out.origin = offset_origin<L>(item.p, item.ng, item.offset, target - item.p);
  out.direction = target - out.origin;
  out.contribution = contribution;
  out.slot = make_lanes<Uint<L>>([slots](int lane) SHEAF_LAMBDA_INLINE { return slots[lane]; });
  out.light = end.light;
  const auto kept =
      is_finite(out.direction) & is_finite(total(contribution)) & !is_black(contribution) & L::first(count);
  if (scene.needs_transmittance) push_transmittance<L>(scene, wave, slots, item, out, end, in_medium, single, kept);
  wave.shadow_count += wave.shadows.compress<L>(wave.shadow_count, out, kept);
}

}  // namespace sheaf
