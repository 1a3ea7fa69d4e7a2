// The kernels of all kinds of lights: LightOf of each kind in scene/lights/list.h. CMake collects their headers. Light
// sampling, its pdfs and photon emission are generated from this list.
#pragma once

#include "kernels/lights/all_headers.h"
#include "kernels/lights/light_kind.h"
#include "scene/lights/list.h"

namespace sheaf {

namespace light_detail {

/// Whether a kind has a valid kernel.
template <class Kind>
concept Implemented =
    LightModel<typename LightOf<Kind>::Type> && std::same_as<typename LightOf<Kind>::Type::Kind, Kind>;

template <class List> struct LightList;
template <class... Kinds> struct LightList<LightKindList<Kinds...>> {
  static_assert(
      (Implemented<Kinds> && ...),
      "a kind in scene/lights/list.h has no kernel: no header begins a line with 'template <> struct LightOf<'");

  /// Calls f(kernel) for each kind, with a value of the kernel's type.
  template <class F> static SHEAF_INLINE void for_each(F&& f) { (f(typename LightOf<Kinds>::Type{}), ...); }
  /// Calls f(kernel) for each kind until it returns true. Whether it did.
  template <class F> static SHEAF_INLINE bool any_of(F&& f) { return (f(typename LightOf<Kinds>::Type{}) || ...); }
};

}  // namespace light_detail

/// All light kinds.
using Lights = light_detail::LightList<LightKinds>;

}  // namespace sheaf
