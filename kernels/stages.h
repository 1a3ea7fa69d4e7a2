// The stages of the path pass. Each is a free function in a file of its own name, works on one wave, and knows no
// other stage; kernels/passes/ know the order. All are generic in the lane: Wide renders, Scalar is the path-by-path
// null hypothesis of the benchmarks.
//
//   stage             consumes              produces
//   camera_rays       free, the task        active
//   intersect         active                miss, emitter, composite, surface, finished
//   medium            medium                surface, composite (scattered), the rest as intersect
//   emission          miss, emitter         finished (misses), active (rays that pass a hidden light)
//   select_materials  composite             surface, active (rays that pass a hole), finished
//   sort_surfaces     surface               sorted, runs
//   surface_inputs    runs                  items, closures
//   textures          items, textured       items, closures
//   light_candidates  items                 candidates
//   resample          candidates, closures  reservoirs, shadows
//   shadow            shadows               radiance
//   transmittance     shadows, transmittances  radiance; instead of shadow where has_transparency
//   scatter           items, closures       active, finished
//   debug_view        surface, miss         finished
//   accumulate        finished              free, the task's sample buffer
#pragma once

#include "kernels/wave.h"

namespace sheaf {

/// Starts camera paths in free slots until there are none or the task has no samples left. Reads the camera and the
/// filter; writes ray, throughput and radiance state.
template <class L> void camera_rays(const SceneView& scene, Wave& wave) noexcept;

/// Traces all active rays and sorts the paths by what they met. Reads ray state; writes hit state. Rays that are not
/// finite are dropped and counted.
template <class L> void intersect(const SceneView& scene, Wave& wave) noexcept;

/// Samples where paths scatter in media, or lets them pass on to what they hit; adds what media emit. Reads ray and hit
/// state; writes throughput and probabilities, and the hit where a path scatters.
template <class L> void medium(const SceneView& scene, Wave& wave) noexcept;

/// Adds the light that rays ran into, weighted against light sampling (multiple importance sampling, power heuristic:
/// Veach 1997, section 9.2.2). Reads ray, hit and throughput state; adds to radiance.
template <class L> void emission(const SceneView& scene, Wave& wave) noexcept;

/// Chooses among the parts of composite materials. Reads ray state; writes the hit's material, or the ray's origin
/// where light passes.
template <class L> void select_materials(const SceneView& scene, Wave& wave) noexcept;

/// Sorts surface hits by closure kind and material. Reads hit state.
template <class L> void sort_surfaces(const SceneView& scene, Wave& wave) noexcept;

/// Works out positions, frames and closure parameters. Reads ray and hit state.
template <class L> void surface_inputs(const SceneView& scene, Wave& wave) noexcept;

/// Looks up textures: replaces closure parameters, and turns shading normals by maps.
template <class L> void textures(const SceneView& scene, Wave& wave) noexcept;

/// Samples one light per vertex: candidate Wave::candidate. Reads throughput.
template <class L> void light_candidates(const SceneView& scene, Wave& wave) noexcept;

/// Weighs that candidate against those before it and keeps one of them; after the last one pushes a shadow ray with
/// what was kept. Reads throughput.
template <class L> void resample(const SceneView& scene, Wave& wave) noexcept;

/// Traces shadow rays and pays what is unoccluded into the paths' radiance.
template <class L> void shadow(const SceneView& scene, Wave& wave) noexcept;

/// As shadow(), where light passes media and surfaces on its way, weakened.
template <class L> void transmittance(const SceneView& scene, Wave& wave) noexcept;

/// Samples the BSDF, plays roulette and writes the next ray. Reads and writes throughput; writes ray state.
template <class L> void scatter(const SceneView& scene, Wave& wave) noexcept;

/// Pictures for debugging instead of light: normals or depth of the first surface, by IntegratorKind.
template <class L> void debug_view(const SceneView& scene, Wave& wave) noexcept;

/// Moves finished paths' radiance to the task's sample buffer and frees their slots. Samples that are not finite or
/// negative are dropped and counted.
template <class L> void accumulate(const SceneView& scene, Wave& wave) noexcept;

/// Whether direct light is sampled at all.
inline bool samples_lights(const SceneView& scene) {
  return scene.light_count > 0 && scene.integrator.strategy != LightStrategy::kBsdfOnly;
}

/// Instantiates a stage for both lanes.
#define SHEAF_INSTANTIATE_STAGE(stage)                                \
  template void stage<Wide>(const SceneView&, Wave&) noexcept;        \
  template void stage<Scalar>(const SceneView&, Wave&) noexcept

}  // namespace sheaf
