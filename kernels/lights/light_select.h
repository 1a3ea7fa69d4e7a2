// Light selection: one interface for surfaces, media and photons, independent of LightSelector.
#pragma once

#include "core/sampling/alias_table.h"
#include "kernels/lights/light_tree.h"
#include "scene/tables/scene_view.h"

namespace sheaf {

/// A light and the probability of choosing it.
template <class L> struct LightChoice {
  typename L::Uint light;         ///< row of LightView::rows; 0 where the probability is 0
  typename L::Float probability;  ///< 0: no light can reach the point
};

/// The point to be lit. `n` is the shading normal of a surface; it is zero in media, where light counts from all
/// directions.
template <class L> struct LightSampleContext { Vec3<L> p, n; };

/// Number of lights at infinity; they follow the first LightView::bounded_count lights.
inline std::uint32_t infinite_light_count(const SceneView& scene) {
  return scene.lights.count - scene.lights.bounded_count;
}

/// LightSelector::kBvh: probability of choosing one of the lights at infinity, which are chosen uniformly. The light
/// tree does not contain them and counts as one more light.
inline float infinite_light_probability(const SceneView& scene) {
  const std::uint32_t infinite = infinite_light_count(scene);
  return static_cast<float>(infinite) / static_cast<float>(infinite + (scene.lights.bounded_count > 0 ? 1u : 0u));
}

namespace light_select_detail {

template <class L, int N>
SHEAF_INLINE void choose_by_bvh(const SceneView& scene, const LightSampleContext<L> (&at)[N],
                                const typename L::Float (&u)[N], const LightTreeCut<L>* cuts,
                                LightChoice<L> (&choices)[N]) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const std::uint32_t infinite = infinite_light_count(scene);
  const float p_infinite = infinite_light_probability(scene);
  const auto count = static_cast<float>(infinite);
  const F far_probability(infinite > 0 ? p_infinite / count : 0.0f);
  const auto far = [&](F number) SHEAF_LAMBDA_INLINE {
    return U(scene.lights.bounded_count) + min(to_uint(number * F(count / p_infinite)), U(infinite - 1));
  };
  if (scene.lights.bounded_count == 0) {
    for (int i = 0; i < N; ++i) choices[i] = {far(u[i]), far_probability};
    return;
  }
  // Traverse the light tree
  LightTreeTraversal<L> traversals[N];
  for (int i = 0; i < N; ++i) {
    const F number = infinite == 0
                         ? u[i]
                         : clamp((u[i] - F(p_infinite)) * F(1.0f / (1.0f - p_infinite)), F(0.0f), F(kOneMinusEpsilon));
    traversals[i] = cuts != nullptr
                        ? begin_light_traversal<L>(scene.lights.tree, cuts[i], at[i].p, at[i].n, Mask<L>(true), number)
                        : begin_light_traversal<L>(at[i].p, at[i].n, Mask<L>(true), number);
  }
  LightTreeSample<L> near[N];
  finish_light_traversals<L>(scene.lights.tree, traversals, near);
  for (int i = 0; i < N; ++i) {
    choices[i] = {near[i].light, near[i].probability};
    if (infinite == 0) continue;
    // Choose a light at infinity by the lower part of u
    const auto is_far = u[i] < F(p_infinite);
    choices[i] = {select(is_far, far(u[i]), near[i].light),
                  select(is_far, far_probability, near[i].probability * F(1.0f - p_infinite))};
  }
}

template <class L>
SHEAF_INLINE Float<L> bvh_probability(const SceneView& scene, const LightSampleContext<L>& at, typename L::Uint light) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const std::uint32_t infinite = infinite_light_count(scene);
  const auto near = light < U(scene.lights.bounded_count);
  const float p_infinite = infinite_light_probability(scene);
  const F far_probability(infinite > 0 ? p_infinite / static_cast<float>(infinite) : 0.0f);
  if (!any(near)) return far_probability;
  const F in_tree = light_tree_probability<L>(scene.lights.tree, at.p, at.n, Mask<L>(true), light, near);
  return select(near, in_tree * F(1.0f - p_infinite), far_probability);
}

}  // namespace light_select_detail

/// Chooses a light by u in [0, 1) in proportion to its power, regardless of position. The scene must have lights.
template <class L> SHEAF_INLINE LightChoice<L> choose_light_by_power(const SceneView& scene, typename L::Float u) {
  const auto entry = sample_alias<L>(scene.lights.alias, Uint<L>(0u), Uint<L>(scene.lights.count), u);
  return {entry.index, entry.pdf};
}

/// Whether the choice depends on the point to be lit.
inline bool choice_depends_on_position(const SceneView& scene) {
  return scene.lights.count > 1 && scene.light_selector == LightSelector::kBvh;
}

/// Chooses a light for each point by its u in [0, 1), with SceneView::light_selector. The scene must have lights. `at`
/// is ignored unless choice_depends_on_position(). `cuts`: the cut of the light tree for each point, or null to compute
/// the choices without; they are the same. Several choices in one call are faster than one after the other.
template <class L, int N>
SHEAF_INLINE void choose_lights(const SceneView& scene, const LightSampleContext<L> (&at)[N],
                                const typename L::Float (&u)[N], const LightTreeCut<L>* cuts,
                                LightChoice<L> (&choices)[N]) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const auto count = static_cast<float>(scene.lights.count);
  if (choice_depends_on_position(scene)) return light_select_detail::choose_by_bvh<L>(scene, at, u, cuts, choices);
  for (int i = 0; i < N; ++i) {
    if (scene.lights.count == 1)
      choices[i] = {U(0u), F(1.0f)};
    else if (scene.light_selector == LightSelector::kPower)
      choices[i] = choose_light_by_power<L>(scene, u[i]);
    else
      choices[i] = {min(to_uint(u[i] * F(count)), U(scene.lights.count - 1)), F(1.0f / count)};
  }
}

/// Chooses a light for one point.
template <class L>
SHEAF_INLINE LightChoice<L> choose_light(const SceneView& scene, const LightSampleContext<L>& at, typename L::Float u) {
  LightChoice<L> choice[1];
  choose_lights<L, 1>(scene, {at}, {u}, nullptr, choice);
  return choice[0];
}

/// The probability with which choose_light() returns `light`.
template <class L>
SHEAF_INLINE Float<L> choice_probability(const SceneView& scene, const LightSampleContext<L>& at,
                                         typename L::Uint light) {
  using F = typename L::Float;
  if (scene.lights.count == 1) return F(1.0f);
  switch (scene.light_selector) {
    case LightSelector::kUniform:
      return F(1.0f / static_cast<float>(scene.lights.count));
    case LightSelector::kPower:
      return gather_member<L>(scene.lights.alias, &AliasEntry::pdf, light);
    case LightSelector::kBvh:
      break;
  }
  return light_select_detail::bvh_probability<L>(scene, at, light);
}

}  // namespace sheaf
