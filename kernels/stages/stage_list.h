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

/// The passes that a stage belongs to, and its conditions.
enum class StageUse {
  kAlways,  ///< all passes
  kCamera,  ///< passes that start at the camera
  kLight,   ///< passes that transport light
  /// Passes with shadow rays, without SceneView::needs_transmittance; also the debug view of visibility.
  kBinary,
  kTransmission,     ///< passes with shadow rays, with SceneView::needs_transmittance
  kPath,             ///< path pass
  kAovs,             ///< path pass with AOVs
  kGuiding,          ///< path pass with a guide
  kLearning,         ///< path pass that trains a guide
  kCaustics,         ///< path pass with specular chains to the lights
  kGathering,        ///< path pass with photon maps
  kGatheringMedia,   ///< path pass with a volume photon map
  kScatteringMedia,  ///< passes that transport light, without a volume photon map
  kPhotons,          ///< light pass and photon pass
  kSplats,           ///< light pass
  kStoring,          ///< photon pass
  kDebug,            ///< debug views
};

/// A stage, with the queues that it uses.
struct StageEntry {
  std::string_view name;  ///< name of the function and of its file; in reports and benchmarks, too
  QueueSet consumes;      ///< queues that it empties or reads
  QueueSet produces;      ///< queues that it pushes to
  StageUse use;
  void (*run)(const StageContext&, Wave&) noexcept;  ///< stages that process one light candidate: the first
  /// Stages that run once for each light candidate: for the candidate of that index. Null for others.
  void (*run_candidate)(const StageContext&, Wave&, int candidate) noexcept = nullptr;
  Stage stage{};  ///< position in the list, which sets it

  /// Whether the stage starts paths. It runs when enough slots are free.
  constexpr bool is_source() const { return consumes.contains(Queue::kFree); }
};

/// All stages, in the order of passes and of reports.
template <class L>
inline constexpr auto kStages = [] {
  using Q = Queue;
  using U = StageUse;
  auto stages = std::to_array<StageEntry>({
      {"camera_rays", {Q::kFree}, {Q::kActive}, U::kCamera, camera_rays<L>},
      {"photon_rays", {Q::kFree}, {Q::kActive, Q::kFinished}, U::kPhotons, photon_rays<L>},
      {"intersect",
       {Q::kActive},
       {Q::kMedium, Q::kMiss, Q::kEmitter, Q::kComposite, Q::kSurface, Q::kFinished},
       U::kAlways,
       intersect<L>},
      {"gather_volume",
       {Q::kMedium},
       {Q::kMiss, Q::kEmitter, Q::kComposite, Q::kSurface, Q::kFinished},
       U::kGatheringMedia,
       gather_volume<L>},
      {"medium",
       {Q::kMedium},
       {Q::kMiss, Q::kEmitter, Q::kComposite, Q::kSurface, Q::kFinished},
       U::kScatteringMedia,
       medium<L>},
      {"emission", {Q::kMiss, Q::kEmitter}, {Q::kActive, Q::kFinished}, U::kPath, emission<L>},
      {"select_materials", {Q::kComposite}, {Q::kActive, Q::kSurface, Q::kFinished}, U::kAlways, select_materials<L>},
      {"debug_view",
       {Q::kMiss, Q::kEmitter, Q::kSurface},
       {Q::kActive, Q::kFinished, Q::kShadows},
       U::kDebug,
       debug_view<L>},
      {"sort_surfaces", {Q::kSurface}, {Q::kSorted}, U::kLight, sort_surfaces<L>},
      {"surface_inputs", {Q::kSorted}, {Q::kVertices}, U::kLight, surface_inputs<L>},
      {"store_photons", {Q::kSorted, Q::kVertices}, {}, U::kStoring, store_photons<L>},
      {"textures", {Q::kVertices}, {Q::kVertices}, U::kLight, textures<L>},
      {"aovs", {Q::kSorted, Q::kVertices}, {}, U::kAovs, aovs<L>},
      {"gather", {Q::kSorted, Q::kVertices}, {}, U::kGathering, gather<L>},
      {"guide", {Q::kSorted, Q::kVertices}, {}, U::kGuiding, guide<L>},
      {"light_candidates",
       {Q::kVertices},
       {Q::kCandidates},
       U::kPath,
       [](const StageContext& context, Wave& wave) noexcept { light_candidates<L>(context, wave, 0); },
       light_candidates<L>},
      {"resample",
       {Q::kVertices, Q::kCandidates},
       {Q::kShadows},
       U::kPath,
       [](const StageContext& context, Wave& wave) noexcept { resample<L>(context, wave, 0); },
       resample<L>},
      {"manifold_connections", {Q::kSorted, Q::kVertices}, {}, U::kCaustics, manifold_connections<L>},
      {"camera_connections", {Q::kSorted, Q::kVertices}, {Q::kShadows}, U::kSplats, camera_connections<L>},
      {"shadow", {Q::kShadows}, {}, U::kBinary, shadow<L>},
      {"transmittance", {Q::kShadows}, {}, U::kTransmission, transmittance<L>},
      {"splat", {Q::kSorted}, {}, U::kSplats, splat<L>},
      {"scatter", {Q::kSorted, Q::kVertices}, {Q::kActive, Q::kFinished}, U::kLight, scatter<L>},
      {"record_training", {}, {}, U::kLearning, record_training<L>},
      {"accumulate", {Q::kFinished}, {Q::kFree}, U::kCamera, accumulate<L>},
      {"free_photons", {Q::kMiss, Q::kEmitter, Q::kFinished}, {Q::kFree}, U::kPhotons, free_photons<L>},
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

/// Whether a stage takes part in the context's pass.
inline bool takes_part(const StageContext& context, StageUse use) {
  const PassKind pass = context.pass();
  const bool gathers_volume = context.gathers_photons() && context.photon_maps().covers_media();
  const bool has_shadow_rays = pass == PassKind::kPath || pass == PassKind::kLight;
  switch (use) {
    case StageUse::kAlways:
      return true;
    case StageUse::kCamera:
      return !context.starts_at_lights();
    case StageUse::kLight:
      return context.transports_light();
    case StageUse::kPath:
      return pass == PassKind::kPath;
    case StageUse::kAovs:
      return pass == PassKind::kPath && context.camera_task().aovs().any();
    case StageUse::kGuiding:
      return pass == PassKind::kPath && context.samples_guide();
    case StageUse::kLearning:
      return pass == PassKind::kPath && context.trains_guide();
    case StageUse::kCaustics:
      return pass == PassKind::kPath && context.connects_caustics();
    case StageUse::kGathering:
      return pass == PassKind::kPath && context.gathers_photons();
    case StageUse::kGatheringMedia:
      return pass == PassKind::kPath && gathers_volume;
    case StageUse::kScatteringMedia:
      return context.transports_light() && !(pass == PassKind::kPath && gathers_volume);
    case StageUse::kPhotons:
      return context.starts_at_lights();
    case StageUse::kSplats:
      return pass == PassKind::kLight;
    case StageUse::kStoring:
      return pass == PassKind::kPhoton;
    case StageUse::kBinary:
      return has_shadow_rays ? !context.scene.needs_transmittance
                             : context.integrator.kind == IntegratorKind::kVisibility;
    case StageUse::kTransmission:
      return has_shadow_rays && context.scene.needs_transmittance;
    case StageUse::kDebug:
      return pass == PassKind::kDebug;
  }
  return false;
}

}  // namespace sheaf
