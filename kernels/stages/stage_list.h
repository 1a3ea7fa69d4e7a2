// The list of all stages, from which statistics, tests and benchmarks are generated.
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
  void (*run)(const StageContext&, Wave&) noexcept;  ///< stages that take a candidate: for the first one
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

/// The name of a stage in reports.
inline std::string_view stage_name(Stage stage) { return kStages<Wide>[static_cast<std::size_t>(stage)].name; }

/// Whether a stage belongs to the pass of a context that transports light (`light`), or to its debug view. This is the
/// light pass or the photon pass if the context has photons, otherwise the path pass.
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
