// The closures that a coat can cover: any opaque closure that is not itself a coat. The kind of the base is a parameter
// of the coat, so all coated materials share one closure kind and uncoated ones have no overhead. coatable.cpp
// dispatches over the kinds that occur in one register.
#pragma once

#include "kernels/bsdf/conductor.h"
#include "kernels/bsdf/diffuse.h"
#include "kernels/bsdf/disney.h"
#include "kernels/bsdf/nori_microfacet.h"
#include "kernels/bsdf/phong.h"
#include "kernels/bsdf/plastic.h"
#include "kernels/bsdf/principled.h"
#include "kernels/bsdf/rough_conductor.h"
#include "kernels/bsdf/rough_diffuse.h"
#include "kernels/bsdf/rough_plastic.h"
#include "kernels/bsdf/ward.h"

namespace sheaf {

namespace coat_detail {

template <template <class> class... Bsdfs> struct CoatableList {
  /// Calls f.operator()<Bsdf>() for the BSDF of this kind, if the list contains it.
  template <class F> static SHEAF_INLINE void visit(ClosureKind kind, F&& f) {
    ((Bsdfs<Scalar>::kKind == kind ? f.template operator()<Bsdfs>() : void()), ...);
  }
  /// Calls f.operator()<Bsdf>() for each BSDF.
  template <class F> static constexpr void for_each(F&& f) { (f.template operator()<Bsdfs>(), ...); }
  static constexpr bool holds(ClosureKind kind) { return ((Bsdfs<Scalar>::kKind == kind) || ...); }
  static_assert(!(kHasTables<Bsdfs<Scalar>> || ...), "a coat does not pass on the scene's tables");
  static_assert(((closure_spectra<Bsdfs>().count <= kCoatableSpectra &&
                  kLeafCount<Bsdfs> - 4 * closure_spectra<Bsdfs>().count <= kCoatableNumbers) &&
                 ...),
                "a closure has more parameters than a coat has room for");
};

}  // namespace coat_detail

/// All BSDFs that can be coated; must agree with `is_coatable` of their ClosureEntry.
using CoatableBsdfs =
    coat_detail::CoatableList<DiffuseBsdf, ConductorBsdf, PlasticBsdf, RoughConductorBeckmannBsdf,
                              RoughConductorGgxBsdf, RoughPlasticBeckmannBsdf, RoughPlasticGgxBsdf, PrincipledBsdf,
                              DisneyBsdf, NoriMicrofacetBsdf, PhongBsdf, RoughDiffuseBsdf, WardBsdf>;
static_assert(
    [] {
      for (int kind = 0; kind < kClosureKinds; ++kind)
        if (CoatableBsdfs::holds(static_cast<ClosureKind>(kind)) !=
            kClosureInfos[static_cast<std::size_t>(kind)].is_coatable)
          return false;
      return true;
    }(),
    "what can be coated is in CoatableBsdfs and says so in for_each_closure()");

/// evaluate() of the base, for directions inside the coat. Compiled once for all users: the many BSDFs are a lot of
/// code, and few coats occur in a register.
template <class L> BsdfValue<L> evaluate_nested(const CoatedParameters<L>& coat, Vec3<L> wo, Vec3<L> wi) noexcept;

/// sample() of the base, for directions inside the coat. Compiled once, as evaluate_nested().
template <class L>
BsdfSample<L> sample_nested(const CoatedParameters<L>& coat, Vec3<L> wo, const Random4<L>& u) noexcept;

}  // namespace sheaf
