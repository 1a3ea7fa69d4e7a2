// Stage: surface inputs. From hits to what closures need: position, normals, the viewing direction in the shading frame,
// and the closure's parameters.
#include "kernels/bsdf/all.h"
#include "kernels/stage_timer.h"
#include "kernels/stages.h"
#include "scene/shape.h"

namespace sheaf {

namespace {

/// `Words`: of the closure's parameters, rounded up to whole quads.
template <class L, int Words>
SHEAF_INLINE void surface_tile(const SceneView& scene, Wave& wave, const Slot* slots, int column) {
  using F = Float<L>;
  using U = Uint<L>;
  const RayState<L> ray = wave.rays.gather<L>(slots);
  const HitState<L> hit = wave.hits.gather<L>(slots);
  const ShapeLanes<L> shape = load_shapes<L>(scene, hit.shape);
  const auto y = surface_point<L>(scene, shape, hit.primitive, hit.u, hit.v, ray.origin + ray.direction * hit.t);

  constexpr int kHeadWords = 4;
  const U index = hit.material * U(sizeof(MaterialRow) / sizeof(float));
  F row[kHeadWords + Words];
  for (int k = 0; k < kHeadWords + Words; k += 4)
    gather_row4<L>(reinterpret_cast<const float*>(scene.materials) + k, index, row + k);
  const auto two_sided = float_bits(row[2]) != U(0u);
  const auto behind = dot(y.ns, ray.direction) > F(0.0f);

  SurfaceItem<L> item;
  item.p = y.p;
  item.ng = y.ng;
  item.ns = select<L>(two_sided & behind, -y.ns, y.ns);
  item.wo = Frame<L>::from_normal(item.ns).to_local(-ray.direction);
  item.offset = y.offset;
  wave.items.store<L>(column, item);

  float* const* closure = wave.closures.columns().words;
  for (int k = 0; k < Words; ++k) store(closure[k] + column, row[kHeadWords + k]);
}

}  // namespace

template <class L> void surface_inputs(const SceneView& scene, Wave& wave) noexcept {
  StageTimer timer(wave.stats, Stage::kSurfaceInputs);
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    constexpr int kWords = (kLeafCount<Bsdf> + 3) / 4 * 4;
    const SurfaceRun& run = wave.runs[static_cast<int>(kind)];
    timer.count(run.count, L::width);
    for_tiles<L>(run.count, [&](int i, int) {
      surface_tile<L, kWords>(scene, wave, wave.sorted.data() + run.slot_begin + i, run.column_begin + i);
    });
  });
}

SHEAF_INSTANTIATE_STAGE(surface_inputs);

}  // namespace sheaf
