// Which light: one interface for surfaces, media and photons, whatever the selector.
#pragma once

#include "core/distribution.h"
#include "kernels/lights/light_tree.h"
#include "scene/tables/scene.h"

namespace sheaf {

/// A light and the probability with which it was chosen.
template <class L> struct LightChoice {
  typename L::Uint light;         ///< row of SceneView::lights; 0 where the probability is 0
  typename L::Float probability;  ///< 0: no light can reach the point
};

/// Where light is wanted. `n` is the shading normal of a surface, and zero in media, where light counts from all sides.
template <class L> struct LightSampleContext { Vec3<L> p, n; };

/// How many lights shine from outside of the scene: those behind SceneView::bounded_light_count.
inline std::uint32_t infinite_light_count(const SceneView& scene) {
  return scene.light_count - scene.bounded_light_count;
}

/// LightSelector::kBvh: the probability with which one of the infinite lights is chosen, all of them alike. The tree
/// counts as one more, as it knows nothing of them.
inline float infinite_light_share(const SceneView& scene) {
  const std::uint32_t infinite = infinite_light_count(scene);
  return static_cast<float>(infinite) / static_cast<float>(infinite + (scene.bounded_light_count > 0 ? 1u : 0u));
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
    return U(scene.bounded_light_count) + min(to_uint(number * F(count / share)), U(infinite - 1));
  };
  if (scene.bounded_light_count == 0) {
    for (int i = 0; i < N; ++i) choices[i] = {far(u[i]), far_probability};
    return;
  }
  LightTreeWalk<L> walks[N];
  for (int i = 0; i < N; ++i) {
    const F number =
        infinite == 0 ? u[i] : clamp((u[i] - F(share)) * F(1.0f / (1.0f - share)), F(0.0f), F(kOneMinusEpsilon));
    walks[i] = tops != nullptr ? begin_light_walk<L>(scene.light_tree, tops[i], at[i].p, at[i].n, Mask<L>(true), number)
                               : begin_light_walk<L>(at[i].p, at[i].n, Mask<L>(true), number);
  }
  LightTreeSample<L> near[N];
  end_light_walks<L>(scene.light_tree, walks, near);
  for (int i = 0; i < N; ++i) {
    choices[i] = {near[i].light, near[i].probability};
    if (infinite == 0) continue;
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
  const auto near = light < U(scene.bounded_light_count);
  const float share = infinite_light_share(scene);
  const F far_probability(infinite > 0 ? share / static_cast<float>(infinite) : 0.0f);
  if (!any(near)) return far_probability;
  const F in_tree = light_tree_probability<L>(scene.light_tree, at.p, at.n, Mask<L>(true), light, near);
  return select(near, in_tree * F(1.0f - share), far_probability);
}

}  // namespace light_select_detail

/// Chooses a light by u in [0, 1) in proportion to its power, wherever light is wanted. The scene must have lights.
template <class L> SHEAF_INLINE LightChoice<L> choose_light_by_power(const SceneView& scene, typename L::Float u) {
  const auto entry = sample_alias<L>(scene.light_alias, Uint<L>(0u), Uint<L>(scene.light_count), u);
  return {entry.index, entry.pdf};
}

/// Whether the choice depends on the receiver.
inline bool chooses_by_place(const SceneView& scene) {
  return scene.light_count > 1 && scene.light_selector == LightSelector::kBvh;
}

/// Chooses a light for each receiver by its u in [0, 1), as SceneView::light_selector says. The scene must have lights.
/// Receivers may be anything unless chooses_by_place(). `tops`: what light_tree_top() says of them, if that is known
/// already, or null; the choice is the same. Several choices at once cost less than one after the other.
template <class L, int N>
SHEAF_INLINE void choose_lights(const SceneView& scene, const LightSampleContext<L> (&at)[N],
                                const typename L::Float (&u)[N], const LightTreeCut<L>* tops,
                                LightChoice<L> (&choices)[N]) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const auto count = static_cast<float>(scene.light_count);
  if (chooses_by_place(scene)) return light_select_detail::choose_by_bvh<L>(scene, at, u, tops, choices);
  for (int i = 0; i < N; ++i) {
    if (scene.light_count == 1)
      choices[i] = {U(0u), F(1.0f)};
    else if (scene.light_selector == LightSelector::kPower)
      choices[i] = choose_light_by_power<L>(scene, u[i]);
    else
      choices[i] = {min(to_uint(u[i] * F(count)), U(scene.light_count - 1)), F(1.0f / count)};
  }
}

/// Chooses a light for one receiver.
template <class L>
SHEAF_INLINE LightChoice<L> choose_light(const SceneView& scene, const LightSampleContext<L>& at, typename L::Float u) {
  LightChoice<L> choice[1];
  choose_lights<L, 1>(scene, {at}, {u}, nullptr, choice);
  return choice[0];
}

/// The probability with which choose_light finds `light`.
template <class L>
SHEAF_INLINE Float<L> choice_probability(const SceneView& scene, const LightSampleContext<L>& at,
                                         typename L::Uint light) {
  using F = typename L::Float;
  if (scene.light_count == 1) return F(1.0f);
  switch (scene.light_selector) {
    case LightSelector::kUniform:
      return F(1.0f / static_cast<float>(scene.light_count));
    case LightSelector::kPower:
      return gather_member<L>(scene.light_alias, &AliasEntry::pdf, light);
    case LightSelector::kBvh:
      break;
  }
  return light_select_detail::bvh_probability<L>(scene, at, light);
}

}  // namespace sheaf
