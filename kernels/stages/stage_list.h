// The one list of stages, from which statistics, tests and benchmarks derive.
#pragma once

#include "kernels/film/camera_task.h"
#include "kernels/photons/photon_maps.h"
#include "kernels/stages/stages.h"

#include <array>
#include <string_view>

namespace sheaf {

/// Which passes a stage belongs to, and under which condition.
enum class StageUse {
  kAlways,  ///< of all passes
  kCamera,  ///< of passes that start at the camera
  kLight,   ///< of passes that transport light
  /// Of those with shadow rays, where light passes or doesn't: without SceneView::needs_transmittance; and of the debug
  /// view that has them.
  kBinary,
  kTransmission,     ///< of those, with it
  kPath,             ///< of the path pass
  kAovs,             ///< of the path pass, where there are layers of first surfaces
  kGuiding,          ///< of the path pass, where there is a guide
  kLearning,         ///< of the path pass, where a guide learns
  kGathering,        ///< of the path pass, where there are photon maps
  kGatheringMedia,   ///< of the path pass, where there is a volume photon map
  kScatteringMedia,  ///< of passes that transport light, but for that one
  kPhotons,          ///< of the light pass and the photon pass
  kSplats,           ///< of the light pass
  kStoring,          ///< of the photon pass
  kDebug,            ///< of debug views
};

/// One stage, and what it does with queues.
struct StageEntry {
  Stage stage;
  std::string_view name;  ///< as reports and benchmarks write it, e.g. "light_candidates"
  QueueSet consumes;      ///< queues that it empties, or whose rows it reads
  QueueSet produces;      ///< queues that it pushes to
  StageUse use;
  void (*run)(const StageContext&, Wave&) noexcept;  ///< those that work on a candidate: on the first
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
       [](const StageContext& context, Wave& wave) noexcept { light_candidates<L>(context, wave, 0); }},
      {S::kResample,
       "resample",
       {Q::kVertices, Q::kCandidates},
       {Q::kShadows},
       U::kPath,
       [](const StageContext& context, Wave& wave) noexcept { resample<L>(context, wave, 0); }},
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

/// The stage's name in reports.
inline std::string_view stage_name(Stage stage) { return kStages<Wide>[static_cast<std::size_t>(stage)].name; }

/// Whether a stage has a part in the pass of a context that transports light (`light`) or in its debug view. That pass
/// is the light pass or the photon pass where the context has photons, else the path pass.
inline bool takes_part(const StageContext& context, StageUse use, bool light) {
  const bool photons = context.photons != nullptr;
  const bool stores = photons && context.integrator.kind != IntegratorKind::kLightTracer;
  const bool volume = context.maps != nullptr && context.maps->volume != nullptr;
  switch (use) {
    case StageUse::kAlways:
      return true;
    case StageUse::kCamera:
      return !photons;
    case StageUse::kLight:
      return light;
    case StageUse::kPath:
      return light && !photons;
    case StageUse::kAovs:
      return light && context.camera != nullptr && context.camera->aovs().any();
    case StageUse::kGuiding:
      return light && context.guides;
    case StageUse::kLearning:
      return light && context.training != nullptr;
    case StageUse::kGathering:
      return light && context.maps != nullptr;
    case StageUse::kGatheringMedia:
      return light && volume;
    case StageUse::kScatteringMedia:
      return light && !volume;
    case StageUse::kPhotons:
      return photons;
    case StageUse::kSplats:
      return photons && !stores;
    case StageUse::kStoring:
      return stores;
    case StageUse::kBinary:
      return light ? !stores && !context.scene.needs_transmittance
                   : context.integrator.kind == IntegratorKind::kVisibility;
    case StageUse::kTransmission:
      return light && !stores && context.scene.needs_transmittance;
    case StageUse::kDebug:
      return !light;
  }
  return false;
}

}  // namespace sheaf
