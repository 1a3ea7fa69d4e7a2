// Stage: textures. Processes runs of one material: replaces closure parameters by texture values, orients
// rotations of anisotropy, and applies normal and bump maps.
#include "kernels/bsdf/list.h"
#include "kernels/stages/adjoint.h"
#include "kernels/stages/normal_map.h"
#include "kernels/stages/shading_frame.h"
#include "kernels/stages/shading_texture.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Lanes [first, last) of the tile at `column`. `slots`: of the whole tile.
template <class L> struct TextureTile {
  const Slot* slots;
  int column, first, last;

  SHEAF_INLINE Mask<L> lanes() const { return L::first(last) & !L::first(first); }
};

/// Loads a pair of columns of `TexturedItem`.
template <class L> SHEAF_INLINE Vec2<L> load_pair(const Vec2<Columns>& columns, int column) {
  Vec2<L> pair;
  load(columns.x + column, pair.x);
  load(columns.y + column, pair.y);
  return pair;
}

template <class L>
SHEAF_INLINE TextureQuery<L> make_query(const Wave& wave, const Slot* slots, const TexturedItem<L>& t, Vec3<L> p) {
  const HitState<L> hit = wave.hits.gather<L>(slots);
  return {t.uv, hit.shape, hit.primitive, hit.u, hit.v, p, t.footprint, t.footprint_axis};
}

/// Whether the textures of a material's parameters depend only on uv coordinates.
bool needs_only_uv(const SceneView& scene, const MaterialRow& material) {
  const auto needs_nothing_else = [&](const TextureBinding& binding) {
    return scene.textures.rows[binding.texture].needs == 0;
  };
  const TextureBinding* const first = scene.materials.bindings + material.first_binding;
  return std::all_of(first, first + material.binding_count, needs_nothing_else);
}

template <class L, ColorMode kMode>
void texture_words(const SceneView& scene, Wave& wave, const MaterialRow& material, const TextureTile<L>& tile) {
  using F = Float<L>;
  const auto& columns = wave.textured.columns();
  TextureQuery<L> query{load_pair<L>(columns.uv, tile.column), {}, {}, {}, {}};
  query.footprint = load_pair<L>(columns.footprint, tile.column);
  query.footprint_axis = load_pair<L>(columns.footprint_axis, tile.column);
  if (!needs_only_uv(scene, material))
    query = make_query<L>(wave, tile.slots, wave.textured.load<L>(tile.column), wave.vertices.load<L>(tile.column).p);
  const auto lanes = tile.lanes();
  const Spectrum<L> lambda = shading_wavelengths<L, kMode>(wave, tile.slots);
  for (std::uint32_t b = 0; b < material.binding_count; ++b) {
    const TextureBinding& binding = scene.materials.bindings[material.first_binding + b];
    const Spectrum<L> value = shading_texture<L, kMode>(scene, binding, query, lambda);
    const F channels[4] = {value.c0, value.c1, value.c2, value.c3};
    for (std::uint32_t k = 0; k < binding.words; ++k) {
      float* words = wave.closures.columns().words[binding.word + k] + tile.column;
      F constant;
      load(words, constant);
      store(words, select(lanes, channels[k], constant));
    }
  }
}

/// Negates an angle from the tangent where the shading frame is mirrored.
template <class L> void orient_rotation(Wave& wave, std::uint32_t word, const TextureTile<L>& tile) {
  float* const angles = wave.closures.columns().words[word] + tile.column;
  const TexturedItem<L> t = wave.textured.load<L>(tile.column);
  Float<L> angle;
  load(angles, angle);
  store(angles, select(tile.lanes(), angle * handedness_of<L>(t.ns_unmapped, t.dp_du, t.dp_dv), angle));
}

/// Selects at random between a mapped normal and its mirror image for photons, and divides the throughput by the
/// probability. `may_choose`: lanes where both may be visible. Returns the lanes with the mirror image.
template <class L>
Mask<L> choose_normal(const StageContext& context, Wave& wave, const TextureTile<L>& tile, Float<L> cos_tilt,
                      Mask<L> may_choose, TexturedItem<L>& t) {
  using F = Float<L>;
  PathState<L> path = wave.paths.gather<L>(tile.slots);
  const F probability = mirrored_probability(cos_tilt);
  const auto choice = may_choose & (probability > F(0.0f));
  const auto mirrored =
      choice &
      (draw<L>(context.sampler, path.pixel, path.sample, path.dimension(), SampleBlock::kResample, {}, kNumberX).x <
       probability);
  const F of_this = select(choice, select(mirrored, probability, F(1.0f) - probability), F(1.0f));
  path.beta = path.beta * (F(1.0f) / of_this);
  wave.paths.scatter<L>(tile.slots, tile.last, path);
  t.normal_choice = select(choice, select(mirrored, F(-1.0f), F(1.0f)), t.normal_choice);
  return mirrored;
}

template <class L, bool kWithTangent>
void map_normals(const StageContext& context, Wave& wave, const MaterialRow& material, const TextureTile<L>& tile) {
  const SceneView& scene = context.scene;
  VertexItem<L> item = wave.vertices.load<L>(tile.column);
  TexturedItem<L> t = wave.textured.load<L>(tile.column);
  const NormalMapRow& map = scene.materials.normal_maps[material.map];
  const auto query = make_query<L>(wave, tile.slots, t, item.p);
  const auto lanes = tile.lanes();

  const Vec3<L> base = item.ns;
  // Evaluate the map
  Mask<L> usable(false);
  Vec3<L> n = perturbed_normal<L>(scene.textures, map, query, base, t.handedness, t.dp_du, t.dp_dv, lanes, usable);

  const Vec3<L> wo = ShadingFrame<L, kWithTangent>(base, item.tangent).to_world(item.wo);
  // Mirror normals that face away from the viewer
  if (map.flags & NormalMapRow::kFixInvalid) {
    const auto mirrored = !context.starts_at_lights() ? faces_away<L>(n, base, wo)
                                                      : choose_normal<L>(context, wave, tile, dot(n, base), usable, t);
    n = select<L>(mirrored, mirrored_normal<L>(n, base), n);
  }
  // Update the shading frame
  item.ns = n;
  const Frame<L> rotated = Frame<L>::from_normal(n);
  if constexpr (kWithTangent) {
    const Vec2<L> tangent = tangent_of<L>(rotated, t.dp_du);
    item.tangent = {select(lanes, tangent.x, item.tangent.x), select(lanes, tangent.y, item.tangent.y)};
  }
  item.wo = select<L>(lanes, ShadingFrame<L, kWithTangent>(n, item.tangent).to_local(wo), item.wo);
  if (map.flags & NormalMapRow::kSoften) t.terminator = select(lanes, terminator_of(dot(n, base)), t.terminator);
  wave.vertices.store<L>(tile.column, item);
  wave.textured.store<L>(tile.column, t);
}

/// Items [first, last) of a run, all of one material.
struct MaterialRun {
  const MaterialRow* material = nullptr;  ///< null: no items
  int first = 0, last = 0;
};

/// Prefetches the texels of the items.
template <class L>
void prefetch_run(const SceneView& scene, const Wave& wave, const VertexRun& run, const MaterialRun& part) {
  const MaterialRow& material = *part.material;
  for (int at = part.first / L::width * L::width; at < part.last; at += L::width) {
    const auto& columns = wave.textured.columns();
    const Vec2<L> uv = load_pair<L>(columns.uv, run.column_begin + at);
    const Vec2<L> footprint = load_pair<L>(columns.footprint, run.column_begin + at);
    for (std::uint32_t b = 0; b < material.binding_count; ++b)
      prefetch_texture<L>(scene.textures, scene.materials.bindings[material.first_binding + b].texture, uv, footprint);
    if (material.flags & kMapped)
      prefetch_texture<L>(scene.textures, scene.materials.normal_maps[material.map].texture, uv, footprint);
  }
}

template <class L, bool kWithTangent>
void texture_run(const StageContext& context, Wave& wave, const VertexRun& run, const MaterialRun& part) {
  const SceneView& scene = context.scene;
  const MaterialRow& material = *part.material;
  const Slot* slots = wave.sorted.data() + run.slot_begin;
  for (int at = part.first / L::width * L::width; at < part.last; at += L::width) {
    const TextureTile<L> tile{slots + at, run.column_begin + at, std::max(part.first - at, 0),
                              std::min(part.last - at, int{L::width})};
    if (material.binding_count > 0)
      with_color_mode(scene, [&]<ColorMode kMode>() { texture_words<L, kMode>(scene, wave, material, tile); });
    if (const std::uint32_t word = material.flags >> kRotationWordShift; word != 0)
      orient_rotation<L>(wave, word - 1, tile);
    if (material.flags & kMapped) map_normals<L, kWithTangent>(context, wave, material, tile);
  }
}

/// Processes the vertices of a kind. Texels are prefetched a few registers before their lookup, so that most have
/// arrived from memory by then. Returns the number of textured vertices.
template <class L, bool kWithTangent> int texture_kind(const StageContext& context, Wave& wave, const VertexRun& run) {
  constexpr int kTilesAhead = 4;
  const SceneView& scene = context.scene;
  const Slot* slots = wave.sorted.data() + run.slot_begin;
  const auto material_of = [&](int i) { return wave.hits.row(slots[i]).material; };
  int textured = 0;
  MaterialRun prefetched;
  for (int first = 0; first < run.count;) {
    const std::uint32_t material = material_of(first);
    const int end = std::min(run.count, (first / L::width + kTilesAhead) * L::width);
    int last = first + 1;
    while (last < end && material_of(last) == material) ++last;
    if (scene.materials.rows[material].flags & kNeedsUv) {
      const MaterialRun next{&scene.materials.rows[material], first, last};
      prefetch_run<L>(scene, wave, run, next);
      if (prefetched.material != nullptr) texture_run<L, kWithTangent>(context, wave, run, prefetched);
      prefetched = next;
      textured += last - first;
    }
    first = last;
  }
  if (prefetched.material != nullptr) texture_run<L, kWithTangent>(context, wave, run, prefetched);
  return textured;
}

}  // namespace

template <class L> void textures(const StageContext& context, Wave& wave) noexcept {
  bool any_textured = false;
  for (int kind = 0; kind < kClosureKinds; ++kind)
    any_textured = any_textured ||
                   (wave.runs[kind].count > 0 && (context.scene.materials.buckets.kind_flags[kind] & kNeedsUv) != 0);
  if (!any_textured) return;
  StageTimer timer(wave.stats, stage_named<L>("textures"));
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    const auto k = static_cast<int>(kind);
    if ((context.scene.materials.buckets.kind_flags[k] & kNeedsUv) == 0) return;
    timer.count(texture_kind<L, Bsdf<L>::kIsAnisotropic>(context, wave, wave.runs[k]), L::width);
  });
}

SHEAF_INSTANTIATE_STAGE(textures);

}  // namespace sheaf
