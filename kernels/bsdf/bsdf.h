// What every BSDF offers.
//
// A BSDF is a template over the lane that holds its parameters (scene/tables/material.h) and has
//   kKind              its ClosureKind
//   kIsSpecular        only delta distributions: neither evaluated nor lit by light sampling
//   kIsAnisotropic     directions must come in a frame whose x axis is the surface's tangent; else any frame will do
//   kDisperses         only if true need it be there: light that it lets through keeps the first wavelength alone,
//                      unless the four indices, the member `eta`, are the same, as where a path has one wavelength
//                      left; see loses_wavelengths()
//   squared_index(wo)  only if it refracts and is not specular: that of the side across, relative to the side of wo
//   tables             only if it reads some need it be there: the array that its words refer to
//   adjoint_f_cos(wo, wi)  only if it isn't reciprocal: f times |cos(wi)| for a photon that comes from wo and leaves
//                      along wi
//   evaluate(wo, wi)   f times |cos(wi)| and the density with which sample() returns wi; delta lobes left out
//   sample(wo, u)      a direction; u.x chooses the lobe, u.y and u.z the direction
//   kNumbers           only if sample() makes no use of some of them need it be there: RandomNumbers of u
// Directions are unit vectors in the shading frame, pointing away from the surface. Large ones have both functions in a
// .cpp beside the header, compiled once for Wide and Scalar: every stage that goes over all BSDFs would hold a copy.
//
// Which are panes and which are phase functions is told by the list in scene/tables/material.h. A pane also has
//   passage(cos)       what of the light that arrives at this cosine to the normal goes straight on
//
// A phase function scatters in a medium as a BSDF does on a surface. There is no normal: the frame's z axis is wo,
// which is (0, 0, 1) for all of them, and wi lies near -wo where light goes on. f_cos is the phase function without a
// cosine, the same in all four lanes and equal to the density with which sample() returns wi, so that a sample's weight
// is 1 (the albedo belongs to the medium). Where it depends on directions in the world, as that of microflakes does,
// the stage surface_inputs writes its parameters for each vertex, as those of the frame.
//
// README.md tells how to add one.
#pragma once

#include "core/sampler.h"
#include "core/spectrum.h"
#include "scene/tables/material.h"

namespace sheaf {

/// Whether a BSDF has kDisperses.
template <class Bsdf> inline constexpr bool kDisperses = requires { Bsdf::kDisperses; };

/// Whether all four lanes are the same.
template <class L> SHEAF_INLINE Mask<L> is_same_in_all(const Spectrum<L>& s) {
  return (s.c1 == s.c0) & (s.c2 == s.c0) & (s.c3 == s.c0);
}

/// Where a BSDF that disperses keeps the first of four wavelengths alone, and lets it count for all: wi is across the
/// surface, and the wavelengths have indices of their own, as those of a path that has only one left have not. Paths
/// that meet there from both sides must count for all four once, not each.
template <class L, class Bsdf> SHEAF_INLINE Mask<L> loses_wavelengths(const Bsdf& bsdf, Vec3<L> wo, Vec3<L> wi) {
  if constexpr (kDisperses<Bsdf>)
    return (wo.z * wi.z < Float<L>(0.0f)) & !is_same_in_all<L>(bsdf.eta);
  else
    return Mask<L>(false);
}

/// Which RandomNumbers a BSDF's sample() uses.
template <class Bsdf> constexpr unsigned numbers_of() {
  if constexpr (requires { Bsdf::kNumbers; }) return Bsdf::kNumbers;
  return kNumberX | kNumberY | kNumberZ;
}

/// Whether a BSDF is a phase function.
template <class Bsdf> inline constexpr bool kIsPhaseFunction = closure_info(Bsdf::kKind).is_phase;

/// Whether a BSDF reads tables.
template <class Bsdf> inline constexpr bool kHasTables = requires(Bsdf& bsdf) { bsdf.tables; };

/// A BSDF whose parameters' word k is what load(k, word) puts into `word`. `tables`: SceneView::closure_tables.
template <class Bsdf, class Load> SHEAF_INLINE Bsdf bsdf_of_words(const float* tables, Load&& load) {
  Bsdf bsdf;
  if constexpr (kHasTables<Bsdf>) bsdf.tables = tables;
  std::apply(
      [&load](auto&... leaf) SHEAF_LAMBDA_INLINE {
        int k = 0;
        (load(k++, leaf), ...);
      },
      leaves(bsdf));
  return bsdf;
}

/// A BSDF towards a given direction.
template <class L> struct BsdfValue {
  Spectrum<L> f_cos;                  ///< f times |cos(wi)|; zero where nothing is scattered
  typename L::Float pdf_solid_angle;  ///< density of sample()
};

/// Light that goes straight on through a thin pane.
template <class L> struct PanePassage {
  Spectrum<L> share;              ///< of it passes
  typename L::Float probability;  ///< with which sample() lets it pass
};

/// A direction sampled from a BSDF.
template <class L> struct BsdfSample {
  Vec3<L> wi;
  Spectrum<L> weight;                 ///< f times |cos(wi)| over the density; specular: the scattered share
  typename L::Float pdf_solid_angle;  ///< density; 0: specular
  typename L::Float eta_scale;        ///< 1, or the squared relative index of refraction that was entered
  typename L::Mask valid;             ///< false: absorbed
};

}  // namespace sheaf
