// Materials as kernels see them: closures with their parameters, and the rows of the material table.
#pragma once

#include "core/soa.h"
#include "core/spectrum.h"

namespace sheaf {

/// Kinds of closure: what is sorted by and dispatched on, once per bucket.
enum class ClosureKind : std::uint32_t { kDiffuse, kConductor, kDielectric, kCount };
inline constexpr int kClosureKinds = static_cast<int>(ClosureKind::kCount);

/// Parameters of Lambertian reflection (kernels/bsdf/diffuse.h).
template <class L> struct DiffuseParameters {
  Spectrum<L> reflectance;  ///< in [0, 1]
  static constexpr auto kKind = ClosureKind::kDiffuse;
  static constexpr auto fields(auto& s) { return std::tie(s.reflectance); }
};

/// Parameters of specular reflection off a metal (kernels/bsdf/conductor.h).
template <class L> struct ConductorParameters {
  Spectrum<L> eta, k;       ///< complex index of refraction relative to the outside; eta 0 with k 1 is a perfect mirror
  Spectrum<L> reflectance;  ///< factor on the Fresnel reflectance
  static constexpr auto kKind = ClosureKind::kConductor;
  static constexpr auto fields(auto& s) { return std::tie(s.eta, s.k, s.reflectance); }
};

/// Parameters of specular reflection and refraction (kernels/bsdf/dielectric.h).
template <class L> struct DielectricParameters {
  typename L::Float eta;      ///< int / ext
  Spectrum<L> reflectance;    ///< factor on reflected light
  Spectrum<L> transmittance;  ///< factor on transmitted light
  static constexpr auto kKind = ClosureKind::kDielectric;
  static constexpr auto fields(auto& s) { return std::tie(s.eta, s.reflectance, s.transmittance); }
};

/// Most 32-bit words of parameters that a closure may have; a multiple of four.
inline constexpr int kMaxClosureWords = 12;

/// One material after composite ones are flattened. Sixteen words.
struct alignas(64) MaterialRow {
  ClosureKind kind = ClosureKind::kDiffuse;
  std::uint32_t back = 0;       ///< the row seen from behind the geometric normal; itself for one-sided materials
  std::uint32_t two_sided = 0;  ///< 1: the frame is turned towards the viewer
  std::uint32_t bucket = 0;     ///< sorting key; ordered by kind, then material
  float words[kMaxClosureWords] = {};  ///< the parameters' leaves in declaration order
};
static_assert(sizeof(MaterialRow) == 64);

/// Stores parameters into a row.
template <template <class> class Parameters> void set_parameters(MaterialRow& row, const Parameters<Scalar>& parameters) {
  static_assert(kLeafCount<Parameters> <= kMaxClosureWords);
  row.kind = Parameters<Scalar>::kKind;
  int i = 0;
  std::apply([&](const auto&... leaf) { ((row.words[i++] = leaf), ...); }, leaves(parameters));
}

}  // namespace sheaf
