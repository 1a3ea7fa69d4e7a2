// The list of all material models, from which closure kinds, names in files and the code per model derive.
#pragma once

#include "scene/materials/blend.h"
#include "scene/materials/bump_map.h"
#include "scene/materials/coat.h"
#include "scene/materials/conductor.h"
#include "scene/materials/dielectric.h"
#include "scene/materials/diffuse.h"
#include "scene/materials/diffuse_transmitter.h"
#include "scene/materials/disney.h"
#include "scene/materials/hair.h"
#include "scene/materials/hanrahan_krueger.h"
#include "scene/materials/mask.h"
#include "scene/materials/measured.h"
#include "scene/materials/metallic_roughness.h"
#include "scene/materials/nori_microfacet.h"
#include "scene/materials/normal_map.h"
#include "scene/materials/null.h"
#include "scene/materials/phase_functions.h"
#include "scene/materials/phong.h"
#include "scene/materials/plastic.h"
#include "scene/materials/principled.h"
#include "scene/materials/principled_thin.h"
#include "scene/materials/rough_diffuse.h"
#include "scene/materials/two_sided.h"
#include "scene/materials/ward.h"

#include <variant>

namespace sheaf {

namespace list_detail {

template <class... Models> struct ModelList {
  static_assert((CompleteModel<Models> && ...), "a model omits something; see scene/materials/model.h");

  using Variant = std::variant<Models...>;
  using Closures = decltype((typename Models::Closures{} + ...));
};

}  // namespace list_detail

/// All models. Scenes use the first one for shapes without a material.
using MaterialModels = list_detail::ModelList<DiffuseDescription,             //
                                              ConductorDescription,           //
                                              DielectricDescription,          //
                                              PlasticDescription,             //
                                              PrincipledDescription,          //
                                              PrincipledThinDescription,      //
                                              DisneyDescription,              //
                                              MetallicRoughnessDescription,   //
                                              NoriMicrofacetDescription,      //
                                              PhongDescription,               //
                                              RoughDiffuseDescription,        //
                                              WardDescription,                //
                                              DiffuseTransmitterDescription,  //
                                              HanrahanKruegerDescription,     //
                                              MeasuredDescription,            //
                                              HairDescription,                //
                                              CoatDescription,                //
                                              NullDescription,                //
                                              TwoSidedDescription,            //
                                              MaskDescription,                //
                                              BlendDescription,               //
                                              BumpMapDescription,             //
                                              NormalMapDescription>;

/// A material of any model.
using MaterialModel = MaterialModels::Variant;

/// Closures of phase functions.
using PhaseClosures = ClosureList<HenyeyGreensteinClosure, RayleighClosure, TabulatedPhaseClosure, SggxClosure>;

/// All closures, in the order of their kinds.
using AllClosures = decltype(MaterialModels::Closures{} + PhaseClosures{});

inline constexpr int kClosureKinds = AllClosures::kCount;
static_assert(kClosureKinds <= kMaxClosureKinds);

/// The kind of a closure.
template <class Closure>
inline constexpr ClosureKind kClosureKind = static_cast<ClosureKind>(AllClosures::position_of<Closure>());

/// Calls f(ClosureKind, Closure{}) for all closures, in the order of their kinds.
template <class F> constexpr void for_each_closure(F&& f) {
  [&]<class... Closures>(ClosureList<Closures...>) { (f(kClosureKind<Closures>, Closures{}), ...); }(AllClosures{});
}

namespace list_detail {

template <class... Closures> consteval std::array<ClosureInfo, sizeof...(Closures)> infos_of(ClosureList<Closures...>) {
  return {Closures::kInfo...};
}

}  // namespace list_detail

/// Indexed by ClosureKind.
inline constexpr std::array<ClosureInfo, kClosureKinds> kClosureInfos = list_detail::infos_of(AllClosures{});

constexpr const ClosureInfo& closure_info(ClosureKind kind) { return kClosureInfos[static_cast<std::size_t>(kind)]; }

}  // namespace sheaf
