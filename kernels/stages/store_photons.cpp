// Stage: store photons. Stores photons at non-specular surfaces, or where media scatter them, in the task
// (kernels/photons/photon.h). Media that keep beams store no photons. Precedes the textures stage, which selects among
// mapped normals and weights photons for it.
#include "core/sampling/octahedral.h"
#include "kernels/bsdf/list.h"
#include "kernels/media/moving_medium.h"
#include "kernels/media/pass_through_probability.h"
#include "kernels/photons/light_task.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/lane_mean.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

namespace {

bool is_specular(ClosureKind kind) {
  bool specular = false;
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind k, BsdfTag<Bsdf>) {
    specular = specular || (k == kind && Bsdf<Scalar>::kIsSpecular);
  });
  return specular;
}

/// Probability of selecting, among the parts of a composite material, one where photons are stored; 1 for other
/// materials. Vertices that look photons up are selected with the same probability, so photons are divided by it.
float storing_probability(const SceneView& scene, const HitState<Scalar>& hit, const RayState<Scalar>& ray,
                          float time) {
  if (!scene.materials.has_composites) return 1.0f;
  const ShapeRecord<Scalar> shape = gather_rows<Scalar>(scene.geometry.shapes, hit.shape);
  if (shape.material == hit.material) return 1.0f;
  const auto y = surface_point<Scalar, true>(scene, shape, hit.primitive, hit.u, hit.v,
                                             ray.origin + ray.direction * hit.t, hit.instance, time);
  return mixture_probability(scene, shape.material, dot(y.ng, ray.direction) > 0.0f,
                             {y.uv, hit.shape, hit.primitive, hit.u, hit.v, y.p}, [&scene](std::uint32_t row) {
                               return row != MaterialRow::kNothing && !is_specular(scene.materials.rows[row].kind);
                             });
}

/// Transforms a photon to the rest pose of the grids of its medium. Its power per volume stays that of the world.
/// `direction`: of travel.
void rest_photon(const SceneView& scene, std::uint32_t medium, float time, Vec3f& direction, Photon& photon) {
  if (scene.motion.media[medium].segment_count == 0) return;
  const InstancePlacement<Scalar> placed = medium_motion(scene, medium, time).placed;
  photon.p = placed.object_point(photon.p);
  photon.power = photon.power * (1.0f / std::fabs(placed.determinant));
  direction = normalize(placed.object_vector(direction));
}

void store_path(const StageContext& context, Wave& wave, Slot slot, int column, bool in_medium) {
  LightTask& task = context.light_task();
  const RayState<Scalar> ray = wave.rays.get(slot);
  ++task.arrived;
  if (!in_medium && !task.stores(ray.flags)) return;
  if (in_medium &&
      keeps_beams(context.integrator.photons, context.scene.media.rows[(ray.flags >> kRayMediumShift) - 1u]))
    return;
  // Compute the power, with the pdfs of the path so far
  const PathState<Scalar> path = wave.paths.get(slot);
  const RadianceState<Scalar>& row = wave.radiance.row(slot);
  const auto item = wave.vertices.load<Scalar>(column);
  const float divisor = context.scene.needs_transmittance
                            ? lane_mean<Scalar>(context.scene.color, wave.rescaled_pdfs.row(slot).r_u)
                            : 1.0f;
  const float probability =
      in_medium ? 1.0f
                : storing_probability(context.scene, wave.hits.get(slot), ray, path_time(context.scene, wave, slot));
  // Make the record
  Photon photon;
  photon.p = item.p;
  photon.power = path.beta * (row.weight / (divisor * max(probability, 1e-20f)));
  Vec3f direction = ray.direction;
  if (in_medium && context.scene.motion.media != nullptr)
    rest_photon(context.scene, (ray.flags >> kRayMediumShift) - 1u, path_time(context.scene, wave, slot), direction,
                photon);
  photon.direction = encode_octahedral<Scalar>(-direction);
  const bool single = has_single_wavelength(context, wave, slot);
  photon.surface = in_medium ? photon_medium_key(ray.flags >> kRayMediumShift, path.depth() + 1, single)
                             : photon_surface(encode_octahedral<Scalar>(item.ng), path.depth() + 1, single);
  photon.order = row.task_sample << kVertexBits | path.dimension();
  // Store it, or count it as dropped
  if (is_finite(max_component(photon.power)) && is_finite(photon.p)) {
    task.stored.push_back(photon);
    return;
  }
  ++wave.stats.dropped.samples;
  if (!wave.first_dropped.any) wave.first_dropped = {true, path.pixel, path.sample};
}

}  // namespace

template <class L> void store_photons(const StageContext& context, Wave& wave) noexcept {
  StageTimer timer(wave.stats, stage_named<L>("store_photons"));
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if constexpr (!Bsdf<L>::kIsSpecular) {
      constexpr bool kInMedium = kIsPhaseFunction<Bsdf<L>>;
      if (kInMedium != context.light_task().stores_in_media()) return;
      const VertexRun& run = wave.runs[static_cast<int>(kind)];
      timer.count(run.count, 1);
      for (int i = 0; i < run.count; ++i)
        store_path(context, wave, wave.sorted[run.slot_begin + i], run.column_begin + i, kInMedium);
    }
  });
}

SHEAF_INSTANTIATE_STAGE(store_photons);

}  // namespace sheaf
