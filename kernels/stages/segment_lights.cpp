// Stage: segment lights. Next-event estimation along rays in media: chooses a light for the segment of the
// ray in the medium, a point on the segment by equiangular sampling, and then a point on the light as seen from there
// (Kulla and Fajardo 2012). It finds the glow around lamps in thin media, where few paths scatter. MIS combines it with
// sampling of distances (kernels/stages/segment_mis.h).
//
// The shadow ray's r_u and r_l are those of a path that has scattered at the point by chance, so that the transmittance
// stage computes the same weight against sampling of directions.
#include "kernels/lights/light_sample.h"
#include "kernels/media/phase_value.h"
#include "kernels/stages/medium_ray.h"
#include "kernels/stages/push_shadow_ray.h"
#include "kernels/stages/segment_mis.h"
#include "kernels/stages/segment_tracking.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

namespace {

/// Connections survive Russian roulette with probability kKeptWeight times their MIS weight: the others add little.
constexpr float kKeptWeight = 2;

/// Rays in the same medium.
template <class L> struct SegmentTile {
  const Slot* slots;
  Mask<L> lanes;
  RayState<L> ray;
  PathState<L> path;
  Spectrum<L> lambda;  ///< wavelengths; empty in RGB mode
};

/// Distances at which the rays of a tile end.
template <class L> SHEAF_INLINE Float<L> ends_of(const SceneView& scene, const Wave& wave, const SegmentTile<L>& tile) {
  const HitState<L> hit = wave.hits.gather<L>(tile.slots);
  const auto misses = hit.shape == Uint<L>(kNone);
  return select(misses, min(hit.t, medium_end<L>(scene, tile.ray.origin, tile.ray.direction)), hit.t);
}

/// The medium at a point of a segment.
template <class L> struct SegmentPoint {
  Spectrum<L> passed;         ///< transmittance from the start of the segment; of a grid: at the mean extinction
  typename L::Float density;  ///< 1 in homogeneous media
};

/// At the points `p`, which are `t` meters along their segments. `uniform`: the medium at density 1.
template <class L>
SHEAF_INLINE SegmentPoint<L> segment_point(const SceneView& scene, const MediumRow& medium,
                                           const UniformMedium<L>& uniform, typename L::Float t, Vec3<L> p,
                                           Mask<L> lanes) {
  using F = Float<L>;
  if ((medium.flags & kMediumHomogeneous) != 0) return {uniform.transmittance(t), F(1.0f)};
  const BrickGridRow& grid = scene.media.grids.rows[medium.density != kNone ? medium.density : medium.first_grid];
  const Vec3<L> at = to_grid<L>(grid, select<L>(lanes, p, Vec3<L>{}));
  return {Spectrum<L>(exp(F(medium.mean_extinction) * -t)), max(lookup_density<L>(grid, at), F(0.0f))};
}

/// Connects the rays of a tile, which are in the medium of row `row`.
template <class L, ColorMode kMode>
void connect_tile(const StageContext& context, Wave& wave, const SegmentTile<L>& tile, std::uint32_t row) {
  using F = Float<L>;
  using U = Uint<L>;
  const SceneView& scene = context.scene;
  const MediumRow& medium = scene.media.rows[row];
  const RayState<L>& ray = tile.ray;
  const UniformMedium<L> uniform = make_uniform_medium<L>(context, row, ray.flags, tile.lambda);
  const ConnectedPart<L> part =
      connected_part<L>(scene, medium, ray.origin, ray.direction, ends_of<L>(scene, wave, tile), uniform.sigma_t);
  auto lanes = tile.lanes & (part.length > F(0.0f));
  if (!any(lanes)) return;
  const Vec3<L> origin = ray.origin + ray.direction * part.start;
  // Choose a light, and a point on the segment
  const U dimension = tile.path.dimension() | U(kSegmentDimension);
  const Random4<L> u = draw<L>(context.sampler, tile.path.pixel, tile.path.sample, dimension, SampleBlock::kLight);
  const SegmentLight<L> chosen = choose_segment_light<L>(scene.lights.tree, {origin, ray.direction, part.length}, u.x);
  lanes = lanes & (chosen.probability > F(0.0f));
  if (!any(lanes)) return;
  const Random4<L> more =
      draw<L>(context.sampler, tile.path.pixel, tile.path.sample, dimension, SampleBlock::kResample, {});
  const F t = chosen.density.sample(more.x);
  const F pdf = chosen.probability * chosen.density.pdf(t);
  // Sample a point on the light
  const LightSampleContext<L> at{origin + ray.direction * t, {}};
  const LightSample<L> light = sample_light<L, kMode>(scene, at, {chosen.light, F(1.0f)}, u,
                                                      path_times<L>(scene, wave, tile.slots), tile.lambda);
  lanes = lanes & (pdf > F(0.0f)) & light.valid & (light.pdf_solid_angle > F(0.0f)) & (light.target_medium == U(kNone));
  if (!any(lanes)) return;
  // Weight the sample against sampling of distances
  const F point_pdf = choice_probability<L>(scene, at, chosen.light);
  const Spectrum<L> r_u = wave.rescaled_pdfs.gather<L>(tile.slots).r_u;
  const SegmentPoint<L> point = segment_point<L>(scene, medium, uniform, t, at.p, lanes);
  const Spectrum<L> scattered = r_u * uniform.pdf_ratio(uniform.sigma_t * point.passed) * point.density;
  const F pdf_ratio = lane_mean<L>(scene.color, r_u) / max(lane_mean<L>(scene.color, scattered), F(1e-37f));
  const F rho = min(pdf * pdf_ratio / max(point_pdf, F(1e-30f)), F(1e15f)), scale = sqrt(fma(rho, rho, F(1.0f)));
  const F weight = sqr(rho / scale);
  const F kept = min(weight * F(kKeptWeight), F(1.0f));
  lanes = lanes & (more.y < kept) & (point.density > F(0.0f));
  // Compute the contribution, in a grid without the attenuation up to the point
  const Frame<L> frame = Frame<L>::from_normal(-ray.direction);
  const F phase = phase_value<L>(scene, medium.phase, frame.to_local(light.direction));
  const F factor = select(lanes, weight * phase * point.density / (kept * pdf * light.pdf_solid_angle), F(0.0f));
  Spectrum<L> contribution = tile.path.beta * uniform.sigma_s * light.radiance * factor;
  if ((medium.flags & kMediumHomogeneous) != 0) contribution = contribution * point.passed;
  // Push the shadow rays
  const auto only_light = light.delta | Mask<L>(context.integrator.strategy == LightStrategy::kLightOnly);
  ShadowItem<L> shadow;
  shadow.origin = at.p;
  shadow.direction = light.target - at.p;
  shadow.contribution = contribution;
  shadow.slot = make_lanes<U>([&](int lane) SHEAF_LAMBDA_INLINE { return tile.slots[lane]; });
  shadow.light = chosen.light;
  TransmittanceItem<L> state;
  state.r_u = state.r_l = scattered * pdf_ratio;
  state.pdf_ratio =
      select(only_light, F(0.0f),
             phase / (light.pdf_solid_angle * point_pdf * scale * F(static_cast<float>(context.candidates))));
  state.target_medium = U(kNone);
  state.flags = (ray.flags & U(~kShadowFlags)) | U(kShadowFromSegment);
  const auto pushed = lanes & is_finite(shadow.direction) & is_finite(total(contribution)) & !is_black<L>(contribution);
  wave.transmittances.compress<L>(wave.shadow_count, state, pushed);
  wave.shadow_count += wave.shadows.compress<L>(wave.shadow_count, shadow, pushed);
}

/// Connects the rays of a tile, one medium at a time.
/// Returns whether one of the media has a grid.
template <class L, ColorMode kMode>
bool connect_rays(const StageContext& context, Wave& wave, const Slot* slots, int count) {
  using U = Uint<L>;
  SegmentTile<L> tile{slots, Mask<L>(false), wave.rays.gather<L>(slots), wave.paths.gather<L>(slots),
                      shading_wavelengths<L, kMode>(wave, slots)};
  const U row = (tile.ray.flags >> kRayMediumShift) - U(1u);
  const auto scatters =
      ((tile.ray.flags & U(kRayLast)) == U(0u)) & (tile.path.depth() < U(kConnectedDepth)) & L::first(count);
  bool has_grid = false;
  for_each_medium<L>(row, scatters, [&](std::uint32_t medium, Mask<L> lanes) {
    const MediumRow& of = context.scene.media.rows[medium];
    if (!sheaf::connects_segments(of)) return;
    tile.lanes = lanes;
    connect_tile<L, kMode>(context, wave, tile, medium);
    has_grid = has_grid || (of.flags & kMediumHomogeneous) == 0;
  });
  return has_grid;
}

}  // namespace

template <class L> void segment_lights(const StageContext& context, Wave& wave) noexcept {
  const int paths = wave.medium.size();
  if (paths == 0) return;
  StageTimer timer(wave.stats, stage_named<L>("segment_lights"));
  timer.count(paths, L::width);
  wave.medium.pad();
  const int first = wave.shadow_count;
  bool has_grid = false;
  with_color_mode(context.scene, [&]<ColorMode kMode>() {
    for_tiles<L>(paths, [&](int i, int count) {
      has_grid |= connect_rays<L, kMode>(context, wave, wave.medium.data() + i, count);
    });
  });
  if (has_grid) SegmentTracking<L>(context, wave, first).run();
}

SHEAF_INSTANTIATE_STAGE(segment_lights);

}  // namespace sheaf
