// Stage: emission. Adds the radiance of the environment to rays that left the scene, and of area lights to rays that
// hit them: beta L_e w_b, with the MIS weight of BSDF sampling against M light candidates of pdf p each,
//     w_b = b^2 / (b^2 + (M p)^2)
// for solid-angle pdf b of BSDF sampling (kernels/stages/resample.cpp).
#include "core/soa/lane_array.h"
#include "kernels/caustics/chain_light.h"
#include "kernels/lights/light_sample.h"
#include "kernels/lights/light_weight.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/stages/candidate_moments.h"
#include "kernels/stages/chain_state.h"
#include "kernels/stages/continue_ray.h"
#include "kernels/stages/light_sample_context.h"
#include "kernels/stages/segment_mis.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/add_radiance.h"
#include "kernels/wave/lane_mean.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

namespace {

/// MIS weight of emission found by BSDF sampling, against that many light candidates. `scatter_pdf`: solid-angle pdf,
/// 1/sr; 0 (delta lobe or camera ray) gives weight 1.
template <class L>
SHEAF_INLINE Float<L> emission_weight(LightStrategy strategy, int candidates, Float<L> scatter_pdf,
                                      Float<L> light_pdf) {
  using F = Float<L>;
  const auto specular = scatter_pdf == F(0.0f);
  if (strategy == LightStrategy::kBsdfOnly) return F(1.0f);
  if (strategy == LightStrategy::kLightOnly) return select(specular, F(1.0f), F(0.0f));
  const F mis_weight = bsdf_weight(light_pdf, select(specular, F(1.0f), scatter_pdf), candidates);
  return select(specular, F(1.0f), mis_weight);
}

/// Adds emission to paths, weighted by MIS. `emitted`: times the throughput. `divisor`: see LightPath.
template <class L>
SHEAF_INLINE void add_emission(const StageContext& context, Wave& wave, const Slot* slots, std::uint32_t lanes,
                               const Spectrum<L>& emitted, Float<L> divisor, Float<L> scatter_pdf, Float<L> light_pdf,
                               typename L::Uint light) {
  const LightStrategy strategy = context.integrator.strategy;
  const Float<L> weight = emission_weight<L>(strategy, context.candidates, scatter_pdf, light_pdf) / divisor;
  add_radiance<L>(wave, slots, lanes, emitted * weight, light);
  if (!context.compares_candidates()) [[likely]]
    return;
  const auto found = [&](int i) {
    return total(emitted) * (emission_weight<L>(strategy, kCandidateCounts[i], scatter_pdf, light_pdf) / divisor);
  };
  add_emission_moments<L>(wave, slots, lanes, {found(0), found(1), found(2), found(3)});
}

/// The previous vertex as light_candidates saw it, and the pdfs of the path since then.
template <class L> struct LightPath {
  LightSampleContext<L> receiver;
  typename L::Float distance_since_vertex;  ///< from the vertex to the ray's origin, m
  typename L::Float light_ratio;            ///< mean of r_l over mean of r_u
  typename L::Float divisor;                ///< mean of r_u
};

/// Reads RescaledPdfs in scenes with SceneView::needs_transmittance.
template <class L>
void follow_probabilities(const SceneView& scene, const Wave& wave, const Slot* slots, LightPath<L>& path) {
  const RescaledPdfs<L> r = wave.rescaled_pdfs.gather<L>(slots);
  path.divisor = lane_mean<L>(scene.color, r.r_u);
  path.light_ratio = lane_mean<L>(scene.color, r.r_l) / path.divisor;
  path.distance_since_vertex = gather_distance_since_vertex<L>(wave, slots);
}

template <class L>
SHEAF_INLINE LightPath<L> light_path(const SceneView& scene, const Wave& wave, const Slot* slots,
                                     const RayState<L>& ray, const RadianceState<L>& radiance) {
  using F = Float<L>;
  LightPath<L> path{{}, F(0.0f), F(1.0f), F(1.0f)};
  if (scene.needs_transmittance) follow_probabilities<L>(scene, wave, slots, path);
  path.receiver = light_sample_context<L>(ray, radiance.normal, path.distance_since_vertex);
  return path;
}

/// Whether camera rays that leave the scene see something.
bool has_surroundings(const SceneView& scene) {
  if (scene.lights.has_black_environment) return true;
  for (std::uint32_t light = scene.lights.bounded_count; light < scene.lights.count; ++light)
    if (surrounds_scene(scene, light)) return true;
  return false;
}

/// Adds environment maps and suns.
template <class L, ColorMode kMode>
SHEAF_INLINE void environment_tile(const StageContext& context, Wave& wave, const Slot* slots, int count) {
  using F = Float<L>;
  using U = Uint<L>;
  const RadianceState<L> radiance = wave.radiance.gather<L>(slots);
  const RayState<L> ray = wave.rays.gather<L>(slots);
  const auto from_camera = (ray.flags & U(kRayFromCamera)) != U(0u);
  const SceneView& scene = context.scene;
  // Mark camera paths that hit nothing as transparent
  const bool visible = has_surroundings(scene);
  const auto displayed = Mask<L>(visible) & !(from_camera & Mask<L>(context.integrator.hide_emitters));
  const std::uint32_t transparent = mask_bits(from_camera & !displayed & L::first(count));
  for_each_lane(transparent, [&](int lane) SHEAF_LAMBDA_INLINE { mark_transparent(wave, slots[lane]); });
  if (!visible) return;
  // Add each light, weighted by MIS
  const PathState<L> path = wave.paths.gather<L>(slots);
  const LightPath<L> from = light_path<L>(scene, wave, slots, ray, radiance);
  const Spectrum<L> lambda = shading_wavelengths<L, kMode>(wave, slots);
  const F time = path_times<L>(scene, wave, slots);
  const auto counts = displayed & !is_caustic<L>(context, ray.flags, radiance.scatter_pdf) & L::first(count);
  for (std::uint32_t light = scene.lights.bounded_count; light < scene.lights.count; ++light) {
    if (!surrounds_scene(scene, light)) continue;
    const EnvmapValue<L> arriving = environment_value<L, kMode>(scene, light, ray.direction, time, lambda);
    const F probability = choice_probability<L>(scene, from.receiver, U(light));
    add_emission<L>(context, wave, slots, mask_bits(counts), path.beta * arriving.radiance, from.divisor,
                    radiance.scatter_pdf, probability * arriving.pdf_solid_angle * from.light_ratio, U(light));
  }
}

/// The weight of BSDF sampling for a path that has hit an area light with normal `ng` through a connected chain.
/// Follows the chain again, with the derivatives of its rays.
float chain_weight(const StageContext& context, const Wave& wave, Slot slot, Vec3f ng) {
  const SceneView& scene = context.scene;
  const ChainStartState<Scalar>& start = wave.chain_starts.row(slot);
  const RayState<Scalar>& ray = wave.rays.row(slot);
  const HitState<Scalar>& hit = wave.hits.row(slot);
  ChainTracer tracer(scene, context.caustic_casters());
  if (scene.color == ColorMode::kSpectral) tracer.set_wavelengths(path_wavelengths<Scalar>(wave, &slot));
  const float time = path_time(scene, wave, slot);
  tracer.set_time(time);
  DifferentialRay last = start_ray(start.origin, start.direction);
  const auto length = static_cast<int>(chain_state<Scalar>(ray.flags)) - 1;
  // Rounding may lose a chain at an edge. Walks can find it neither.
  if (!tracer.follow({length, start.refracted}, last)) return 1;
  return chain_bsdf_weight(scene, context.caustic_casters(),
                           {ray.origin, ray.direction, hit.t, ng, hit.light, hit.primitive, time},
                           solid_angle_ratio_at(last, hit.t), start.cosine);
}

/// chain_weight() for the paths of `lanes`, 1 for others.
template <class L>
[[gnu::noinline]] Float<L> chain_weights(const StageContext& context, const Wave& wave, const Slot* slots,
                                         std::uint32_t lanes, Vec3<L> ng) {
  const LaneRows<L, Vec3> normals(ng);
  LaneArray<Float<L>> weights(Float<L>(1.0f));
  for_each_lane(lanes, [&](int lane) { weights[lane] = chain_weight(context, wave, slots[lane], normals[lane]); });
  return weights.load();
}

/// Adds area lights. `kTextured`: some light may have a texture.
template <class L, ColorMode kMode, bool kTextured>
SHEAF_INLINE void area_light_tile(const StageContext& context, Wave& wave, const Slot* slots, int count) {
  using F = Float<L>;
  using U = Uint<L>;
  const RayState<L> ray = wave.rays.gather<L>(slots);
  const HitState<L> hit = wave.hits.gather<L>(slots);
  const PathState<L> path = wave.paths.gather<L>(slots);
  const RadianceState<L> radiance = wave.radiance.gather<L>(slots);
  const ShapeRecord<L> shape = gather_rows<L>(context.scene.geometry.shapes, hit.shape);
  const F time = path_times<L>(context.scene, wave, slots);
  const auto y = surface_point<L, kTextured>(context.scene, shape, hit.primitive, hit.u, hit.v,
                                             ray.origin + ray.direction * hit.t, hit.instance, time);
  // Evaluate the emitted radiance
  LightRecord<L> light = load_lights<L>(context.scene, hit.light);
  const Spectrum<L> lambda = shading_wavelengths<L, kMode>(wave, slots);
  if constexpr (kMode == ColorMode::kSpectral) light.radiance = light_spectra<L>(context.scene, hit.light, lambda);
  const TextureQuery<L> query{y.uv, hit.shape, hit.primitive, hit.u, hit.v};
  if constexpr (kTextured)
    light.radiance =
        light.radiance * light_textures<L, kMode>(context.scene, light.texture, L::first(count), query, lambda);
  if (context.scene.lights.coats != nullptr)
    light.radiance =
        light.radiance * coat_transmittance<L>(context.scene, light, L::first(count), dot(ray.direction, y.ng), query);

  // Find the lanes that see the light
  const auto from_camera = (ray.flags & U(kRayFromCamera)) != U(0u);
  const auto hidden = from_camera & Mask<L>(context.integrator.hide_emitters);
  const auto faces = (dot(ray.direction, y.ng) < F(0.0f)) | light.is_two_sided();
  const auto lit =
      faces & !light.is_along_normal() & (!hidden) & !is_caustic<L>(context, ray.flags, radiance.scatter_pdf);
  // Add the radiance, weighted by MIS
  const LightPath<L> from = light_path<L>(context.scene, wave, slots, ray, radiance);
  const F choice = choice_probability<L>(context.scene, from.receiver, hit.light);
  F pdf = choice * light_pdf_solid_angle<L>(context.scene, hit.light, light, Mask<L>(true),
                                            {from.receiver.p, ray.direction, hit.t + from.distance_since_vertex, y.ng,
                                             hit.primitive, from.receiver.n},
                                            time);
  if (connects_segments(context))
    pdf = pdf * segment_pdf_scale<L>(context.scene, wave, slots, from.receiver.p, hit.light, choice,
                                     lit & ((ray.flags & U(kRayFromMedium)) != U(0u)) & L::first(count));
  Spectrum<L> emitted = path.beta * light.radiance;
  const std::uint32_t chained = mask_bits(lit & is_connected_chain<L>(context, ray.flags) & L::first(count));
  if (chained != 0) emitted = emitted * chain_weights<L>(context, wave, slots, chained, y.ng);
  add_emission<L>(context, wave, slots, mask_bits(lit & L::first(count)), emitted, from.divisor, radiance.scatter_pdf,
                  pdf * from.light_ratio, hit.light);
  // Continue camera rays behind hidden lights
  continue_rays<L>(context.scene, wave, slots, count, hidden, y, shape.boundary, hit, ray, path);
}

}  // namespace

template <class L> void emission(const StageContext& context, Wave& wave) noexcept {
  const int misses = wave.miss.size(), lights = wave.emitter.size();
  if (misses + lights == 0) return;
  StageTimer timer(wave.stats, stage_named<L>("emission"));
  timer.count(misses, L::width);
  timer.count(lights, L::width);
  wave.miss.pad();
  wave.emitter.pad();
  with_color_mode(context.scene, [&]<ColorMode kMode>() {
    for_tiles<L>(misses,
                 [&](int i, int count) { environment_tile<L, kMode>(context, wave, wave.miss.data() + i, count); });
    for_tiles<L>(lights, [&](int i, int count) {
      const Slot* slots = wave.emitter.data() + i;
      if (context.scene.lights.has_textured_area_lights) {
        area_light_tile<L, kMode, true>(context, wave, slots, count);
      } else {
        area_light_tile<L, kMode, false>(context, wave, slots, count);
      }
    });
  });
  for (int i = 0; i < misses; ++i) wave.finished.push(wave.miss[i]);
  wave.miss.clear();
  wave.emitter.clear();
}

SHEAF_INSTANTIATE_STAGE(emission);

}  // namespace sheaf
