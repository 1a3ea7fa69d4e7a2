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
template <class L> struct LightReceiver {
  Vec3<L> p, n;
};

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

template <class L>
SHEAF_INLINE LightChoice<L> choose_by_bvh(const SceneView& scene, const LightReceiver<L>& at, typename L::Float u,
                                          const LightTreeTop<L>* top) {
  using F = typename L::Float;
  using U = typename L::Uint;
  const auto in_tree = [&](F number) SHEAF_LAMBDA_INLINE -> LightTreeSample<L> {
    if (top != nullptr) return sample_light_tree<L>(scene.light_tree, *top, at.p, at.n, Mask<L>(true), number);
    return sample_light_tree<L>(scene.light_tree, at.p, at.n, Mask<L>(true), number);
  };
  const std::uint32_t infinite = infinite_light_count(scene);
  if (infinite == 0) {
    const auto s = in_tree(u);
    return {s.light, s.probability};
  }
  const float share = infinite_light_share(scene);
  const auto count = static_cast<float>(infinite);
  const U far = U(scene.bounded_light_count) + min(to_uint(u * F(count / share)), U(infinite - 1));
  const F far_probability(share / count);
  if (scene.bounded_light_count == 0) return {far, far_probability};
  const auto is_far = u < F(share);
  const F rest = clamp((u - F(share)) * F(1.0f / (1.0f - share)), F(0.0f), F(kOneMinusEpsilon));
  const auto near = in_tree(rest);
  return {select(is_far, far, near.light), select(is_far, far_probability, near.probability * F(1.0f - share))};
}

template <class L>
SHEAF_INLINE Float<L> bvh_probability(const SceneView& scene, const LightReceiver<L>& at, typename L::Uint light) {
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

/// Chooses a light by u in [0, 1), as SceneView::light_selector says. The scene must have lights. `top`: what
/// light_tree_top() says of the receiver, if that is known already; the choice is the same.
template <class L>
SHEAF_INLINE LightChoice<L> choose_light(const SceneView& scene, const LightReceiver<L>& at, typename L::Float u,
                                         const LightTreeTop<L>* top = nullptr) {
  using F = typename L::Float;
  using U = typename L::Uint;
  if (scene.light_count == 1) return {U(0u), F(1.0f)};
  const auto count = static_cast<float>(scene.light_count);
  switch (scene.light_selector) {
    case LightSelector::kUniform:
      return {min(to_uint(u * F(count)), U(scene.light_count - 1)), F(1.0f / count)};
    case LightSelector::kPower: return choose_light_by_power<L>(scene, u);
    case LightSelector::kBvh: break;
  }
  return light_select_detail::choose_by_bvh<L>(scene, at, u, top);
}

/// The probability with which choose_light finds `light`.
template <class L>
SHEAF_INLINE Float<L> choice_probability(const SceneView& scene, const LightReceiver<L>& at, typename L::Uint light) {
  using F = typename L::Float;
  if (scene.light_count == 1) return F(1.0f);
  switch (scene.light_selector) {
    case LightSelector::kUniform: return F(1.0f / static_cast<float>(scene.light_count));
    case LightSelector::kPower: return gather_member<L>(scene.light_alias, &AliasEntry::pdf, light);
    case LightSelector::kBvh: break;
  }
  return light_select_detail::bvh_probability<L>(scene, at, light);
}

}  // namespace sheaf
