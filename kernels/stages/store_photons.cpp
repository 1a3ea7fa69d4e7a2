// Stage: store photons. Wherever a photon meets a surface that is not specular, or is scattered in a medium, it may be
// noted in the task; see kernels/photons/photon.h. Before textures, which choose among normals and weigh photons by
// that choice.
#include "core/octahedral.h"
#include "kernels/bsdf/all.h"
#include "kernels/film/light_task.h"
#include "kernels/stages/stages.h"
#include "kernels/wave/lane_mean.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

namespace {

void store_path(const StageContext& context, Wave& wave, Slot slot, int column, bool in_medium) {
  LightTask& task = *context.photons;
  const RayState<Scalar> ray = wave.rays.get(slot);
  ++task.arrived;
  if (!in_medium && !task.stores(ray.flags)) return;
  const ThroughputState<Scalar> path = wave.throughput.get(slot);
  const RadianceState<Scalar>& row = wave.radiance.row(slot);
  const auto item = wave.vertices.load<Scalar>(column);
  const float divisor =
      context.scene.has_transparency ? lane_mean<Scalar>(context.scene.color, wave.probabilities.row(slot).r_u) : 1.0f;
  Photon photon;
  photon.p = item.p;
  photon.power = path.beta * (row.weight / divisor);
  photon.direction = encode_octahedral<Scalar>(-ray.direction);
  const bool single = has_single_wavelength(context, wave, slot);
  photon.surface = in_medium ? photon_place(ray.flags >> kRayMediumShift, path.depth() + 1, single)
                             : photon_surface(encode_octahedral<Scalar>(item.ng), path.depth() + 1, single);
  photon.order = row.task_sample << kVertexBits | path.event();
  if (is_finite(max_component(photon.power)) && is_finite(item.p)) {
    task.stored.push_back(photon);
    return;
  }
  ++wave.stats.dropped.samples;
  if (!wave.first_dropped.any) wave.first_dropped = {true, path.pixel, path.sample};
}

}  // namespace

template <class L> void store_photons(const StageContext& context, Wave& wave) noexcept {
  if (context.photons == nullptr) return;
  StageTimer timer(wave.stats, Stage::kStorePhotons);
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if constexpr (!Bsdf<L>::kIsSpecular) {
      constexpr bool kInMedium = kIsPhaseFunction<Bsdf<L>>;
      if (kInMedium != context.photons->stores_in_media()) return;
      const VertexRun& run = wave.runs[static_cast<int>(kind)];
      timer.count(run.count, 1);
      for (int i = 0; i < run.count; ++i)
        store_path(context, wave, wave.sorted[run.slot_begin + i], run.column_begin + i, kInMedium);
    }
  });
}

SHEAF_INSTANTIATE_STAGE(store_photons);

}  // namespace sheaf
