// Guiding towards the glow of lights in fog, without training. Light that fog scatters once towards a point is
// brightest around lights: at the angle a from the direction to a point light at distance D, its radiance is
// proportional to (pi - a) / (D sin a). Surfaces beside the light, such as its post or shade, are brighter still:
// their irradiance is proportional to the inverse square of their distance to the light. Hence the lobe of each group
// of lights is steeper than the glow,
//     pdf(a) = (c + c0)^(-7/8) / (16 pi ((2 + c0)^(1/8) - c0^(1/8))),  c = 1 - cos a.
// c0 widens the lobe to the size of the group.
#pragma once

#include "kernels/guiding/guide_sample.h"
#include "scene/tables/light_tree.h"

namespace sheaf {

/// Probability of sampling the lobes instead of the BSDF if the fog does not attenuate the lights. Otherwise it is
/// multiplied by their mean transmittance: thick fog hides its lights.
inline constexpr float kGlowProbability = 0.4f;

/// As sample_guide(), at the points `p`. `extinction`: of the fog, 1/m; negative: no fog, the BSDF is sampled. The tree
/// must have glow sources.
template <class L>
GuideSample<L> sample_glow(const LightTreeView& tree, Vec3<L> p, Float<L> extinction, const Random4<L>& u) noexcept;

/// As evaluate_guide(), likewise.
template <class L>
GuideValue<L> evaluate_glow(const LightTreeView& tree, Vec3<L> p, Float<L> extinction, Vec3<L> direction) noexcept;

}  // namespace sheaf
