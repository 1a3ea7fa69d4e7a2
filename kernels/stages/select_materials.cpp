// Stage: select materials. Selects a mask's material or "nothing", and one of the two materials of a blend, in
// proportion to their weights. The selected part determines where the path continues; kernels/stages/blend_value.h adds
// the contribution of the other parts. If "nothing" is selected, the ray continues behind the surface.
#include "core/sampling/sampler.h"
#include "core/soa/lane_array.h"
#include "kernels/media/pass_through_probability.h"
#include "kernels/stages/continue_ray.h"
#include "kernels/stages/route_hits.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/stage_timer.h"
#include "scene/textures/texture_lookup.h"

namespace sheaf {

namespace {

/// Weights of the second choice for lanes of different materials, one material at a time.
template <class L>
Float<L> second_weights(const SceneView& scene, Mask<L> lanes, Uint<L> row, const TextureQuery<L>& query) {
  using F = Float<L>;
  using U = Uint<L>;
  F probability(0.0f);
  const LaneArray<U> rows(row);
  while (any(lanes)) {
    const std::uint32_t material = rows[std::countr_zero(mask_bits(lanes))];
    const MaterialRow& m = scene.materials.rows[material];
    const auto same = lanes & (row == U(material));
    F value(m.second_weight());
    if (m.binding_count > 0)
      value = lookup_scalar<L>(scene.textures, scene.materials.bindings[m.first_binding].texture, query);
    probability = select(same, value, probability);
    lanes = lanes & !same;
  }
  return probability;
}

/// The first selection of a tile's paths.
template <class L> struct FirstChoice {
  typename L::Uint row;           ///< the composite material
  typename L::Float probability;  ///< of its second choice
};

/// Pass-through probabilities of simple masks: one of the two choices is "nothing", and the other is not composite.
/// Same values as pass_through_probability(), without another texture lookup.
template <class L> struct KnownWeights {
  typename L::Float probability;
  typename L::Mask known;
};

template <class L>
SHEAF_INLINE KnownWeights<L> mask_weights(const SceneView& scene, const FirstChoice<L>& first, Uint<L> material,
                                          Mask<L> behind, Mask<L> lanes) {
  using F = Float<L>;
  using U = Uint<L>;
  const MaterialRow* const rows = scene.materials.rows;
  const U nothing(MaterialRow::kNothing), zero(0u);
  const auto side_of = [&](U row) SHEAF_LAMBDA_INLINE {
    return select(behind, gather_member<L>(rows, &MaterialRow::back, row), row);
  };
  const U composite = select(lanes, first.row, zero);
  const U choice[2] = {gather_element<L>(rows, &MaterialRow::choice, 0, composite),
                       gather_element<L>(rows, &MaterialRow::choice, 1, composite)};
  const auto second_passes = choice[1] == nothing;
  const U other = select(second_passes, choice[0], choice[1]);
  Mask<L> known = lanes & (second_passes | (choice[0] == nothing)) & (other != nothing);
  const U flags = gather_member<L>(rows, &MaterialRow::flags, side_of(select(known, other, zero)));
  known = known & ((flags & U(kComposite)) == zero) & (side_of(select(lanes, material, zero)) == first.row);
  return {select(second_passes, first.probability, F(1.0f) - first.probability), known};
}

/// Divides r_l of the paths of `lanes` by the pass-through probability. Paths pass the surface with that probability;
/// light sampling passes with certainty and attenuates the light instead.
template <class L>
SHEAF_INLINE void note_passing(const SceneView& scene, Wave& wave, const Slot* slots, std::uint32_t lanes,
                               const TextureQuery<L>& query, Uint<L> material, Mask<L> behind,
                               const KnownWeights<L>& masks) {
  const std::uint32_t known = mask_bits(masks.known), from_behind = mask_bits(behind);
  const LaneArray<Float<L>> probabilities(masks.probability);
  const LaneArray<Uint<L>> materials(material);
  const LaneRows<L, TextureQuery> queries(query);
  for_each_lane(lanes, [&](int lane) SHEAF_LAMBDA_INLINE {
    float probability = probabilities[lane];
    if ((known >> lane & 1u) == 0)
      probability = pass_through_probability(scene, materials[lane], (from_behind >> lane & 1u) != 0, queries[lane]);
    if (probability == 1.0f) return;
    Spectrum4& r_l = wave.rescaled_pdfs.row(slots[lane]).r_l;
    const float divisor = max(probability, 1e-20f);
    r_l = {r_l.c0 / divisor, r_l.c1 / divisor, r_l.c2 / divisor, r_l.c3 / divisor};
  });
}

template <class L>
SHEAF_INLINE void select_tile(const StageContext& context, Wave& wave, const Slot* slots, int count) {
  using F = Float<L>;
  using U = Uint<L>;
  const RayState<L> ray = wave.rays.gather<L>(slots);
  HitState<L> hit = wave.hits.gather<L>(slots);
  const PathState<L> path = wave.paths.gather<L>(slots);
  const ShapeRecord<L> shape = gather_rows<L>(context.scene.geometry.shapes, hit.shape);
  const auto y =
      surface_point<L, true>(context.scene, shape, hit.primitive, hit.u, hit.v, ray.origin + ray.direction * hit.t,
                             hit.instance, path_times<L>(context.scene, wave, slots));
  const TextureQuery<L> query{y.uv, hit.shape, hit.primitive, hit.u, hit.v, y.p};
  const auto behind = dot(y.ng, ray.direction) > F(0.0f);
  F u = draw<L>(context.sampler, path.pixel, path.sample, path.dimension(), SampleBlock::kSelect, {}, kNumberX).x;

  U row = hit.material;
  const U nothing(MaterialRow::kNothing);
  auto open = L::first(count);
  FirstChoice<L> first{row, F(0.0f)};
  // Select a part, level by level
  for (bool is_first = true;; is_first = false) {
    const U safe = select(open, row, U(0u));
    const U flags = gather_member<L>(context.scene.materials.rows, &MaterialRow::flags, safe);
    open = open & ((flags & U(kComposite)) != U(0u));
    if (!any(open)) break;
    // The remainder of the random number is uniform again.
    const F probability = clamp(second_weights<L>(context.scene, open, safe, query), F(0.0f), F(1.0f));
    if (is_first) first.probability = probability;
    const auto second = u < probability;
    u = select(second, u / max(probability, F(1e-20f)), (u - probability) / max(F(1.0f) - probability, F(1e-20f)));
    u = clamp(u, F(0.0f), F(0.99999994f));
    const U chosen = select(second, gather_element<L>(context.scene.materials.rows, &MaterialRow::choice, 1, safe),
                            gather_element<L>(context.scene.materials.rows, &MaterialRow::choice, 0, safe));
    row = select(open, chosen, row);
    open = open & (row != nothing);
    const U back = gather_member<L>(context.scene.materials.rows, &MaterialRow::back, select(open, row, U(0u)));
    row = select(open & behind, back, row);
  }

  // Route the paths, or continue their rays
  const auto passing = row == nothing;
  hit.material = row;
  wave.hits.scatter<L>(slots, count, hit);
  const std::uint32_t all_bits = (1u << count) - 1u;
  const std::uint32_t pass = mask_bits(passing & L::first(count));
  route_vertices<L>(context, wave, slots, all_bits & ~pass, select(passing, U(0u), row), ray.flags);
  if (pass != 0)
    note_passing<L>(context.scene, wave, slots, pass, query, shape.material, behind,
                    mask_weights<L>(context.scene, first, shape.material, behind, passing & L::first(count)));
  continue_rays<L>(context.scene, wave, slots, count, passing, y, shape.boundary, hit, ray, path);
}

}  // namespace

template <class L> void select_materials(const StageContext& context, Wave& wave) noexcept {
  const int hits = wave.composite.size();
  if (hits == 0) return;
  StageTimer timer(wave.stats, stage_named<L>("select_materials"));
  timer.count(hits, L::width);
  wave.composite.pad();
  for_tiles<L>(hits, [&](int i, int count) { select_tile<L>(context, wave, wave.composite.data() + i, count); });
  wave.composite.clear();
}

SHEAF_INSTANTIATE_STAGE(select_materials);

}  // namespace sheaf
