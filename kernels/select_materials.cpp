// Stage: select materials. A mask is its material or nothing, a blend is one of two, each with the probability of its
// share; the choice then holds for light sampling and scattering alike. Where nothing is chosen the ray goes on.
#include "core/sampler.h"
#include "kernels/medium_boundary.h"
#include "kernels/passing_share.h"
#include "kernels/route_hits.h"
#include "kernels/stage_timer.h"
#include "kernels/stages.h"
#include "scene/texture_lookup.h"

namespace sheaf {

namespace {

/// The second choice's share for lanes of different materials, one material after the other.
template <class L>
Float<L> share_of(const SceneView& scene, Mask<L> lanes, Uint<L> row, const TextureQuery<L>& query) {
  using F = Float<L>;
  using U = Uint<L>;
  F share(0.0f);
  alignas(kSimdAlignment) std::uint32_t rows[L::width];
  store(rows, row);
  while (any(lanes)) {
    const std::uint32_t material = rows[std::countr_zero(mask_bits(lanes))];
    const MaterialRow& m = scene.materials[material];
    const auto same = lanes & (row == U(material));
    F value(m.words[0]);
    if (m.binding_count > 0) value = lookup_scalar<L>(scene.textures, scene.bindings[m.first_binding].texture, query);
    share = select(same, value, share);
    lanes = lanes & !same;
  }
  return share;
}

template <class L> SHEAF_INLINE Uint<L> material_word(const SceneView& scene, Uint<L> row, std::size_t offset) {
  return gather(reinterpret_cast<const std::uint32_t*>(scene.materials) + offset / sizeof(std::uint32_t),
                row * Uint<L>(sizeof(MaterialRow) / sizeof(std::uint32_t)));
}

/// The rays of `lanes` are that much longer than before.
template <class L>
SHEAF_INLINE void add_travelled(Wave& wave, const Slot* slots, std::uint32_t lanes, Float<L> distance) {
  alignas(kSimdAlignment) float more[L::width];
  store(more, distance);
  for (; lanes != 0; lanes &= lanes - 1) {
    const int lane = std::countr_zero(lanes);
    wave.travelled[slots[lane]] += more[lane];
  }
}

/// Light sampling passes the surface with certainty, and the light is weakened; the paths of `lanes` have passed with
/// the probability that is the weakening.
template <class L>
SHEAF_INLINE void note_passing(const SceneView& scene, Wave& wave, const Slot* slots, std::uint32_t lanes,
                               const TextureQuery<L>& query, Uint<L> material, Mask<L> behind) {
  alignas(kSimdAlignment) float uv[4][L::width];
  alignas(kSimdAlignment) std::uint32_t words[3][L::width];
  store(uv[0], query.uv.x), store(uv[1], query.uv.y), store(uv[2], query.b1), store(uv[3], query.b2);
  store(words[0], query.shape), store(words[1], query.primitive), store(words[2], material);
  const std::uint32_t from_behind = mask_bits(behind);
  for (; lanes != 0; lanes &= lanes - 1) {
    const int i = std::countr_zero(lanes);
    const float share = passing_share(scene, words[2][i], (from_behind >> i & 1u) != 0,
                                      {{uv[0][i], uv[1][i]}, words[0][i], words[1][i], uv[2][i], uv[3][i]});
    if (share == 1.0f) continue;
    float* r_l = wave.probabilities.row(slots[i]) + 4;
    for (int lane = 0; lane < 4; ++lane) r_l[lane] /= max(share, 1e-20f);
  }
}

template <class L> SHEAF_INLINE void select_tile(const SceneView& scene, Wave& wave, const Slot* slots, int count) {
  using F = Float<L>;
  using U = Uint<L>;
  RayState<L> ray = wave.rays.gather<L>(slots);
  HitState<L> hit = wave.hits.gather<L>(slots);
  ThroughputState<L> path = wave.throughput.gather<L>(slots);
  const ShapeLanes<L> shape = load_shapes<L>(scene, hit.shape);
  const auto y = surface_point<L, true>(scene, shape, hit.primitive, hit.u, hit.v, ray.origin + ray.direction * hit.t,
                                        hit.instance);
  const TextureQuery<L> query{y.uv, hit.shape, hit.primitive, hit.u, hit.v};
  const auto behind = dot(y.ng, ray.direction) > F(0.0f);
  F u = draw<L>(scene.sampler, path.pixel, path.sample, path.event(), SampleBlock::kSelect).x;

  U row = hit.material;
  const U nothing(MaterialRow::kNothing);
  auto open = L::first(count);
  for (;;) {
    const U safe = select(open, row, U(0u));
    const U flags = material_word<L>(scene, safe, offsetof(MaterialRow, flags));
    open = open & ((flags & U(kComposite)) != U(0u));
    if (!any(open)) break;
    // What is left of the random number after a choice is as good as new.
    const F share = clamp(share_of<L>(scene, open, safe, query), F(0.0f), F(1.0f));
    const auto second = u < share;
    u = select(second, u / max(share, F(1e-20f)), (u - share) / max(F(1.0f) - share, F(1e-20f)));
    u = clamp(u, F(0.0f), F(0.99999994f));
    const U chosen = select(second, material_word<L>(scene, safe, offsetof(MaterialRow, choice) + 4),
                            material_word<L>(scene, safe, offsetof(MaterialRow, choice)));
    row = select(open, chosen, row);
    open = open & (row != nothing);
    const U back = material_word<L>(scene, select(open, row, U(0u)), offsetof(MaterialRow, back));
    row = select(open & behind, back, row);
  }

  const auto passing = row == nothing;
  hit.material = row;
  wave.hits.scatter<L>(slots, count, hit);
  const std::uint32_t all_bits = (1u << count) - 1u;
  const std::uint32_t pass = mask_bits(passing & L::first(count));
  std::uint32_t last = mask_bits((ray.flags & U(kRayLast)) != U(0u));
  if (scene.integrator.free_panes) last &= ~mask_bits(is_pane<L>(scene, select(passing, U(0u), row)));
  std::uint32_t ended = all_bits & ~pass & last;
  wave.surface.push(slots, all_bits & ~pass & ~last);
  if (pass != 0) {
    const auto too_long = !(path.event() < U(kLongestPath));
    const std::uint32_t going = pass & ~mask_bits(too_long);
    ended |= pass & ~going;
    ray.origin = select<L>(passing, offset_origin<L>(y.p, y.ng, y.offset, ray.direction), ray.origin);
    ray.flags = select(passing, medium_behind<L>(scene, shape.boundary, y.ng, ray.direction, ray.flags), ray.flags);
    wave.rays.scatter<L>(slots, count, ray);
    add_travelled<L>(wave, slots, pass, hit.t);
    note_passing<L>(scene, wave, slots, pass, query, shape.material, behind);
    path.progress = select(passing, path.progress + U(kOneEvent), path.progress);
    wave.throughput.scatter<L>(slots, count, path);
    wave.stats.rays.scatter += static_cast<std::uint64_t>(std::popcount(going));
    wave.active.push(slots, going);
  }
  wave.finished.push(slots, ended);
}

}  // namespace

template <class L> void select_materials(const SceneView& scene, Wave& wave) noexcept {
  const int hits = wave.composite.size();
  if (hits == 0) return;
  StageTimer timer(wave.stats, Stage::kSelectMaterials);
  timer.count(hits, L::width);
  wave.composite.pad();
  for_tiles<L>(hits, [&](int i, int count) { select_tile<L>(scene, wave, wave.composite.data() + i, count); });
  wave.composite.clear();
}

SHEAF_INSTANTIATE_STAGE(select_materials);

}  // namespace sheaf
