// Sampling of guided directions and their pdfs, for the vertices of a register. Compiled once per lane policy;
// otherwise every stage that handles all BSDFs would contain a copy.
#pragma once

#include "core/sampling/sampler.h"
#include "kernels/guiding/guide_view.h"

namespace sheaf {

/// Choice between BSDF and guide at a vertex.
template <class L> struct GuideSample {
  typename L::Mask taken;    ///< lanes that sample the guide
  Vec3<L> direction;         ///< world space; only in lanes of `taken`
  typename L::Float bsdf_u;  ///< elsewhere: new number in [0, 1) instead of u.x
};

/// Chooses with the mixtures in `rows` of the first `count` vertices. `u.x` makes the choice, `u.y` and `u.z` give the
/// direction.
template <class L>
GuideSample<L> sample_guide(const GuideView& guide, Uint<L> rows, int count, const Random4<L>& u) noexcept;

/// Value of the guide for a direction at a vertex.
template <class L> struct GuideValue {
  typename L::Float bsdf_probability;  ///< probability of sampling the BSDF, in (0, 1]
  typename L::Float pdf_solid_angle;   ///< of guided directions

  /// Pdf of the mixture of BSDF and guide, where the BSDF has pdf `bsdf_pdf`. `guided` scales the pdf of the guide.
  SHEAF_INLINE Float<L> mixed(Float<L> bsdf_pdf, Float<L> guided = Float<L>(1.0f)) const {
    return fma(bsdf_probability, bsdf_pdf, (Float<L>(1.0f) - bsdf_probability) * guided * pdf_solid_angle);
  }
};

/// Evaluates the lanes set in `lanes`, where `direction` is in world space and has unit length. In the other lanes, as
/// if there were no guide.
template <class L>
GuideValue<L> evaluate_guide(const GuideView& guide, Uint<L> rows, std::uint32_t lanes, Vec3<L> direction) noexcept;

}  // namespace sheaf
