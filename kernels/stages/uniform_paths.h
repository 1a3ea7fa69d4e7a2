// Part of the medium stage: paths in homogeneous media, a tile at a time.
#pragma once

#include "kernels/stages/medium_ray.h"
#include "kernels/stages/route_hits.h"
#include "kernels/stages/segment_mis.h"

namespace sheaf {

/// The paths of a tile in homogeneous media.
template <class L> struct UniformTile {
  const Slot* slots;
  RayState<L> ray;
  HitState<L> hit;
  PathState<L> path;
  RescaledPdfs<L> pdfs;
  typename L::Float length;  ///< up to the surface hit or the end of the medium, m
  // Results
  typename L::Float t;     ///< distance at which paths scatter, m; `length` if they pass
  typename L::Uint phase;  ///< material of the phase function
  SegmentState<L> segment;
};

/// Lanes of paths in media that track_uniform_tile() can track.
template <class L> SHEAF_INLINE Mask<L> uniform_lanes(const StageContext& context, typename L::Uint medium, int count) {
  auto lanes = Mask<L>(false);
  // Photons leave beams, one at a time.
  if (context.starts_at_lights()) return lanes;
  for_each_medium<L>(medium, L::first(count), [&](std::uint32_t row, Mask<L> inside) {
    const MediumRow& of = context.scene.media.rows[row];
    if (is_uniform(of) && (of.flags & kMediumEmits) == 0) lanes = lanes | inside;
  });
  return lanes;
}

/// Samples the distances of the paths `lanes`, which are in the medium `row`. `lambda`: see make_uniform_medium(). `u`:
/// uniform in [0, 1).
template <class L>
SHEAF_INLINE void track_uniform_lanes(const StageContext& context, std::uint32_t row, Mask<L> lanes,
                                      const Spectrum<L>& lambda, Float<L> u, UniformTile<L>& tile) {
  using F = Float<L>;
  using U = Uint<L>;
  const SceneView& scene = context.scene;
  const MediumRow& medium = scene.media.rows[row];
  const UniformMedium<L> uniform = make_uniform_medium<L>(context, row, tile.ray.flags, lambda);
  TileWeights<L> weights{tile.path.beta, tile.pdfs.r_u, tile.pdfs.r_l};
  const F t = track_uniform<L>(uniform, tile.length, u, weights);
  if (connects_segments(medium)) {
    const ConnectedPart<L> part =
        connected_part<L>(scene, medium, tile.ray.origin, tile.ray.direction, tile.length, uniform.sigma_t);
    const F sigma = uniform.of_hero(uniform.sigma_t);
    const SegmentState<L> segment =
        scattered_segment<L>(part, tile.ray.origin, tile.ray.direction, t, sigma, sigma,
                             lane_mean<L>(scene.color, tile.pdfs.r_u), lane_mean<L>(scene.color, weights.r_u));
    const auto connected = ((tile.ray.flags & U(kRayLast)) == U(0u)) & (tile.path.depth() < U(kConnectedDepth));
    tile.segment.origin = select<L>(lanes, segment.origin, tile.segment.origin);
    tile.segment.length = select(lanes, segment.length, tile.segment.length);
    tile.segment.pdf_ratio = select(lanes & connected, segment.pdf_ratio, tile.segment.pdf_ratio);
  }
  weights.rescale();
  tile.path.beta = select<L>(lanes, weights.beta, tile.path.beta);
  tile.pdfs.r_u = select<L>(lanes, weights.r_u, tile.pdfs.r_u);
  tile.pdfs.r_l = select<L>(lanes, weights.r_l, tile.pdfs.r_l);
  tile.t = select(lanes, t, tile.t);
  tile.phase = select(lanes, U(medium.phase), tile.phase);
}

/// Routes the tracked paths of `lanes`: to the queues of their vertices in the medium or of their hits.
template <class L>
SHEAF_INLINE void route_uniform_tile(const StageContext& context, Wave& wave, std::uint32_t lanes, UniformTile<L>& tile,
                                     TrackingCounts& counts) {
  using U = Uint<L>;
  const std::uint32_t lost = mask_bits(is_black<L>(tile.path.beta)) & lanes;
  wave.finished.push(tile.slots, lost);
  const std::uint32_t left = lanes & ~lost;
  const std::uint32_t scattered = mask_bits(tile.t < tile.length) & left, passed = left & ~scattered;
  counts.real += static_cast<std::uint64_t>(std::popcount(scattered));
  wave.rescaled_pdfs.template scatter_lanes<L>(tile.slots, left, tile.pdfs);
  wave.paths.template scatter_lanes<L>(tile.slots, left, tile.path);
  if (passed != 0)
    route_hits<L>(context, wave, tile.slots, passed,
                  {tile.hit.shape != U(kNone), tile.hit.light, tile.hit.material, tile.ray.flags});
  if (scattered == 0) return;
  if (wave.needs.segments) wave.segments.template scatter_lanes<L>(tile.slots, scattered, tile.segment);
  HitState<L>& vertex = tile.hit;
  vertex.t = tile.t;
  vertex.material = tile.phase;
  vertex.light = U(kNone);
  vertex.shape = U(0u);  // any valid row: the selection among phase functions reads the surface
  vertex.instance = U(kNone);
  wave.hits.template scatter_lanes<L>(tile.slots, scattered, vertex);
  route_vertices<L>(context, wave, tile.slots, scattered, tile.phase, tile.ray.flags);
}

/// Tracks those of the first `count` paths in `slots` that are in homogeneous media without emission, and routes them.
/// Returns their lanes.
template <class L>
std::uint32_t track_uniform_tile(const StageContext& context, Wave& wave, const Slot* slots, int count,
                                 TrackingCounts& counts) {
  using F = Float<L>;
  using U = Uint<L>;
  const SceneView& scene = context.scene;
  const RayState<L> ray = wave.rays.gather<L>(slots);
  const U medium = (ray.flags >> kRayMediumShift) - U(1u);
  const auto lanes = uniform_lanes<L>(context, medium, count);
  if (!any(lanes)) return 0;
  const HitState<L> hit = wave.hits.gather<L>(slots);
  const PathState<L> path = wave.paths.gather<L>(slots);
  const F end = select(hit.shape == U(kNone), medium_end<L>(scene, ray.origin, ray.direction), F(kInfinity));
  const F length = min(min(hit.t, end), F(kLongestStretch));
  UniformTile<L> tile{slots,
                      ray,
                      hit,
                      path,
                      wave.rescaled_pdfs.gather<L>(slots),
                      length,
                      length,
                      U(0u),
                      {ray.origin, F(0.0f), ray.direction, F(0.0f)}};
  const F u = draw<L>(context.sampler, path.pixel, path.sample, path.dimension(), SampleBlock::kSelect, {}, kNumberY).y;
  const Spectrum<L> lambda = tile_wavelengths<L>(scene, wave, slots);
  for_each_medium<L>(medium, lanes, [&](std::uint32_t row, Mask<L> inside) {
    track_uniform_lanes<L>(context, row, inside, lambda, u, tile);
  });
  route_uniform_tile<L>(context, wave, mask_bits(lanes), tile, counts);
  return mask_bits(lanes);
}

}  // namespace sheaf
