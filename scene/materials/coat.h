// A dielectric layer over an opaque material, smooth or rough.
#pragma once

#include "scene/materials/model.h"
#include "scene/materials/roughness.h"

#include <optional>

namespace sheaf {

/// Maximum numbers of spectra and of scalars among the parameters of a closure that can be coated.
inline constexpr int kCoatableSpectra = 3, kCoatableNumbers = 12;

/// Parameters of a smooth coat over another closure, with that closure's parameters (kernels/bsdf/coated.h).
template <class L> struct CoatedParameters {
  typename L::Float coat_eta;  ///< inside over outside
  typename L::Float coat_thickness;
  Spectrum<L> coat_absorption;                         ///< per length
  Spectrum<L> coat_specular;                           ///< factor on the coat's reflection
  typename L::Uint nested_kind;                        ///< ClosureKind of the coated closure
  Spectrum<L> nested_spectra[kCoatableSpectra];        ///< its spectra, in order
  typename L::Float nested_numbers[kCoatableNumbers];  ///< its scalar parameters, in order; the bits of integers
  static constexpr auto fields(auto& s) {
    return std::tie(s.coat_eta, s.coat_thickness, s.coat_absorption, s.coat_specular, s.nested_kind, s.nested_spectra,
                    s.nested_numbers);
  }
};

/// Parameters of a rough coat over another closure (kernels/bsdf/rough_coated.h).
template <class L> struct RoughCoatedParameters : CoatedParameters<L> {
  typename L::Float coat_alpha;                          ///< roughness
  typename L::Float transmittance[kTransmittanceTerms];  ///< as in RoughPlasticParameters
  static constexpr auto fields(auto& s) {
    return std::tuple_cat(CoatedParameters<L>::fields(s), std::tie(s.coat_alpha, s.transmittance));
  }
};

struct CoatedClosure : ClosureOf<CoatedParameters> {
  static constexpr ClosureInfo kInfo = {.name = "coated"};
};
struct RoughCoatedBeckmannClosure : ClosureOf<RoughCoatedParameters> {
  static constexpr ClosureInfo kInfo = {.name = "rough_coated_beckmann"};
};
struct RoughCoatedGgxClosure : ClosureOf<RoughCoatedParameters> {
  static constexpr ClosureInfo kInfo = {.name = "rough_coated_ggx"};
};

/// Position of word `k` of a coated closure's parameters among the words of nested_spectra and nested_numbers.
template <template <class> class Parameters> constexpr int coated_word(int k) {
  constexpr ClosureSpectra kSpectra = closure_spectra<Parameters>();
  int spectra_before = 0;
  for (int i = 0; i < kSpectra.count; ++i) {
    if (k >= kSpectra.word[i] && k < kSpectra.word[i] + 4) return 4 * i + k - kSpectra.word[i];
    spectra_before += k >= kSpectra.word[i] ? 1 : 0;
  }
  return 4 * kCoatableSpectra + k - 4 * spectra_before;
}

/// A dielectric layer over an opaque material.
struct CoatDescription {
  float int_ior = 1.5046f, ext_ior = 1.000277f;
  float thickness = 1;                                       ///< meters
  SpectrumInput sigma_a = SpectrumDescription::constant(0);  ///< absorption inside the coat, 1/m
  SpectrumInput specular_reflectance = SpectrumDescription::constant(1);
  std::optional<RoughnessDescription> roughness;  ///< empty: smooth; otherwise with the limits of PlasticDescription
  MaterialId nested{};

  using Closures = ClosureList<CoatedClosure, RoughCoatedBeckmannClosure, RoughCoatedGgxClosure>;
  static CoatDescription read_smooth(Properties& p, const BsdfDialect& dialect);
  static CoatDescription read_rough(Properties& p, const BsdfDialect& dialect);
  static constexpr Plugin<CoatDescription> kPlugins[] = {{"coating", read_smooth}, {"roughcoating", read_rough}};
  static constexpr auto fields(auto& s) {
    return std::tie(s.int_ior, s.ext_ior, s.thickness, s.sigma_a, s.specular_reflectance, s.roughness, s.nested);
  }
  bool transmits(const NestedTransmission& of) const { return of(nested); }
  std::uint32_t flatten(MaterialFlattener& flattener, const MaterialWrappers& around,
                        const SourceLocation& where) const;
  /// The row of this coat over `base`, the most recent row of the context. Throws SceneError if the closure of `base`
  /// cannot be coated.
  MaterialRow make_row_over(const MaterialRow& base, RowContext& context) const;
};

}  // namespace sheaf
