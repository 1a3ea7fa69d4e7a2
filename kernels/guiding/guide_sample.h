// Directions from the guide, and their densities, for the vertices of a register. Compiled once for each lane: every
// stage that goes over all BSDFs would hold a copy.
#pragma once

#include "core/sampler.h"
#include "kernels/guiding/guide_view.h"

namespace sheaf {

/// How a vertex samples a direction: from the BSDF or the guide.
template <class L> struct GuideSample {
  typename L::Mask taken;    ///< from the guide
  Vec3<L> direction;         ///< world space; where it was
  typename L::Float bsdf_u;  ///< elsewhere a fresh number in [0, 1) in place of the one that chose
};

/// Chooses with the mixtures in `rows` of the first `count` vertices; `u.x` chooses, `u.y` and `u.z` are the direction.
template <class L>
GuideSample<L> sample_guide(const GuideView& guide, Uint<L> rows, int count, const Random4<L>& u) noexcept;

/// The guide at a vertex, towards a given direction.
template <class L> struct GuideValue {
  typename L::Float bsdf_share;       ///< probability of sampling the BSDF, in (0, 1]
  typename L::Float pdf_solid_angle;  ///< of the guide's directions

  /// The density of a vertex whose BSDF has density `bsdf_pdf`.
  SHEAF_INLINE Float<L> mixed(Float<L> bsdf_pdf, Float<L> guided = Float<L>(1.0f)) const {
    return fma(bsdf_share, bsdf_pdf, (Float<L>(1.0f) - bsdf_share) * guided * pdf_solid_angle);
  }
};

/// For the lanes set in `lanes`, in which `direction`, world space, has unit length; elsewhere as if there were no
/// guide.
template <class L>
GuideValue<L> evaluate_guide(const GuideView& guide, Uint<L> rows, std::uint32_t lanes, Vec3<L> direction) noexcept;

}  // namespace sheaf
