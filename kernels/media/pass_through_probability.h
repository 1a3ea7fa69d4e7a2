// Probability that a surface lets light pass unchanged: null interfaces, masks, and blends of them.
#pragma once

#include "scene/materials/list.h"
#include "scene/surfaces/shape.h"
#include "scene/textures/texture_lookup.h"

namespace sheaf {

namespace passing_detail {

inline std::uint32_t side_of(const SceneView& scene, std::uint32_t row, bool behind) {
  return behind ? scene.materials.rows[row].back : row;
}

}  // namespace passing_detail

/// Whether a material of the description, given as a row, may let light pass unchanged: composites and thin dielectrics
/// that cost no depth. `behind`: seen from the back of the geometric normal.
inline bool may_pass(const SceneView& scene, std::uint32_t row, bool behind) {
  const MaterialRow& m = scene.materials.rows[passing_detail::side_of(scene, row, behind)];
  return (m.flags & kComposite) != 0 ||
         (scene.shadow_rays_pass_thin_dielectrics && closure_info(m.kind).is_thin_dielectric);
}

/// Probability, in [0, 1], with which the select_materials stage chooses a row for which `counts` is true.
/// MaterialRow::kNothing is one of these rows.
template <class F>
float mixture_probability(const SceneView& scene, std::uint32_t row, bool behind, const TextureQuery<Scalar>& query,
                          F&& counts) {
  if (row == MaterialRow::kNothing) return counts(row) ? 1.0f : 0.0f;
  row = passing_detail::side_of(scene, row, behind);
  const MaterialRow& m = scene.materials.rows[row];
  if ((m.flags & kComposite) == 0) return counts(row) ? 1.0f : 0.0f;
  float second = m.second_weight();
  if (m.binding_count > 0)
    second = lookup_scalar<Scalar>(scene.textures, scene.materials.bindings[m.first_binding].texture, query);
  second = clamp(second, 0.0f, 1.0f);
  float probability = 0.0f;
  if (second < 1.0f) probability += (1.0f - second) * mixture_probability(scene, m.choice[0], behind, query, counts);
  if (second > 0.0f) probability += second * mixture_probability(scene, m.choice[1], behind, query, counts);
  return probability;
}

/// Fraction of light, in [0, 1], that passes: the probability with which the select_materials stage lets a path pass.
inline float pass_through_probability(const SceneView& scene, std::uint32_t row, bool behind,
                                      const TextureQuery<Scalar>& query) {
  return mixture_probability(scene, row, behind, query,
                             [](std::uint32_t chosen) { return chosen == MaterialRow::kNothing; });
}

}  // namespace sheaf
