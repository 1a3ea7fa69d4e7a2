// The stages that passes are made of. Each is a free function in a file of its own name,
// works on one wave, and knows no other stage; kernels/passes/ know the order. All are generic in the lane: Wide
// renders, Scalar is the path-by-path null hypothesis of the benchmarks.
#pragma once

#include "kernels/wave/context.h"
#include "kernels/wave/wave.h"

namespace sheaf {

/// Starts camera paths in free slots until there are none or the task has no samples left. Reads the camera and the
/// filter; writes ray, throughput and radiance state.
template <class L> void camera_rays(const StageContext& context, Wave& wave) noexcept;

/// Traces all active rays and sorts the paths by what they met. Reads ray state; writes hit state. Rays that are not
/// finite are dropped and counted.
template <class L> void intersect(const StageContext& context, Wave& wave) noexcept;

/// Samples where paths scatter in media, or lets them pass on to what they hit; adds what media emit. Reads ray and hit
/// state; writes throughput and probabilities, and the hit where a path scatters.
template <class L> void medium(const StageContext& context, Wave& wave) noexcept;

/// Adds the light that rays ran into, weighted against light sampling (multiple importance sampling, power heuristic:
/// Veach 1997, section 9.2.2). Reads ray, hit and throughput state; adds to radiance.
template <class L> void emission(const StageContext& context, Wave& wave) noexcept;

/// Chooses among the parts of composite materials. Reads ray state; writes the hit's material, or the ray's origin
/// where light passes.
template <class L> void select_materials(const StageContext& context, Wave& wave) noexcept;

/// Pictures for debugging instead of light, by IntegratorKind: normals or depth of the first surface, or a shadow ray
/// from it.
template <class L> void debug_view(const StageContext& context, Wave& wave) noexcept;

/// Sorts surface hits by closure kind and material. Reads hit state.
template <class L> void sort_surfaces(const StageContext& context, Wave& wave) noexcept;

/// Works out positions, frames and closure parameters. Reads ray and hit state.
template <class L> void surface_inputs(const StageContext& context, Wave& wave) noexcept;

/// Looks up textures: replaces closure parameters, and turns shading normals by maps.
template <class L> void textures(const StageContext& context, Wave& wave) noexcept;

/// Puts what the first surfaces of camera paths are like into the task's samples, for the layers that ask for it. Reads
/// ray, hit and radiance state.
template <class L> void aovs(const StageContext& context, Wave& wave) noexcept;

/// Finds out where the guide knows of vertices, for light sampling and scattering. Reads ray state.
template <class L> void guide(const StageContext& context, Wave& wave) noexcept;

/// Samples one light per vertex: the candidate of that index, below IntegratorDescription::candidates. Reads
/// throughput.
template <class L> void light_candidates(const StageContext& context, Wave& wave, int candidate) noexcept;

/// Weighs that candidate against those before it and keeps one of them; after the last one pushes a shadow ray with
/// what was kept. Reads throughput.
template <class L> void resample(const StageContext& context, Wave& wave, int candidate) noexcept;

/// Traces shadow rays and pays what is unoccluded into the paths' radiance.
template <class L> void shadow(const StageContext& context, Wave& wave) noexcept;

/// As shadow(), where light passes media and surfaces on its way, weakened.
template <class L> void transmittance(const StageContext& context, Wave& wave) noexcept;

/// Samples the BSDF or the guide, plays roulette and writes the next ray. Reads and writes throughput; writes ray
/// state.
template <class L> void scatter(const StageContext& context, Wave& wave) noexcept;

/// Tells the guide what finished paths have found. Reads radiance.
template <class L> void record_training(const StageContext& context, Wave& wave) noexcept;

/// Moves finished paths' radiance to the task's samples and frees their slots. Samples that are not finite or negative
/// are dropped and counted.
template <class L> void accumulate(const StageContext& context, Wave& wave) noexcept;

/// Emits photons in free slots until there are none or the task has none left; those that are none end. Reads the
/// lights; writes ray, throughput, probability and radiance state.
template <class L> void photon_rays(const StageContext& context, Wave& wave) noexcept;

/// Pushes a shadow ray from every photon's vertex towards the camera, with what that vertex sends there. Reads
/// throughput; writes where on the film it is seen.
template <class L> void camera_connections(const StageContext& context, Wave& wave) noexcept;

/// Moves what the shadow stages have let pass to the task's splats. Reads and clears radiance.
template <class L> void splat(const StageContext& context, Wave& wave) noexcept;

/// Adds what the photons around vertices make them send along the path. Reads throughput; adds to radiance.
template <class L> void gather(const StageContext& context, Wave& wave) noexcept;

/// Adds what photons in media make these send along the rays of paths in them, and sends the paths on to what their
/// rays hit. Reads hits, probabilities; changes throughput; adds to radiance.
template <class L> void gather_volume(const StageContext& context, Wave& wave) noexcept;

/// Leaves photons in the task where they meet surfaces that are not specular, or where media scatter them. Reads
/// throughput.
template <class L> void store_photons(const StageContext& context, Wave& wave) noexcept;

/// Frees the slots of photons that have ended or left the scene.
template <class L> void free_photons(const StageContext& context, Wave& wave) noexcept;

/// Every stage, in the order of passes and of reports; kernels/stages/stage_list.h says more of each.
enum class Stage : std::uint32_t {
  kCameraRays,
  kPhotonRays,
  kIntersect,
  kGatherVolume,
  kMedium,
  kEmission,
  kSelectMaterials,
  kDebugView,
  kSortSurfaces,
  kSurfaceInputs,
  kStorePhotons,
  kTextures,
  kAovs,
  kGather,
  kGuide,
  kLightCandidates,
  kResample,
  kCameraConnections,
  kShadow,
  kTransmittance,
  kSplat,
  kScatter,
  kRecordTraining,
  kAccumulate,
  kFreePhotons,
  kCount
};
inline constexpr std::size_t kStageCount = static_cast<std::size_t>(Stage::kCount);
static_assert(kStageCount <= kMaxStages);

/// The lane that the sources of stages and passes are compiled for: Wide in sheaf_kernels, Scalar in
/// sheaf_kernels_scalar, which tests and benchmarks alone are linked with.
#ifndef SHEAF_STAGE_LANE
#define SHEAF_STAGE_LANE Wide
#endif

/// Instantiates a stage for that lane.
#define SHEAF_INSTANTIATE_STAGE(stage) template void stage<SHEAF_STAGE_LANE>(const StageContext&, Wave&) noexcept
/// The same for one that works on a candidate.
#define SHEAF_INSTANTIATE_CANDIDATE_STAGE(stage) \
  template void stage<SHEAF_STAGE_LANE>(const StageContext&, Wave&, int) noexcept

}  // namespace sheaf
