// The stages of wavefront path tracing (Laine, Karras and Aila, "Megakernels Considered Harmful", 2013), and the
// schedule: the one list of them, in the order in which passes run them. Passes, statistics, tests and benchmarks
// derive from the list.
//
// Each stage is a free function in kernels/stages/<name>.cpp that works on one wave and calls no other stage. All
// stages are generic in the lane policy: Wide renders, and Scalar, path by path, is the baseline of the benchmarks.
#pragma once

#include "kernels/film/camera_task.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/wave/context.h"
#include "kernels/wave/wave.h"

#include <array>
#include <string_view>

namespace sheaf {

/// Starts camera paths in free slots while the task has samples left. Reads the camera and the pixel filter; writes
/// RayState, PathState and RadianceState.
template <class L> void camera_rays(const StageContext& context, Wave& wave) noexcept;

/// Traces all active rays and pushes the paths to queues by what the rays hit. Reads RayState; writes HitState. Rays
/// that are not finite are dropped and counted.
template <class L> void intersect(const StageContext& context, Wave& wave) noexcept;

/// Connects rays in homogeneous media to lights: pushes a shadow ray from a point of each ray. Reads HitState,
/// PathState and RescaledPdfs.
template <class L> void segment_lights(const StageContext& context, Wave& wave) noexcept;

/// Samples scattering in media, and adds the emission of media. Paths that do not scatter move on to the surface hit.
/// Reads RayState and HitState; writes throughput and RescaledPdfs, and HitState of paths that scatter.
template <class L> void medium(const StageContext& context, Wave& wave) noexcept;

/// Adds the emission of environments and area lights that rays have hit, with the MIS weight of BSDF sampling (power
/// heuristic: Veach 1997, section 9.2.2). Reads RayState, HitState and PathState; adds to radiance.
template <class L> void emission(const StageContext& context, Wave& wave) noexcept;

/// Selects one part of each composite material. Reads RayState; writes the material of HitState, or the ray's origin if
/// the ray passes through.
template <class L> void select_materials(const StageContext& context, Wave& wave) noexcept;

/// Computes debug images by IntegratorKind: normals or depth of the first surface, or one shadow ray from it.
template <class L> void debug_view(const StageContext& context, Wave& wave) noexcept;

/// Sorts surface hits by closure kind and material. Reads HitState.
template <class L> void sort_surfaces(const StageContext& context, Wave& wave) noexcept;

/// Computes positions, shading frames and closure parameters. Reads RayState and HitState.
template <class L> void surface_inputs(const StageContext& context, Wave& wave) noexcept;

/// Evaluates textures: replaces closure parameters and applies normal and bump maps.
template <class L> void textures(const StageContext& context, Wave& wave) noexcept;

/// Writes the AOVs of the first surface of camera paths into the task's samples. Reads RayState, HitState and
/// RadianceState.
template <class L> void aovs(const StageContext& context, Wave& wave) noexcept;

/// Looks up the guide cell of each vertex, for light sampling and scattering. Reads RayState.
template <class L> void guide(const StageContext& context, Wave& wave) noexcept;

/// Samples one light per vertex. `candidate`: index of the sample, less than IntegratorSettings::candidates. Reads
/// PathState.
template <class L> void light_candidates(const StageContext& context, Wave& wave, int candidate) noexcept;

/// Adds that candidate to the vertex's reservoir (resampled importance sampling). After the last candidate it pushes a
/// shadow ray for the one that was kept. Reads PathState.
template <class L> void resample(const StageContext& context, Wave& wave, int candidate) noexcept;

/// Connects vertices to lights by chains of specular vertices (manifold next-event estimation). Reads RayState and
/// PathState; adds to radiance.
template <class L> void manifold_connections(const StageContext& context, Wave& wave) noexcept;

/// Traces shadow rays and adds the unoccluded contributions to the radiance of their paths.
template <class L> void shadow(const StageContext& context, Wave& wave) noexcept;

/// As shadow(), in scenes where shadow rays pass media and surfaces: multiplies by the transmittance.
template <class L> void transmittance(const StageContext& context, Wave& wave) noexcept;

/// Samples the BSDF or the guide, applies Russian roulette and spawns the continuation ray. Reads and writes PathState;
/// writes RayState.
template <class L> void scatter(const StageContext& context, Wave& wave) noexcept;

/// Records the radiance of finished paths as training samples of the guide. Reads RadianceState.
template <class L> void record_training(const StageContext& context, Wave& wave) noexcept;

/// Moves the radiance of finished paths to the task's samples and frees their slots. Negative and non-finite samples
/// are dropped and counted.
template <class L> void accumulate(const StageContext& context, Wave& wave) noexcept;

/// Emits photons in free slots while the task has photons left. Invalid photons finish immediately. Reads the lights;
/// writes RayState, PathState, RescaledPdfs and RadianceState.
template <class L> void photon_rays(const StageContext& context, Wave& wave) noexcept;

/// Pushes a shadow ray from every photon's vertex to the camera, with the radiance that the vertex sends there. Reads
/// PathState; writes RasterPosition.
template <class L> void camera_connections(const StageContext& context, Wave& wave) noexcept;

/// Moves the contributions that the shadow stages found visible to the task's splats. Reads and clears radiance.
template <class L> void splat(const StageContext& context, Wave& wave) noexcept;

/// Adds the radiance that photons around surface vertices reflect along the path. Reads PathState; adds to radiance.
template <class L> void gather(const StageContext& context, Wave& wave) noexcept;

/// Adds the radiance that photons in media scatter along the rays of paths, and moves the paths on to the surface hit.
/// Reads HitState and RescaledPdfs; changes throughput; adds to radiance.
template <class L> void gather_volume(const StageContext& context, Wave& wave) noexcept;

/// Stores photons in the task at non-specular surfaces, or where media scatter them. Reads PathState.
template <class L> void store_photons(const StageContext& context, Wave& wave) noexcept;

/// Frees the slots of photons that have ended or left the scene.
template <class L> void free_photons(const StageContext& context, Wave& wave) noexcept;

/// Whether a stage takes part in the pass of a context.
using StageCondition = bool (*)(const StageContext&);

/// The conditions of kStages.
namespace condition {

inline bool always(const StageContext&) { return true; }
inline bool starts_at_camera(const StageContext& context) { return !context.starts_at_lights(); }
inline bool starts_at_lights(const StageContext& context) { return context.starts_at_lights(); }
inline bool transports_light(const StageContext& context) { return context.transports_light(); }
inline bool in_path_pass(const StageContext& context) { return context.pass() == PassKind::kPath; }
inline bool in_light_pass(const StageContext& context) { return context.pass() == PassKind::kLight; }
inline bool in_photon_pass(const StageContext& context) { return context.pass() == PassKind::kPhoton; }
inline bool in_debug_pass(const StageContext& context) { return context.pass() == PassKind::kDebug; }
inline bool writes_aovs(const StageContext& context) {
  return in_path_pass(context) && context.camera_task().aovs().any();
}
inline bool guides_directions(const StageContext& context) {
  return in_path_pass(context) && sheaf::guides_directions(context);
}
inline bool trains_guide(const StageContext& context) { return in_path_pass(context) && context.trains_guide(); }
inline bool connects_caustics(const StageContext& context) {
  return in_path_pass(context) && context.connects_caustics();
}
inline bool connects_segments(const StageContext& context) { return sheaf::connects_segments(context); }
inline bool gathers_photons(const StageContext& context) { return in_path_pass(context) && context.gathers_photons(); }
inline bool gathers_volume(const StageContext& context) {
  return gathers_photons(context) && context.photon_maps().covers_media();
}
inline bool scatters_in_media(const StageContext& context) {
  return context.transports_light() && !gathers_volume(context);
}
/// Shadow rays that any opaque surface blocks, also those of the debug view of visibility.
inline bool has_opaque_shadows(const StageContext& context) {
  if (in_debug_pass(context)) return context.integrator.traits().measures_visibility;
  return !in_photon_pass(context) && !context.scene.needs_transmittance;
}
inline bool has_transparent_shadows(const StageContext& context) {
  return (in_path_pass(context) || in_light_pass(context)) && context.scene.needs_transmittance;
}

}  // namespace condition

/// A stage, with the queues that it uses.
struct StageEntry {
  std::string_view name;  ///< name of the function and of its file; in reports and benchmarks, too
  QueueSet reads;         ///< queues that it leaves as they are
  QueueSet consumes;      ///< queues that it empties; a source takes only as many free slots as it has paths
  QueueSet produces;      ///< queues that it pushes to
  StageCondition takes_part;
  void (*run)(const StageContext&, Wave&) noexcept;  ///< runs candidate 0 if the stage has run_candidate
  /// Runs one light candidate, for stages that run once for each. Null for others.
  void (*run_candidate)(const StageContext&, Wave&, int candidate) noexcept = nullptr;
  Stage stage{};  ///< position in the list, which sets it

  /// Whether the stage starts paths. It runs when enough slots are free.
  constexpr bool is_source() const { return consumes.contains(Queue::kFree); }
};

/// All stages, in the order of passes and of reports.
template <class L>
inline constexpr auto kStages = [] {
  using Q = Queue;
  namespace C = condition;
  auto stages = std::to_array<StageEntry>({
      {"camera_rays", {}, {Q::kFree}, {Q::kActive}, C::starts_at_camera, camera_rays<L>},
      {"photon_rays", {}, {Q::kFree}, {Q::kActive, Q::kFinished}, C::starts_at_lights, photon_rays<L>},
      {"intersect",
       {},
       {Q::kActive},
       {Q::kMedium, Q::kMiss, Q::kEmitter, Q::kComposite, Q::kSurface, Q::kFinished},
       C::always,
       intersect<L>},
      {"gather_volume",
       {},
       {Q::kMedium},
       {Q::kMiss, Q::kEmitter, Q::kComposite, Q::kSurface, Q::kFinished},
       C::gathers_volume,
       gather_volume<L>},
      {"segment_lights", {Q::kMedium}, {}, {Q::kShadows}, C::connects_segments, segment_lights<L>},
      {"medium",
       {},
       {Q::kMedium},
       {Q::kMiss, Q::kEmitter, Q::kComposite, Q::kSurface, Q::kFinished},
       C::scatters_in_media,
       medium<L>},
      {"emission", {}, {Q::kMiss, Q::kEmitter}, {Q::kActive, Q::kFinished}, C::in_path_pass, emission<L>},
      {"select_materials",
       {},
       {Q::kComposite},
       {Q::kActive, Q::kSurface, Q::kFinished},
       C::always,
       select_materials<L>},
      {"debug_view",
       {},
       {Q::kMiss, Q::kEmitter, Q::kSurface},
       {Q::kActive, Q::kFinished, Q::kShadows},
       C::in_debug_pass,
       debug_view<L>},
      {"sort_surfaces", {}, {Q::kSurface}, {Q::kSorted}, C::transports_light, sort_surfaces<L>},
      {"surface_inputs", {Q::kSorted}, {}, {Q::kVertices}, C::transports_light, surface_inputs<L>},
      {"store_photons", {Q::kSorted, Q::kVertices}, {}, {}, C::in_photon_pass, store_photons<L>},
      {"textures", {Q::kSorted, Q::kVertices}, {}, {}, C::transports_light, textures<L>},
      {"aovs", {Q::kSorted, Q::kVertices}, {}, {}, C::writes_aovs, aovs<L>},
      {"gather", {Q::kSorted, Q::kVertices}, {}, {}, C::gathers_photons, gather<L>},
      {"guide", {Q::kSorted, Q::kVertices}, {}, {}, C::guides_directions, guide<L>},
      {"light_candidates",
       {Q::kSorted, Q::kVertices},
       {},
       {Q::kCandidates},
       C::in_path_pass,
       [](const StageContext& context, Wave& wave) noexcept { light_candidates<L>(context, wave, 0); },
       light_candidates<L>},
      {"resample",
       {Q::kSorted, Q::kVertices},
       {Q::kCandidates},
       {Q::kShadows},
       C::in_path_pass,
       [](const StageContext& context, Wave& wave) noexcept { resample<L>(context, wave, 0); },
       resample<L>},
      {"manifold_connections", {Q::kSorted, Q::kVertices}, {}, {}, C::connects_caustics, manifold_connections<L>},
      {"camera_connections", {Q::kSorted, Q::kVertices}, {}, {Q::kShadows}, C::in_light_pass, camera_connections<L>},
      {"shadow", {}, {Q::kShadows}, {}, C::has_opaque_shadows, shadow<L>},
      {"transmittance", {}, {Q::kShadows}, {}, C::has_transparent_shadows, transmittance<L>},
      {"splat", {Q::kSorted}, {}, {}, C::in_light_pass, splat<L>},
      {"scatter", {}, {Q::kSorted, Q::kVertices}, {Q::kActive, Q::kFinished}, C::transports_light, scatter<L>},
      {"record_training", {Q::kFinished}, {}, {}, C::trains_guide, record_training<L>},
      {"accumulate", {}, {Q::kFinished}, {Q::kFree}, C::starts_at_camera, accumulate<L>},
      {"free_photons", {}, {Q::kMiss, Q::kEmitter, Q::kFinished}, {Q::kFree}, C::starts_at_lights, free_photons<L>},
  });
  static_assert(stages.size() <= kMaxStages);
  for (std::size_t i = 0; i < stages.size(); ++i) stages[i].stage = static_cast<Stage>(i);
  return stages;
}();

/// The stage of that name. A name that is not in the list does not compile. Stages pass their own lane policy, so that
/// they refer to no instance of another one.
template <class L = Wide> consteval Stage stage_named(std::string_view name) {
  for (const StageEntry& entry : kStages<L>)
    if (entry.name == name) return entry.stage;
  throw "no stage has this name";
}

/// The lane policy that stages and passes are compiled for: Wide in sheaf_kernels, Scalar in sheaf_kernels_scalar,
/// which only tests and benchmarks link.
#ifndef SHEAF_STAGE_LANE
#define SHEAF_STAGE_LANE Wide
#endif

/// Instantiates a stage for that lane policy.
// NOLINTBEGIN(bugprone-macro-parentheses): a name cannot stand in parentheses
#define SHEAF_INSTANTIATE_STAGE(stage) template void stage<SHEAF_STAGE_LANE>(const StageContext&, Wave&) noexcept
/// The same for stages that take the index of a candidate.
#define SHEAF_INSTANTIATE_CANDIDATE_STAGE(stage) \
  template void stage<SHEAF_STAGE_LANE>(const StageContext&, Wave&, int) noexcept
// NOLINTEND(bugprone-macro-parentheses)

}  // namespace sheaf
