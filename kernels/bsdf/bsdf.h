// The interface that every BSDF implements; kernels/phase/phase_function.h states that of phase functions.
//
// A BSDF is a template over the lane policy that derives from its parameters (scene/materials/). It has
//   Closure            its closure, which names it for the scene
//   kIsSpecular        it has delta lobes only: it is neither evaluated nor lit by light sampling
//   kIsAnisotropic     the x axis of the shading frame must be the surface's tangent; otherwise any frame will do
//   kDisperses         optional: defined by dispersive BSDFs, whose transmission keeps one wavelength; their member
//                      `eta` holds the index of each wavelength; see loses_wavelengths()
//   squared_index(wo)  refractive, non-specular BSDFs only: squared relative index of refraction, of the far side over
//                      the side of wo
//   tables             only if the BSDF reads tables: the array that its parameter words refer to
//   adjoint_f_cos(wo, wi)  non-reciprocal BSDFs only: f |cos(wi)| for a photon that comes from wo and leaves along wi
//   evaluate(wo, wi)   f |cos(wi)| and the pdf with which sample() returns wi, both without delta lobes
//   sample(wo, u)      samples a direction; u.x chooses the lobe, u.y and u.z the direction
//   kNumbers           optional: the RandomNumbers of u that sample() uses; all three by default
// Directions are unit vectors in the shading frame and point away from the surface. Large BSDFs define both functions
// in a .cpp file next to the header, compiled once each for Wide and Scalar. Otherwise every stage that handles all
// BSDFs would contain a copy.
//
// A specialization of BsdfOf below the template makes it the BSDF of its closure.
//
// Closure::kInfo marks thin dielectrics. A thin dielectric also has
//   passage(cos)       transmittance straight through, for light at this cosine to the normal
//
// CONTRIBUTING.md explains how to add a BSDF.
#pragma once

#include "core/sampling/sampler.h"
#include "kernels/phase/scattering.h"
#include "scene/materials/model.h"

namespace sheaf {

/// Names a BSDF template as a value.
template <template <class> class Bsdf> struct BsdfTag { template <class L> using Type = Bsdf<L>; };

/// The BsdfTag of a closure's BSDF or phase function. Each specializes it beside its definition.
template <class Closure> struct BsdfOf;

/// Whether a BSDF has kDisperses.
template <class Bsdf> inline constexpr bool kDisperses = requires { Bsdf::kDisperses; };

/// Whether all four lanes are the same.
template <class L> SHEAF_INLINE Mask<L> is_same_in_all(const Spectrum<L>& s) {
  return (s.c1 == s.c0) & (s.c2 == s.c0) & (s.c3 == s.c0);
}

/// Whether a dispersive BSDF keeps only the first of four wavelengths: it transmits from wo to wi, and the four indices
/// differ. They are equal once the path has a single wavelength.
///
/// The remaining wavelength is weighted by 4. Where a camera path and a light path connect at such a vertex, only one
/// of them applies this factor.
template <class L, class Bsdf> SHEAF_INLINE Mask<L> loses_wavelengths(const Bsdf& bsdf, Vec3<L> wo, Vec3<L> wi) {
  if constexpr (kDisperses<Bsdf>)
    return (wo.z * wi.z < Float<L>(0.0f)) & !is_same_in_all<L>(bsdf.eta);
  else
    return Mask<L>(false);
}

/// The RandomNumbers that a BSDF's sample() uses.
template <class Bsdf> constexpr unsigned numbers_of() {
  if constexpr (requires { Bsdf::kNumbers; }) return Bsdf::kNumbers;
  return kNumberX | kNumberY | kNumberZ;
}

/// Whether a BSDF reads tables.
template <class Bsdf> inline constexpr bool kHasTables = requires(Bsdf& bsdf) { bsdf.tables; };

namespace bsdf_detail {

/// Sets a parameter to the word that load(k, word) stores in `word`.
template <class Load, class Leaf> SHEAF_INLINE void load_leaf(Load& load, int k, Leaf& leaf) {
  using L = std::conditional_t<std::is_arithmetic_v<Leaf>, Scalar, Wide>;
  Float<L> word;
  load(k, word);
  set_leaf<L>(leaf, word);
}

}  // namespace bsdf_detail

/// Builds a BSDF whose parameter word k is the value that load(k, word) stores in `word`. `tables`:
/// MaterialView::closure_tables.
template <class Bsdf, class Load> SHEAF_INLINE Bsdf bsdf_of_words(const float* tables, Load&& load) {
  Bsdf bsdf;
  if constexpr (kHasTables<Bsdf>) bsdf.tables = tables;
  std::apply(
      [&load](auto&... leaf) SHEAF_LAMBDA_INLINE {
        int k = 0;
        (bsdf_detail::load_leaf(load, k++, leaf), ...);
      },
      leaves(bsdf));
  return bsdf;
}

/// Transmission of a thin dielectric straight through.
template <class L> struct StraightTransmission {
  Spectrum<L> attenuation;        ///< transmittance
  typename L::Float probability;  ///< probability that sample() transmits
};

/// The sample of a direction on the same side as wo, weighted by value and pdf of all lobes. `possible`: lanes where
/// the sampled lobe can scatter there.
template <class L>
SHEAF_INLINE BsdfSample<L> sample_with_value(Vec3<L> wi, const BsdfValue<L>& value, Mask<L> possible = Mask<L>(true)) {
  using F = Float<L>;
  const Mask<L> valid = possible & (value.pdf_solid_angle > F(0.0f));
  return {wi, value.f_cos * (F(1.0f) / select(valid, value.pdf_solid_angle, F(1.0f))), value.pdf_solid_angle, F(1.0f),
          valid};
}

}  // namespace sheaf
