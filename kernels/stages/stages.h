// The stages of wavefront path tracing (Laine, Karras and Aila, "Megakernels Considered Harmful", 2013). Each stage is
// a free function in a file of its own name that works on one wave and calls no other stage. The passes in
// kernels/passes/ call them in order. All stages are generic in the lane policy: Wide renders, and Scalar, path by
// path, is the baseline of the benchmarks.
#pragma once

#include "kernels/wave/context.h"
#include "kernels/wave/wave.h"

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

/// All stages, in the order of passes and of reports; described in kernels/stages/stage_list.h.
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

/// The lane policy that stages and passes are compiled for: Wide in sheaf_kernels, Scalar in sheaf_kernels_scalar,
/// which only tests and benchmarks link.
#ifndef SHEAF_STAGE_LANE
#define SHEAF_STAGE_LANE Wide
#endif

/// Instantiates a stage for that lane policy.
#define SHEAF_INSTANTIATE_STAGE(stage) template void stage<SHEAF_STAGE_LANE>(const StageContext&, Wave&) noexcept
/// The same for stages that take the index of a candidate.
#define SHEAF_INSTANTIATE_CANDIDATE_STAGE(stage) \
  template void stage<SHEAF_STAGE_LANE>(const StageContext&, Wave&, int) noexcept

}  // namespace sheaf
