// Closures of phase functions, which scatter in media as BSDFs do on surfaces. scene/description/media.h describes
// them.
#pragma once

#include "scene/materials/model.h"

namespace sheaf {

/// Parameters of the Henyey-Greenstein phase function (kernels/phase/henyey_greenstein.h).
template <class L> struct HenyeyGreensteinParameters {
  typename L::Float g;  ///< mean cosine of the scattering angle, in (-1, 1); 0: isotropic
  static constexpr auto fields(auto& s) { return std::tie(s.g); }
};

/// The Rayleigh phase function (kernels/phase/rayleigh.h) has no parameters, but a closure needs at least one word.
template <class L> struct RayleighParameters {
  typename L::Float unused;
  static constexpr auto fields(auto& s) { return std::tie(s.unused); }
};

/// Parameters of a tabulated phase function (kernels/phase/tabulated_phase.h).
template <class L> struct TabulatedPhaseParameters {
  typename L::Float table;  ///< see scene/tables/closure_tables.h
  static constexpr auto fields(auto& s) { return std::tie(s.table); }
};

/// Parameters of microflakes (kernels/phase/sggx.h): the matrix S = M M^T in the frame whose z axis is the direction of
/// propagation. M has the rows (xx, xy, xz), (0, yy, yz) and (0, 0, zz). The medium sets it for each vertex.
template <class L> struct SggxParameters {
  typename L::Float xx, yy, zz, xy, xz, yz;
  static constexpr auto fields(auto& s) { return std::tie(s.xx, s.yy, s.zz, s.xy, s.xz, s.yz); }
};

struct HenyeyGreensteinClosure : ClosureOf<HenyeyGreensteinParameters> {
  static constexpr ClosureInfo kInfo = {.name = "henyey_greenstein", .is_phase = true};
};
struct RayleighClosure : ClosureOf<RayleighParameters> {
  static constexpr ClosureInfo kInfo = {.name = "rayleigh", .is_phase = true};
};
struct TabulatedPhaseClosure : ClosureOf<TabulatedPhaseParameters> {
  static constexpr ClosureInfo kInfo = {.name = "tabulated_phase", .is_phase = true};
};
struct SggxClosure : ClosureOf<SggxParameters> {
  static constexpr ClosureInfo kInfo = {.name = "sggx", .is_phase = true};
};

}  // namespace sheaf
