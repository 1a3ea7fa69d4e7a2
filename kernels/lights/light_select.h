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
inline float infinite_light_share(const SceneView& scene) {
  const std::uint32_t infinite = infinite_light_count(scene);
  return static_cast<float>(infinite) / static_cast<float>(infinite + (scene.lights.bounded_count > 0 ? 1u : 0u));
}

namespace light_select_detail {

template <class L, int N>
SHEAF_INLINE void choose_by_bvh(const SceneView& scene, const LightSampleContext<L> (&at)[N],
                                const typename L::Float (&u)[N], const LightTreeCut<L>* tops,
                                LightChoice<L> (&choices)[N]) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const std::uint32_t infinite = infinite_light_count(scene);
  const float share = infinite_light_share(scene);
  const auto count = static_cast<float>(infinite);
  const F far_probability(infinite > 0 ? share / count : 0.0f);
  const auto far = [&](F number) SHEAF_LAMBDA_INLINE {
    return U(scene.lights.bounded_count) + min(to_uint(number * F(count / share)), U(infinite - 1));
  };
  if (scene.lights.bounded_count == 0) {
    for (int i = 0; i < N; ++i) choices[i] = {far(u[i]), far_probability};
    return;
  }
  // Descend the light tree.
  LightTreeWalk<L> walks[N];
  for (int i = 0; i < N; ++i) {
    const F number =
        infinite == 0 ? u[i] : clamp((u[i] - F(share)) * F(1.0f / (1.0f - share)), F(0.0f), F(kOneMinusEpsilon));
    walks[i] = tops != nullptr
                   ? begin_light_walk<L>(scene.lights.tree, tops[i], at[i].p, at[i].n, Mask<L>(true), number)
                   : begin_light_walk<L>(at[i].p, at[i].n, Mask<L>(true), number);
  }
  LightTreeSample<L> near[N];
  end_light_walks<L>(scene.lights.tree, walks, near);
  for (int i = 0; i < N; ++i) {
    choices[i] = {near[i].light, near[i].probability};
    if (infinite == 0) continue;
    // Choose a light at infinity by the lower part of u.
    const auto is_far = u[i] < F(share);
    choices[i] = {select(is_far, far(u[i]), near[i].light),
                  select(is_far, far_probability, near[i].probability * F(1.0f - share))};
  }
}

template <class L>
SHEAF_INLINE Float<L> bvh_probability(const SceneView& scene, const LightSampleContext<L>& at, typename L::Uint light) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const std::uint32_t infinite = infinite_light_count(scene);
  const auto near = light < U(scene.lights.bounded_count);
  const float share = infinite_light_share(scene);
  const F far_probability(infinite > 0 ? share / static_cast<float>(infinite) : 0.0f);
  if (!any(near)) return far_probability;
  const F in_tree = light_tree_probability<L>(scene.lights.tree, at.p, at.n, Mask<L>(true), light, near);
  return select(near, in_tree * F(1.0f - share), far_probability);
}

}  // namespace light_select_detail

/// Chooses a light by u in [0, 1) in proportion to its power, regardless of position. The scene must have lights.
template <class L> SHEAF_INLINE LightChoice<L> choose_light_by_power(const SceneView& scene, typename L::Float u) {
  const auto entry = sample_alias<L>(scene.lights.alias, Uint<L>(0u), Uint<L>(scene.lights.count), u);
  return {entry.index, entry.pdf};
}

/// Whether the choice depends on the point to be lit.
inline bool chooses_by_place(const SceneView& scene) {
  return scene.lights.count > 1 && scene.light_selector == LightSelector::kBvh;
}

/// Chooses a light for each point by its u in [0, 1), with SceneView::light_selector. The scene must have lights. `at`
/// is ignored unless chooses_by_place(). `tops`: light_tree_top() of the points if already known, or null; the choice
/// is the same. Making several choices in one call is faster than one after the other.
template <class L, int N>
SHEAF_INLINE void choose_lights(const SceneView& scene, const LightSampleContext<L> (&at)[N],
                                const typename L::Float (&u)[N], const LightTreeCut<L>* tops,
                                LightChoice<L> (&choices)[N]) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const auto count = static_cast<float>(scene.lights.count);
  if (chooses_by_place(scene)) return light_select_detail::choose_by_bvh<L>(scene, at, u, tops, choices);
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
