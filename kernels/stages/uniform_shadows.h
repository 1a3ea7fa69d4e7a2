// Part of the transmittance stage: shadow rays through vacuum and homogeneous media, a tile at a time, to their ends,
// to null interfaces, or to surfaces that block light.
#pragma once

#include "kernels/stages/continue_ray.h"
#include "kernels/stages/medium_ray.h"

namespace sheaf {

/// Shadow rays of a tile, and what they hit.
template <class L> struct ShadowTile {
  ShadowItem<L> item;
  TransmittanceItem<L> state;
  typename L::Uint shape;      ///< kNone: nothing is hit
  typename L::Float t;         ///< of the hit, or 1
  typename L::Mask can_end;    ///< nothing is hit before the target
  typename L::Mask interface;  ///< a null interface is hit
  typename L::Mask blocked;    ///< a surface that blocks light is hit
};

/// What happens to the rays of a tile, as bits of lanes.
struct ShadowEvents {
  std::uint32_t ended = 0;     ///< they reach their targets
  std::uint32_t crossing = 0;  ///< they have crossed null interfaces
  std::uint32_t others = 0;    ///< left to the caller
  std::uint32_t all() const { return ended | crossing | others; }
};

/// The rays from `i` on, which were traced in lanes from `at` on. What they hit is left to the caller for photons,
/// whose rays pass hidden lights, and in scenes with thin dielectrics that rays pass.
template <class L>
SHEAF_INLINE ShadowTile<L> load_shadow_tile(const StageContext& context, const Wave& wave, const RayPacket& packet,
                                            int at, int i) {
  using F = Float<L>;
  using U = Uint<L>;
  const SceneView& scene = context.scene;
  ShadowTile<L> tile;
  tile.item = wave.shadows.load<L>(i);
  tile.state = wave.transmittances.load<L>(i);
  load(packet.shape + at, tile.shape);
  const auto hits = tile.shape != U(kNone);
  tile.can_end = !hits & (tile.state.target_medium == U(kNone)) &
                 ((tile.state.flags & U(kShadowFlags & ~kShadowFromSegment)) == U(0u));
  tile.interface = tile.blocked = Mask<L>(false);
  tile.t = F(1.0f);
  if (!any(hits) || context.starts_at_lights() || scene.shadow_rays_pass_thin_dielectrics) return tile;
  F t;
  Vec3<L> normal;
  load(packet.t_far + at, t);
  load(packet.normal_x + at, normal.x);
  load(packet.normal_y + at, normal.y);
  load(packet.normal_z + at, normal.z);
  tile.t = select(hits, t, F(1.0f));
  const MaterialRow* const rows = scene.materials.rows;
  const U front = gather_member<L>(scene.geometry.shapes, &ShapeRow::material, select(hits, tile.shape, U(0u)));
  const auto behind = dot(normal, tile.item.direction) > F(0.0f);
  const U side = select(behind, gather_member<L>(rows, &MaterialRow::back, front), front);
  const auto composite = (gather_member<L>(rows, &MaterialRow::flags, side) & U(kComposite)) != U(0u);
  const U nothing(MaterialRow::kNothing);
  tile.blocked = hits & !composite;
  tile.interface = hits & composite & (gather_element<L>(rows, &MaterialRow::choice, 0, side) == nothing) &
                   (gather_element<L>(rows, &MaterialRow::choice, 1, side) == nothing);
  return tile;
}

/// Attenuates the light of the rays `lanes` up to their ends or hits, in vacuum or in homogeneous media. Returns those
/// lanes where this was possible.
template <class L>
SHEAF_INLINE Mask<L> attenuate_uniform(const StageContext& context, const Wave& wave, Mask<L> lanes,
                                       ShadowTile<L>& tile) {
  using F = Float<L>;
  using U = Uint<L>;
  const SceneView& scene = context.scene;
  const U row = (tile.state.flags >> kRayMediumShift) - U(1u);
  const auto inside = lanes & (row != U(kNone));
  auto passed = lanes & (row == U(kNone));
  if (!any(inside)) return passed;
  const LaneArray<U> of(tile.item.slot);
  Slot slots[L::width];
  for (int lane = 0; lane < L::width; ++lane) slots[lane] = static_cast<Slot>(of[lane]);
  const F distance = length(tile.item.direction);
  const Vec3<L> direction = tile.item.direction * (F(1.0f) / max(distance, F(1e-30f)));
  const F end = select(tile.can_end, medium_end<L>(scene, tile.item.origin, direction), F(kInfinity));
  const F stretch = min(min(distance * tile.t, end), F(kLongestStretch));
  const Spectrum<L> lambda = tile_wavelengths<L>(scene, wave, slots);
  for_each_medium<L>(row, inside, [&](std::uint32_t medium, Mask<L> in_medium) {
    if (!is_uniform(scene.media.rows[medium])) return;
    const UniformMedium<L> uniform = make_uniform_medium<L>(context, medium, tile.state.flags, lambda);
    const Spectrum<L> transmittance = uniform.transmittance(select(in_medium, stretch, F(0.0f)));
    tile.item.contribution = tile.item.contribution * transmittance;
    if (uniform.scatters) tile.state.r_u = tile.state.r_u * uniform.pdf_ratio(transmittance);
    passed = passed | in_medium;
  });
  return passed;
}

/// Moves the origins of rays behind the interfaces that they have hit.
template <class L>
SHEAF_INLINE void cross_interfaces(const SceneView& scene, const RayPacket& packet, int at, ShadowTile<L>& tile) {
  using F = Float<L>;
  using U = Uint<L>;
  const auto lanes = tile.interface;
  U primitive, instance;
  F u, v, time(0.0f);
  load(packet.primitive + at, primitive);
  load(packet.instance + at, instance);
  load(packet.u + at, u);
  load(packet.v + at, v);
  if (scene.motion.any()) load(packet.time + at, time);
  primitive = select(lanes, primitive, U(0u));
  instance = select(lanes, instance, U(kNone));
  const ShapeRecord<L> shape = gather_rows<L>(scene.geometry.shapes, select(lanes, tile.shape, U(0u)));
  const Vec3<L> d = tile.item.direction, target = tile.item.origin + d;
  const SurfacePoint<L> y =
      surface_point<L>(scene, shape, primitive, u, v, tile.item.origin + d * tile.t, instance, time);
  const RayBehind<L> behind = ray_behind<L>(scene, y, {shape.boundary, instance, time}, d, tile.state.flags);
  tile.item.origin = select<L>(lanes, behind.origin, tile.item.origin);
  tile.item.direction = select<L>(lanes, target - behind.origin, d);
  tile.state.flags = select(lanes, behind.flags, tile.state.flags);
}

/// Moves those of the first `count` rays of the tile that end, and those that cross interfaces; `interface` is set for
/// the latter only. The others are unchanged.
template <class L>
SHEAF_INLINE ShadowEvents move_uniform(const StageContext& context, const Wave& wave, const RayPacket& packet, int at,
                                       int count, ShadowTile<L>& tile) {
  const auto all = L::first(count);
  const auto passed = attenuate_uniform<L>(context, wave, (tile.can_end | tile.interface) & all, tile);
  tile.interface = passed & tile.interface;
  if (any(tile.interface)) cross_interfaces<L>(context.scene, packet, at, tile);
  return {mask_bits(passed & tile.can_end), mask_bits(tile.interface), mask_bits(all & !passed & !tile.blocked)};
}

}  // namespace sheaf
