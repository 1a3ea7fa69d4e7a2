// The schedule: the one list of stages, in the order in which passes run them. Passes, statistics, tests and benchmarks
// derive from it.
#pragma once

#include "kernels/film/camera_task.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/stages/stages.h"

#include <array>
#include <string_view>

namespace sheaf {

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
  Stage stage;
  std::string_view name;  ///< name in reports and benchmarks, e.g. "light_candidates"
  QueueSet consumes;      ///< queues that it empties or reads
  QueueSet produces;      ///< queues that it pushes to
  StageUse use;
  void (*run)(const StageContext&, Wave&) noexcept;  ///< stages that process one light candidate: the first
  /// Stages that run once for each light candidate: for the candidate of that index. Null for others.
  void (*run_candidate)(const StageContext&, Wave&, int candidate) noexcept = nullptr;

  /// Whether the stage starts paths. It runs when enough slots are free.
  constexpr bool is_source() const { return stage == Stage::kCameraRays || stage == Stage::kPhotonRays; }
};

/// All stages, in the order of Stage.
template <class L>
inline constexpr auto kStages = [] {
  using S = Stage;
  using Q = Queue;
  using U = StageUse;
  return std::array<StageEntry, kStageCount>{{
      {S::kCameraRays, "camera_rays", {Q::kFree}, {Q::kActive}, U::kCamera, camera_rays<L>},
      {S::kPhotonRays, "photon_rays", {Q::kFree}, {Q::kActive, Q::kFinished}, U::kPhotons, photon_rays<L>},
      {S::kIntersect,
       "intersect",
       {Q::kActive},
       {Q::kMedium, Q::kMiss, Q::kEmitter, Q::kComposite, Q::kSurface, Q::kFinished},
       U::kAlways,
       intersect<L>},
      {S::kGatherVolume,
       "gather_volume",
       {Q::kMedium},
       {Q::kMiss, Q::kEmitter, Q::kComposite, Q::kSurface, Q::kFinished},
       U::kGatheringMedia,
       gather_volume<L>},
      {S::kMedium,
       "medium",
       {Q::kMedium},
       {Q::kMiss, Q::kEmitter, Q::kComposite, Q::kSurface, Q::kFinished},
       U::kScatteringMedia,
       medium<L>},
      {S::kEmission, "emission", {Q::kMiss, Q::kEmitter}, {Q::kActive, Q::kFinished}, U::kPath, emission<L>},
      {S::kSelectMaterials,
       "select_materials",
       {Q::kComposite},
       {Q::kActive, Q::kSurface, Q::kFinished},
       U::kAlways,
       select_materials<L>},
      {S::kDebugView,
       "debug_view",
       {Q::kMiss, Q::kEmitter, Q::kSurface},
       {Q::kActive, Q::kFinished, Q::kShadows},
       U::kDebug,
       debug_view<L>},
      {S::kSortSurfaces, "sort_surfaces", {Q::kSurface}, {Q::kSorted}, U::kLight, sort_surfaces<L>},
      {S::kSurfaceInputs, "surface_inputs", {Q::kSorted}, {Q::kVertices}, U::kLight, surface_inputs<L>},
      {S::kStorePhotons, "store_photons", {Q::kSorted, Q::kVertices}, {}, U::kStoring, store_photons<L>},
      {S::kTextures, "textures", {Q::kVertices}, {Q::kVertices}, U::kLight, textures<L>},
      {S::kAovs, "aovs", {Q::kSorted, Q::kVertices}, {}, U::kAovs, aovs<L>},
      {S::kGather, "gather", {Q::kSorted, Q::kVertices}, {}, U::kGathering, gather<L>},
      {S::kGuide, "guide", {Q::kSorted, Q::kVertices}, {}, U::kGuiding, guide<L>},
      {S::kLightCandidates,
       "light_candidates",
       {Q::kVertices},
       {Q::kCandidates},
       U::kPath,
       [](const StageContext& context, Wave& wave) noexcept { light_candidates<L>(context, wave, 0); },
       light_candidates<L>},
      {S::kResample,
       "resample",
       {Q::kVertices, Q::kCandidates},
       {Q::kShadows},
       U::kPath,
       [](const StageContext& context, Wave& wave) noexcept { resample<L>(context, wave, 0); },
       resample<L>},
      {S::kCameraConnections,
       "camera_connections",
       {Q::kSorted, Q::kVertices},
       {Q::kShadows},
       U::kSplats,
       camera_connections<L>},
      {S::kShadow, "shadow", {Q::kShadows}, {}, U::kBinary, shadow<L>},
      {S::kTransmittance, "transmittance", {Q::kShadows}, {}, U::kTransmission, transmittance<L>},
      {S::kSplat, "splat", {Q::kSorted}, {}, U::kSplats, splat<L>},
      {S::kScatter, "scatter", {Q::kSorted, Q::kVertices}, {Q::kActive, Q::kFinished}, U::kLight, scatter<L>},
      {S::kRecordTraining, "record_training", {}, {}, U::kLearning, record_training<L>},
      {S::kAccumulate, "accumulate", {Q::kFinished}, {Q::kFree}, U::kCamera, accumulate<L>},
      {S::kFreePhotons,
       "free_photons",
       {Q::kMiss, Q::kEmitter, Q::kFinished},
       {Q::kFree},
       U::kPhotons,
       free_photons<L>},
  }};
}();
static_assert(
    [] {
      for (std::size_t i = 0; i < kStageCount; ++i)
        if (static_cast<std::size_t>(kStages<Wide>[i].stage) != i || kStages<Wide>[i].name.empty()) return false;
      return true;
    }(),
    "the list follows the enumeration");

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
