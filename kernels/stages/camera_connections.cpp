// Stage: camera connections. Light tracing (Dutre, Lafortune and Willems 1993): samples a point on the lens for every
// non-specular vertex of a photon, and pushes a shadow ray to it if the vertex is inside the film.
//
// A photon of flux Phi adds Phi f |cos| W to the integral of radiance over the film. W is CameraView::importance (Veach
// 1997, section 8.2, with the film's pixels as the measure).
#include "core/sampling/sampler.h"
#include "core/sampling/warp.h"
#include "kernels/bsdf/list.h"
#include "kernels/photons/light_task.h"
#include "kernels/stages/adjoint.h"
#include "kernels/stages/moving_camera.h"
#include "kernels/stages/push_shadow_ray.h"
#include "kernels/stages/shading_frame.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/load_bsdf.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/stage_timer.h"

namespace sheaf {

namespace {

template <class L, template <class> class Bsdf>
SHEAF_INLINE void connect_tile(const StageContext& context, Wave& wave, const Slot* slots, int column, int count,
                               bool mapped) {
  using F = Float<L>;
  const auto item = wave.vertices.load<L>(column);
  const PathState<L> path = wave.paths.gather<L>(slots);
  const F flux = wave.radiance.gather<L>(slots).weight;
  // Sample the lens and project the vertex onto the film
  Vec2<L> lens{F(0.0f), F(0.0f)};
  if (context.scene.sensor.camera.has_lens()) {
    const auto u = draw<L>(context.sampler, path.pixel, path.sample, path.dimension(), SampleBlock::kLight, {},
                           kNumberY | kNumberZ);
    lens = square_to_disk<L>(u.y, u.z);
  }
  const CameraView<L> view = view_at<L>(context.scene, item.p, lens, path_times<L>(context.scene, wave, slots));
  const SplatFilter::Bounds& film = context.light_task().film_bounds;
  auto seen = view.valid & (view.film_x > F(film.x0)) & (view.film_x < F(film.x1)) & (view.film_y > F(film.y0)) &
              (view.film_y < F(film.y1)) & L::first(count);
  // The camera sees hidden lights only through thin dielectrics, which the shadow ray may cross.
  Uint<L> shadow_flags(0u);
  if (!kIsPhaseFunction<Bsdf<L>> && context.integrator.hide_emitters) {
    const auto on_light = wave.hits.gather<L>(slots).light != Uint<L>(kNone);
    if (context.scene.shadow_rays_pass_thin_dielectrics)
      shadow_flags = select(on_light, Uint<L>(kShadowFromHiddenLight), shadow_flags);
    else
      seen = seen & !on_light;
  }
  if (!any(seen)) return;
  wave.raster_positions.store<L>(column, {view.film_x, view.film_y});

  // Evaluate the adjoint BSDF
  const Vec3<L> towards = normalize(view.target - item.p);
  const ShadingFrame<L, Bsdf<L>::kIsAnisotropic> frame(item);
  const Bsdf<L> bsdf = load_bsdf<L, Bsdf>(context.scene, wave, column);
  const Vec3<L> wi = frame.to_local(towards);
  Spectrum<L> f_cos = adjoint_f_cos<L>(bsdf, item.wo, wi);
  if constexpr (!kIsPhaseFunction<Bsdf<L>>) {
    const Vec3<L> arriving = frame.to_world(item.wo);
    f_cos = f_cos * (adjoint_cosines<L>(item, arriving, towards, wi.z) * adjoint_scale<L>(bsdf, item.wo, wi));
    if (mapped) {
      const TexturedItem<L> t = wave.textured.load<L>(column);
      f_cos = f_cos * adjoint_terminator<L>(t, arriving, item.wo.z);
      f_cos = select<L>(matches_normal_choice<L>(t, item.ns, towards), f_cos, Spectrum<L>(F(0.0f)));
    }
  }
  // Push the shadow ray
  const Spectrum<L> out = path.beta * f_cos * (flux * view.importance);
  push_shadow_ray<L>(context.scene, wave, slots, count, item,
                     {view.target, F(0.0f), Uint<L>(kNone), Uint<L>(kNone), shadow_flags},
                     select<L>(seen & is_finite(total(out)), out, Spectrum<L>(F(0.0f))), kIsPhaseFunction<Bsdf<L>>,
                     loses_wavelengths<L>(bsdf, item.wo, wi));
}

template <class L, template <class> class Bsdf>
void connect_run(const StageContext& context, Wave& wave, const VertexRun& run) {
  const bool mapped = (context.scene.materials.buckets.kind_flags[static_cast<int>(kKindOf<Bsdf<L>>)] & kMapped) != 0;
  for_tiles<L>(run.count, [&](int i, int count) {
    connect_tile<L, Bsdf>(context, wave, wave.sorted.data() + run.slot_begin + i, run.column_begin + i, count, mapped);
  });
}

}  // namespace

template <class L> void camera_connections(const StageContext& context, Wave& wave) noexcept {
  StageTimer timer(wave.stats, stage_named<L>("camera_connections"));
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if constexpr (!Bsdf<L>::kIsSpecular) {
      const VertexRun& run = wave.runs[static_cast<int>(kind)];
      timer.count(run.count, L::width);
      connect_run<L, Bsdf>(context, wave, run);
    }
  });
}

SHEAF_INSTANTIATE_STAGE(camera_connections);

}  // namespace sheaf
