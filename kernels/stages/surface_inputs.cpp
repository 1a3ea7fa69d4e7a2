// Stage: surface inputs. Computes the inputs of closures from hits: position, normals, the viewing direction in the
// shading frame, and the closure's parameters.
#include "core/soa/lane_array.h"
#include "kernels/bsdf/list.h"
#include "kernels/media/moving_medium.h"
#include "kernels/stages/ray_footprint.h"
#include "kernels/stages/shading_frame.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"
#include "scene/surfaces/shape.h"

namespace sheaf {

namespace {

/// Properties of a closure kind. Not template parameters, so that all kinds share one copy of the code.
struct KindInputs {
  int words;         ///< number of the closure's parameters
  bool anisotropic;  ///< the shading frame follows the tangent
  /// Some materials of the kind have textures or maps. Then all vertices of the kind get the inputs of textures: both
  /// code paths round differently, and results must not depend on which vertices share a register.
  bool textured;
  bool in_medium;          ///< a phase function
  bool flakes;             ///< a phase function with parameters from the medium (microflakes)
  ClosureSpectra spectra;  ///< offsets among the parameters
};

/// Copies the closure's parameters from the material table.
template <class L>
SHEAF_INLINE void closure_words(const SceneView& scene, Wave& wave, Uint<L> material, int words, int column) {
  float* const* closure = wave.closures.columns().words;
  for (int k = 0; k < words; k += 4) {
    Float<L> quad[4];
    gather_four<L>(scene.materials.rows, &MaterialRow::words, k, material, quad);
    for (int i = 0; i < 4; ++i) store(closure[k + i] + column, quad[i]);
  }
}

/// Spectral mode: replaces the material's colors by spectra at the path's wavelengths.
template <class L>
SHEAF_INLINE void closure_spectra_words(const SceneView& scene, Wave& wave, const Slot* slots, Uint<L> material,
                                        const ClosureSpectra& spectra, int column) {
  const Spectrum<L> lambda = path_wavelengths<L>(wave, slots);
  float* const* closure = wave.closures.columns().words;
  for (int k = 0; k < spectra.count; ++k) {
    const Spectrum<L> value = closure_spectrum<L>(scene, material, k, lambda);
    float* const* words = closure + spectra.word[k];
    store(words[0] + column, value.c0);
    store(words[1] + column, value.c1);
    store(words[2] + column, value.c2);
    store(words[3] + column, value.c3);
  }
}

/// Computes a surface vertex. `kTextured`: with the inputs of textures.
template <class L, bool kTextured>
SHEAF_INLINE void surface_item(const StageContext& context, Wave& wave, const Slot* slots, const RayState<L>& ray,
                               const HitState<L>& hit, Uint<L> flags, int column, bool with_tangent) {
  using F = Float<L>;
  using U = Uint<L>;
  const SceneView& scene = context.scene;
  const ShapeRecord<L> shape = gather_rows<L>(scene.geometry.shapes, hit.shape);
  const auto y =
      surface_point<L, kTextured>(scene, shape, hit.primitive, hit.u, hit.v, ray.origin + ray.direction * hit.t,
                                  hit.instance, path_times<L>(scene, wave, slots));
  const auto flipped = ((flags & U(kTwoSided)) != U(0u)) & (dot(y.ns, ray.direction) > F(0.0f));
  VertexItem<L> item;
  item.p = y.p;
  item.ng = y.ng;
  item.ns = select<L>(flipped, -y.ns, y.ns);
  item.offset = y.offset;
  item.tangent = {F(1.0f), F(0.0f)};
  if constexpr (kTextured) {
    if (with_tangent) item.tangent = tangent_of<L>(Frame<L>::from_normal(item.ns), y.dp_du);
    const RayFootprint<L> footprint = ray_footprint<L>(context, wave, slots, ray, hit.t, y);
    wave.textured.store<L>(column, {y.uv, y.dp_du, y.dp_dv, item.ns, select(flipped, F(-1.0f), F(1.0f)), F(0.0f),
                                    F(0.0f), footprint.squared_lengths, footprint.axis});
  }
  item.wo = ShadingFrame<L, kTextured>(item).to_local(-ray.direction);
  wave.vertices.store<L>(column, item);
}

/// Computes a vertex in a medium. Its frame looks back along the ray.
template <class L>
SHEAF_INLINE void medium_item(Wave& wave, const RayState<L>& ray, const HitState<L>& hit, int column) {
  using F = Float<L>;
  VertexItem<L> item;
  item.p = ray.origin + ray.direction * hit.t;
  item.ng = item.ns = -ray.direction;
  item.wo = {F(0.0f), F(0.0f), F(1.0f)};
  item.offset = F(0.0f);
  item.tangent = {F(1.0f), F(0.0f)};
  wave.vertices.store<L>(column, item);
}

/// Writes the microflake parameters of the paths' media to the closure's columns.
template <class L>
[[gnu::noinline]] void flake_words(const SceneView& scene, Wave& wave, const Slot* slots, const RayState<L>& ray,
                                   int column) {
  using F = Float<L>;
  const VertexItem<L> item = wave.vertices.load<L>(column);
  const LaneRows<L, Vec3> p(item.p);
  const LaneArray<Uint<L>> flags(ray.flags);
  const LaneArray<F> times(path_times<L>(scene, wave, slots));
  alignas(kSimdAlignment) float entries[6][L::width] = {};
  for (int lane = 0; lane < L::width; ++lane) {
    const std::uint32_t medium = flags[lane] >> kRayMediumShift;
    // Lanes behind the end of the run may hold anything.
    if (medium == 0 || (scene.media.rows[medium - 1].flags & kMediumFlakes) == 0) continue;
    const FlakeMatrix s = flake_matrix_at(scene, medium - 1, p[lane], times[lane]);
    for (int k = 0; k < 6; ++k) entries[k][lane] = s.entries[k];
  }
  F matrix[6];
  for (int k = 0; k < 6; ++k) load(entries[k], matrix[k]);
  const SggxParameters<L> words = sggx_parameters<L>(matrix, Frame<L>::from_normal(item.ns));
  float* const* closure = wave.closures.columns().words;
  std::apply(
      [&](const auto&... word) {
        int k = 0;
        (store(closure[k++] + column, word), ...);
      },
      leaves(words));
}

template <class L, ColorMode kMode>
SHEAF_INLINE void surface_tile(const StageContext& context, Wave& wave, const Slot* slots, int column,
                               const KindInputs& kind) {
  const SceneView& scene = context.scene;
  const RayState<L> ray = wave.rays.gather<L>(slots);
  const HitState<L> hit = wave.hits.gather<L>(slots);
  if (kind.in_medium) {
    medium_item<L>(wave, ray, hit, column);
    closure_words<L>(scene, wave, hit.material, kind.words, column);
    if (kind.flakes) flake_words<L>(scene, wave, slots, ray, column);
    return;
  }
  const Uint<L> flags = gather_member<L>(scene.materials.rows, &MaterialRow::flags, hit.material);
  if (kind.textured) {
    surface_item<L, true>(context, wave, slots, ray, hit, flags, column, kind.anisotropic);
  } else {
    surface_item<L, false>(context, wave, slots, ray, hit, flags, column, kind.anisotropic);
  }
  closure_words<L>(scene, wave, hit.material, kind.words, column);
  if constexpr (kMode == ColorMode::kSpectral)
    closure_spectra_words<L>(scene, wave, slots, hit.material, kind.spectra, column);
}

template <class L, ColorMode kMode>
void surface_run(const StageContext& context, Wave& wave, const VertexRun& run, const KindInputs& kind) {
  for_tiles<L>(run.count, [&](int i, int) {
    surface_tile<L, kMode>(context, wave, wave.sorted.data() + run.slot_begin + i, run.column_begin + i, kind);
  });
}

}  // namespace

template <class L> void surface_inputs(const StageContext& context, Wave& wave) noexcept {
  StageTimer timer(wave.stats, stage_named<L>("surface_inputs"));
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    const VertexRun& run = wave.runs[static_cast<int>(kind)];
    if (run.count == 0) return;
    const bool textured =
        (context.scene.materials.buckets.kind_flags[static_cast<int>(kind)] & (kMapped | kNeedsUv)) != 0;
    timer.count(run.count, L::width);
    const KindInputs inputs{kLeafCount<Bsdf>,          Bsdf<L>::kIsAnisotropic,           textured,
                            kIsPhaseFunction<Bsdf<L>>, kind == kClosureKind<SggxClosure>, closure_spectra<Bsdf>()};
    with_color_mode(context.scene, [&]<ColorMode kMode>() { surface_run<L, kMode>(context, wave, run, inputs); });
  });
}

SHEAF_INSTANTIATE_STAGE(surface_inputs);

}  // namespace sheaf
