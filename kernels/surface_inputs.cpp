// Stage: surface inputs. From hits to what closures need: position, normals, the viewing direction in the shading frame,
// and the closure's parameters.
#include "kernels/stage_timer.h"
#include "kernels/stages.h"
#include "scene/shape.h"

namespace sheaf {

namespace {

template <class L>
SHEAF_INLINE void surface_tile(const SceneView& scene, Wave& wave, const Slot* slots, int column, int words) {
  using F = Float<L>;
  using U = Uint<L>;
  const RayState<L> ray = wave.rays.gather<L>(slots);
  const HitState<L> hit = wave.hits.gather<L>(slots);
  const ShapeLanes<L> shape = load_shapes<L>(scene, hit.shape);
  const auto y = surface_point<L>(scene, shape, hit.primitive, hit.u, hit.v, ray.origin + ray.direction * hit.t);

  const auto* materials = reinterpret_cast<const float*>(scene.materials);
  const U row = hit.material * U(sizeof(MaterialRow) / sizeof(float));
  F head[4];
  gather_row4<L>(materials, row, head);
  const auto two_sided = float_bits(head[2]) != U(0u);
  const auto behind = dot(y.ns, ray.direction) > F(0.0f);

  SurfaceItem<L> item;
  item.p = y.p;
  item.ng = y.ng;
  item.ns = select<L>(two_sided & behind, -y.ns, y.ns);
  item.wo = Frame<L>::from_normal(item.ns).to_local(-ray.direction);
  item.offset = y.offset;
  wave.items.store<L>(column, item);

  float* const* closure = wave.closures.columns().words;
  constexpr int kHeadWords = 4;
  for (int k = 0; k < words; k += 4) {
    F quad[4];
    gather_row4<L>(materials + kHeadWords + k, row, quad);
    for (int j = 0; j < 4; ++j) store(closure[k + j] + column, quad[j]);
  }
}

}  // namespace

template <class L> void surface_inputs(const SceneView& scene, Wave& wave) noexcept {
  StageTimer timer(wave.stats, Stage::kSurfaceInputs);
  constexpr int kWords[kClosureKinds] = {kLeafCount<DiffuseParameters>, kLeafCount<ConductorParameters>,
                                         kLeafCount<DielectricParameters>};
  for (int kind = 0; kind < kClosureKinds; ++kind) {
    const SurfaceRun& run = wave.runs[kind];
    timer.count(run.count, L::width);
    for_tiles<L>(run.count, [&](int i, int) {
      surface_tile<L>(scene, wave, wave.sorted.data() + run.slot_begin + i, run.column_begin + i, kWords[kind]);
    });
  }
}

SHEAF_INSTANTIATE_STAGE(surface_inputs);

}  // namespace sheaf
