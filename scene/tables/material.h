// Materials for kernels: closures with their parameters, and the rows of the material table.
#pragma once

#include "core/record_table.h"
#include "core/spectrum.h"
#include "scene/description/description.h"

namespace sheaf {

/// Kinds of closures, by which vertices are sorted and dispatched, once per bucket. See for_each_closure() below.
enum class ClosureKind : std::uint32_t {
  kDiffuse,
  kConductor,
  kDielectric,
  kThinDielectric,
  kPlastic,
  kRoughConductorBeckmann,
  kRoughConductorGgx,
  kRoughDielectricBeckmann,
  kRoughDielectricGgx,
  kRoughPlasticBeckmann,
  kRoughPlasticGgx,
  kPrincipled,
  kPrincipledThin,
  kDisney,
  kNoriMicrofacet,
  kDispersiveDielectric,
  kDispersiveThinDielectric,
  kDispersiveRoughDielectricBeckmann,
  kDispersiveRoughDielectricGgx,
  kPhong,
  kRoughDiffuse,
  kWard,
  kDiffuseTransmitter,
  kHanrahanKrueger,
  kMeasured,
  kMeasuredSpectral,
  kHair,
  kCoated,
  kRoughCoatedBeckmann,
  kRoughCoatedGgx,
  kHenyeyGreenstein,
  kRayleigh,
  kTabulatedPhase,
  kSggx,
  kCount
};
inline constexpr int kClosureKinds = static_cast<int>(ClosureKind::kCount);

/// Parameters of Lambertian reflection (kernels/bsdf/diffuse.h).
template <class L> struct DiffuseParameters {
  Spectrum<L> reflectance;  ///< in [0, 1]
  static constexpr auto fields(auto& s) { return std::tie(s.reflectance); }
};

/// Parameters of specular reflection off a metal (kernels/bsdf/conductor.h).
template <class L> struct ConductorParameters {
  Spectrum<L> eta, k;  ///< complex index of refraction relative to the outside; eta 0 with k 1 gives a perfect mirror
  Spectrum<L> reflectance;  ///< factor on the Fresnel reflectance
  static constexpr auto fields(auto& s) { return std::tie(s.eta, s.k, s.reflectance); }
};

/// Parameters of specular reflection and refraction (kernels/bsdf/dielectric.h, thin_dielectric.h).
template <class L> struct DielectricParameters {
  typename L::Float eta;      ///< int / ext
  Spectrum<L> reflectance;    ///< factor on reflected light
  Spectrum<L> transmittance;  ///< factor on transmitted light
  static constexpr auto fields(auto& s) { return std::tie(s.eta, s.reflectance, s.transmittance); }
};

/// Parameters of reflection off a rough metal (kernels/bsdf/rough_conductor.h).
template <class L> struct RoughConductorParameters {
  Spectrum<L> eta, k, reflectance;     ///< as for ConductorParameters
  typename L::Float alpha_u, alpha_v;  ///< roughness along the tangent and the bitangent
  static constexpr auto fields(auto& s) { return std::tie(s.eta, s.k, s.reflectance, s.alpha_u, s.alpha_v); }
};

/// Parameters of a rough boundary between dielectrics (kernels/bsdf/rough_dielectric.h).
template <class L> struct RoughDielectricParameters {
  typename L::Float eta;                   ///< int / ext
  Spectrum<L> reflectance, transmittance;  ///< as for DielectricParameters
  typename L::Float alpha_u, alpha_v;      ///< roughness along the tangent and the bitangent
  static constexpr auto fields(auto& s) {
    return std::tie(s.eta, s.reflectance, s.transmittance, s.alpha_u, s.alpha_v);
  }
};

/// DielectricParameters with an index per wavelength (kernels/bsdf/dispersive_dielectric.h). Spectral mode only.
template <class L> struct DispersiveDielectricParameters {
  Spectrum<L> eta;  ///< int / ext
  Spectrum<L> reflectance, transmittance;
  static constexpr auto fields(auto& s) { return std::tie(s.eta, s.reflectance, s.transmittance); }
};

/// RoughDielectricParameters with an index per wavelength (kernels/bsdf/dispersive_rough_dielectric.h).
template <class L> struct DispersiveRoughDielectricParameters {
  Spectrum<L> eta, reflectance, transmittance;
  typename L::Float alpha_u, alpha_v;
  static constexpr auto fields(auto& s) {
    return std::tie(s.eta, s.reflectance, s.transmittance, s.alpha_u, s.alpha_v);
  }
};

/// Parameters of a diffuse base under a smooth coat (kernels/bsdf/plastic.h).
template <class L> struct PlasticParameters {
  typename L::Float eta;          ///< int / ext
  Spectrum<L> diffuse, specular;  ///< reflectance of the base; factor on the coat's reflection
  typename L::Float nonlinear;    ///< 1: colour shifts due to multiple scattering between base and coat; else 0
  typename L::Float internal_reflectance;  ///< internal diffuse reflectance of the coat
  static constexpr auto fields(auto& s) {
    return std::tie(s.eta, s.diffuse, s.specular, s.nonlinear, s.internal_reflectance);
  }
};

/// Terms of the polynomial fit to a rough coat's transmittance; see kernels/bsdf/rough_plastic.h.
inline constexpr int kTransmittanceTerms = 8;

/// Parameters of a diffuse base under a rough coat (kernels/bsdf/rough_plastic.h).
template <class L> struct RoughPlasticParameters {
  typename L::Float eta;                                 ///< int / ext
  Spectrum<L> diffuse, specular;                         ///< as for PlasticParameters
  typename L::Float nonlinear;                           ///< as for PlasticParameters
  typename L::Float internal_reflectance;                ///< as for PlasticParameters
  typename L::Float alpha;                               ///< roughness
  typename L::Float transmittance[kTransmittanceTerms];  ///< transmittance of the coat as a function of the cosine
  static constexpr auto fields(auto& s) {
    return std::tie(s.eta, s.diffuse, s.specular, s.nonlinear, s.internal_reflectance, s.alpha, s.transmittance);
  }
};

/// Parameters of the principled BSDF (kernels/bsdf/principled.h), named as in Burley 2015.
template <class L> struct PrincipledParameters {
  Spectrum<L> base_color;
  typename L::Float roughness, anisotropic, metallic, spec_trans, spec_tint, sheen, sheen_tint, flatness, clearcoat,
      clearcoat_gloss;
  typename L::Float eta;  ///< int / ext
  /// Luminance of base_color for the tints, needed if base_color holds reflectances at four wavelengths. Zero: not
  /// given, or black.
  typename L::Float base_luminance{};
  static constexpr auto fields(auto& s) {
    return std::tie(s.base_color, s.roughness, s.anisotropic, s.metallic, s.spec_trans, s.spec_tint, s.sheen,
                    s.sheen_tint, s.flatness, s.clearcoat, s.clearcoat_gloss, s.eta, s.base_luminance);
  }
};

/// Parameters of the thin principled BSDF (kernels/bsdf/principled_thin.h).
template <class L> struct PrincipledThinParameters {
  Spectrum<L> base_color;
  typename L::Float roughness, anisotropic, spec_trans, eta, spec_tint, sheen, sheen_tint, flatness, diff_trans;
  typename L::Float base_luminance{};  ///< as for PrincipledParameters
  static constexpr auto fields(auto& s) {
    return std::tie(s.base_color, s.roughness, s.anisotropic, s.spec_trans, s.eta, s.spec_tint, s.sheen, s.sheen_tint,
                    s.flatness, s.diff_trans, s.base_luminance);
  }
};

/// Parameters of the BRDF of Burley 2012 (kernels/bsdf/disney.h).
template <class L> struct DisneyParameters {
  Spectrum<L> base_color;
  typename L::Float metallic, subsurface, specular, specular_tint, roughness, anisotropic, sheen, sheen_tint, clearcoat,
      clearcoat_gloss;
  /// As for PrincipledParameters, with the weights of the course notes: 0.3, 0.6, 0.1.
  typename L::Float base_luminance{};
  static constexpr auto fields(auto& s) {
    return std::tie(s.base_color, s.metallic, s.subsurface, s.specular, s.specular_tint, s.roughness, s.anisotropic,
                    s.sheen, s.sheen_tint, s.clearcoat, s.clearcoat_gloss, s.base_luminance);
  }
};

/// Parameters of Nori's microfacet BRDF (kernels/bsdf/nori_microfacet.h).
template <class L> struct NoriMicrofacetParameters {
  Spectrum<L> kd;           ///< diffuse reflectance; the rest is reflected specularly
  typename L::Float alpha;  ///< Beckmann roughness
  typename L::Float eta;    ///< int / ext
  static constexpr auto fields(auto& s) { return std::tie(s.kd, s.alpha, s.eta); }
};

/// Parameters of the Phong BRDF (kernels/bsdf/phong.h).
template <class L> struct PhongParameters {
  Spectrum<L> diffuse, specular;  ///< reflectances; their sum is at most 1
  typename L::Float exponent;     ///< not negative
  static constexpr auto fields(auto& s) { return std::tie(s.diffuse, s.specular, s.exponent); }
};

/// Parameters of the Oren-Nayar BRDF (kernels/bsdf/rough_diffuse.h).
template <class L> struct RoughDiffuseParameters {
  Spectrum<L> reflectance;  ///< of the facets
  typename L::Float alpha;  ///< roughness
  typename L::Float fast;   ///< 1: simplified model without interreflection; else 0
  static constexpr auto fields(auto& s) { return std::tie(s.reflectance, s.alpha, s.fast); }
};

/// Parameters of Ward's BRDF (kernels/bsdf/ward.h).
template <class L> struct WardParameters {
  Spectrum<L> diffuse, specular;       ///< reflectances
  typename L::Float alpha_u, alpha_v;  ///< roughness along the tangent and the bitangent
  typename L::Float variant;           ///< WardDescription::Variant
  static constexpr auto fields(auto& s) { return std::tie(s.diffuse, s.specular, s.alpha_u, s.alpha_v, s.variant); }
};

/// Parameters of diffuse transmission (kernels/bsdf/diffuse_transmitter.h).
template <class L> struct DiffuseTransmitterParameters {
  Spectrum<L> transmittance;  ///< in [0, 1]
  static constexpr auto fields(auto& s) { return std::tie(s.transmittance); }
};

/// Parameters of a slab with single scattering (kernels/bsdf/hanrahan_krueger.h).
template <class L> struct HanrahanKruegerParameters {
  Spectrum<L> first, second;    ///< extinction and albedo; or scattering and absorption
  typename L::Float by_albedo;  ///< 1: the former; 0: the latter
  typename L::Float thickness;
  typename L::Float g;  ///< as for HenyeyGreensteinParameters
  static constexpr auto fields(auto& s) { return std::tie(s.first, s.second, s.by_albedo, s.thickness, s.g); }
};

/// Parameters of a measured BRDF with three colour channels (kernels/bsdf/measured.h).
template <class L> struct MeasuredParameters {
  typename L::Float table;       ///< see scene/tables/closure_tables.h
  Spectrum<L> red, green, blue;  ///< spectra of the table's three channels
  static constexpr auto fields(auto& s) { return std::tie(s.table, s.red, s.green, s.blue); }
};

/// Parameters of a measured BRDF with values at many wavelengths. Spectral mode only.
template <class L> struct MeasuredSpectralParameters {
  typename L::Float table;
  Spectrum<L> place;  ///< index of each wavelength in the table, with a fraction for interpolation
  static constexpr auto fields(auto& s) { return std::tie(s.table, s.place); }
};

/// Parameters of a hair fibre (kernels/bsdf/hair.h).
template <class L> struct HairParameters {
  Spectrum<L> absorption;  ///< per fibre radius, times `scale`; or the colour of dense hair, see `by_reflectance`
  Spectrum<L> eumelanin_absorption, pheomelanin_absorption;  ///< per fibre radius and unit of concentration
  typename L::Float scale;
  typename L::Float eumelanin, pheomelanin;                       ///< concentrations
  typename L::Float longitudinal_roughness, azimuthal_roughness;  ///< in [0, 1]
  typename L::Float tilt;                                         ///< tilt of the scales, radians
  typename L::Float eta;                                          ///< int / ext
  typename L::Float by_reflectance;  ///< 1: absorption is derived from a reflectance; else 0
  typename L::Float fourth;          ///< 1 if the fourth lane is a wavelength; else 0
  static constexpr auto fields(auto& s) {
    return std::tie(s.absorption, s.eumelanin_absorption, s.pheomelanin_absorption, s.scale, s.eumelanin, s.pheomelanin,
                    s.longitudinal_roughness, s.azimuthal_roughness, s.tilt, s.eta, s.by_reflectance, s.fourth);
  }
};

/// Maximum numbers of spectra and of scalars among the parameters of a closure that can be coated.
inline constexpr int kCoatableSpectra = 3, kCoatableNumbers = 12;

/// Parameters of a smooth coat over another closure, with that closure's parameters (kernels/bsdf/coated.h).
template <class L> struct CoatedParameters {
  typename L::Float coat_eta;  ///< inside over outside
  typename L::Float coat_thickness;
  Spectrum<L> coat_absorption;                         ///< per length
  Spectrum<L> coat_specular;                           ///< factor on the coat's reflection
  typename L::Float nested_kind;                       ///< ClosureKind of the coated closure
  Spectrum<L> nested_spectra[kCoatableSpectra];        ///< its spectra, in order
  typename L::Float nested_numbers[kCoatableNumbers];  ///< its scalar parameters, in order
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

/// A kind of closure with its parameters and properties.
template <ClosureKind Kind, template <class> class P, class D = void> struct ClosureEntry {
  static constexpr ClosureKind kKind = Kind;
  template <class L> using Parameters = P<L>;
  /// The DeclarativeBsdf that this closure implements; void: its rows are made by separate code.
  using Description = D;
  const char* name;                 ///< for reports
  bool is_thin_dielectric = false;  ///< only reflects and transmits straight on
  bool is_phase = false;            ///< a phase function; see kernels/bsdf/bsdf.h
  bool is_coatable = false;         ///< opaque and not a coat itself; see kernels/bsdf/coated.h
};

/// Calls f(ClosureEntry) for all closures, in the order of ClosureKind. A closure that is listed here but has no BSDF
/// in kernels/bsdf/all.h, or vice versa, is a compile-time error.
template <class F> constexpr void for_each_closure(F&& f) {
  using enum ClosureKind;
  f(ClosureEntry<kDiffuse, DiffuseParameters, DiffuseDescription>{.name = "diffuse", .is_coatable = true});
  f(ClosureEntry<kConductor, ConductorParameters>{.name = "conductor", .is_coatable = true});
  f(ClosureEntry<kDielectric, DielectricParameters>{"dielectric"});
  f(ClosureEntry<kThinDielectric, DielectricParameters>{.name = "thin_dielectric", .is_thin_dielectric = true});
  f(ClosureEntry<kPlastic, PlasticParameters>{.name = "plastic", .is_coatable = true});
  f(ClosureEntry<kRoughConductorBeckmann, RoughConductorParameters>{.name = "rough_conductor_beckmann",
                                                                    .is_coatable = true});
  f(ClosureEntry<kRoughConductorGgx, RoughConductorParameters>{.name = "rough_conductor_ggx", .is_coatable = true});
  f(ClosureEntry<kRoughDielectricBeckmann, RoughDielectricParameters>{"rough_dielectric_beckmann"});
  f(ClosureEntry<kRoughDielectricGgx, RoughDielectricParameters>{"rough_dielectric_ggx"});
  f(ClosureEntry<kRoughPlasticBeckmann, RoughPlasticParameters>{.name = "rough_plastic_beckmann", .is_coatable = true});
  f(ClosureEntry<kRoughPlasticGgx, RoughPlasticParameters>{.name = "rough_plastic_ggx", .is_coatable = true});
  f(ClosureEntry<kPrincipled, PrincipledParameters>{.name = "principled", .is_coatable = true});
  f(ClosureEntry<kPrincipledThin, PrincipledThinParameters>{"principled_thin"});
  f(ClosureEntry<kDisney, DisneyParameters>{.name = "disney", .is_coatable = true});
  f(ClosureEntry<kNoriMicrofacet, NoriMicrofacetParameters>{.name = "nori_microfacet", .is_coatable = true});
  f(ClosureEntry<kDispersiveDielectric, DispersiveDielectricParameters>{"dispersive_dielectric"});
  f(ClosureEntry<kDispersiveThinDielectric, DispersiveDielectricParameters>{.name = "dispersive_thin_dielectric",
                                                                            .is_thin_dielectric = true});
  f(ClosureEntry<kDispersiveRoughDielectricBeckmann, DispersiveRoughDielectricParameters>{
      "dispersive_rough_dielectric_beckmann"});
  f(ClosureEntry<kDispersiveRoughDielectricGgx, DispersiveRoughDielectricParameters>{
      "dispersive_rough_dielectric_ggx"});
  f(ClosureEntry<kPhong, PhongParameters, PhongDescription>{.name = "phong", .is_coatable = true});
  f(ClosureEntry<kRoughDiffuse, RoughDiffuseParameters>{.name = "rough_diffuse", .is_coatable = true});
  f(ClosureEntry<kWard, WardParameters>{.name = "ward", .is_coatable = true});
  f(ClosureEntry<kDiffuseTransmitter, DiffuseTransmitterParameters, DiffuseTransmitterDescription>{
      "diffuse_transmitter"});
  f(ClosureEntry<kHanrahanKrueger, HanrahanKruegerParameters>{"hanrahan_krueger"});
  f(ClosureEntry<kMeasured, MeasuredParameters>{"measured"});
  f(ClosureEntry<kMeasuredSpectral, MeasuredSpectralParameters>{"measured_spectral"});
  f(ClosureEntry<kHair, HairParameters>{"hair"});
  f(ClosureEntry<kCoated, CoatedParameters>{"coated"});
  f(ClosureEntry<kRoughCoatedBeckmann, RoughCoatedParameters>{"rough_coated_beckmann"});
  f(ClosureEntry<kRoughCoatedGgx, RoughCoatedParameters>{"rough_coated_ggx"});
  f(ClosureEntry<kHenyeyGreenstein, HenyeyGreensteinParameters>{.name = "henyey_greenstein", .is_phase = true});
  f(ClosureEntry<kRayleigh, RayleighParameters>{.name = "rayleigh", .is_phase = true});
  f(ClosureEntry<kTabulatedPhase, TabulatedPhaseParameters>{.name = "tabulated_phase", .is_phase = true});
  f(ClosureEntry<kSggx, SggxParameters>{.name = "sggx", .is_phase = true});
}

/// The data of ClosureEntry for a kind known only at run time.
struct ClosureInfo {
  const char* name = nullptr;
  bool is_thin_dielectric = false, is_phase = false, is_coatable = false;
};

namespace material_detail {

consteval std::array<ClosureInfo, kClosureKinds> closure_infos() {
  std::array<ClosureInfo, kClosureKinds> infos;
  std::size_t count = 0;
  for_each_closure([&](auto entry) {
    if (static_cast<std::size_t>(entry.kKind) != count) throw "the list must be in the order of ClosureKind";
    infos[count++] = {entry.name, entry.is_thin_dielectric, entry.is_phase, entry.is_coatable};
  });
  if (count != infos.size()) throw "a kind of closure is not in the list";
  return infos;
}

}  // namespace material_detail

/// Indexed by ClosureKind.
inline constexpr std::array<ClosureInfo, kClosureKinds> kClosureInfos = material_detail::closure_infos();

constexpr const ClosureInfo& closure_info(ClosureKind kind) { return kClosureInfos[static_cast<std::size_t>(kind)]; }

/// Number of closures that implement a DeclarativeBsdf.
template <class Description> consteval int closures_of_description() {
  int count = 0;
  for_each_closure([&]<ClosureKind K, template <class> class P, class D>(ClosureEntry<K, P, D>) {
    count += std::is_same_v<D, Description>;
  });
  return count;
}

/// Maximum number of 32-bit parameter words of a closure; a multiple of four.
inline constexpr int kMaxClosureWords = 56;

/// Maximum number of spectra among the parameters of a closure.
inline constexpr int kMaxClosureSpectra = 2 + kCoatableSpectra;

/// Positions of the spectra among a closure's parameters: the first of their four words, in order.
struct ClosureSpectra {
  int count = 0;
  int word[kMaxClosureSpectra] = {};
};

/// Derived from the types in fields().
template <template <class> class Parameters> constexpr ClosureSpectra closure_spectra() {
  ClosureSpectra found;
  int word = 0;
  const auto visit = [&]<class Field>(const Field*) {
    using Element = std::remove_all_extents_t<Field>;
    constexpr std::size_t kWords = sizeof(Element) / sizeof(float), kElements = sizeof(Field) / sizeof(Element);
    const int end = word + static_cast<int>(kWords * kElements);
    if (std::is_same_v<Element, Spectrum4>)
      for (int at = word; at < end; at += 4) found.word[found.count++] = at;
    word = end;
  };
  using Fields = decltype(Parameters<Scalar>::fields(std::declval<Parameters<Scalar>&>()));
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    (visit(static_cast<const std::remove_reference_t<std::tuple_element_t<I, Fields>>*>(nullptr)), ...);
  }
  (std::make_index_sequence<std::tuple_size_v<Fields>>{});
  return found;
}

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

/// Bits of MaterialRow::flags.
enum MaterialFlags : std::uint32_t {
  kTwoSided = 1,   ///< the shading frame is flipped towards the viewer
  kNeedsUv = 2,    ///< needs uv coordinates: for textures, maps or a tangent
  kMapped = 4,     ///< the shading normal comes from a map
  kComposite = 8,  ///< a choice between other rows, see MaterialRow::choice; never shaded
  kPart = 16,      ///< one of the rows that a composite material chooses from
};

/// One material after flattening of composites. 64 words.
struct alignas(64) MaterialRow {
  ClosureKind kind = ClosureKind::kDiffuse;
  std::uint32_t back = 0;              ///< row for the back side of the surface; the row itself for one-sided materials
  std::uint32_t flags = 0;             ///< MaterialFlags
  std::uint16_t bucket = 0;            ///< sorting key; ordered by kind, then material
  std::uint16_t binding_count = 0;     ///< number of its texture bindings
  std::uint32_t first_binding = 0;     ///< into MaterialView::bindings
  std::uint32_t map = 0;               ///< kMapped: into MaterialView::normal_maps
  std::uint32_t choice[2] = {};        ///< kComposite: the two rows; kNothing: light passes unchanged
  float words[kMaxClosureWords] = {};  ///< parameters' leaves in declaration order
  static constexpr std::uint32_t kNothing = 0xffffffffu;
  /// kComposite: probability of the second choice, in [0, 1], unless a texture gives it. The only parameter of such
  /// rows.
  float second_share() const { return words[0]; }
};
static_assert(sizeof(MaterialRow) == 256);

/// A normal or bump map.
struct NormalMapRow {
  std::uint32_t texture = 0;  ///< into TextureView::rows
  std::uint32_t flags = 0;
  float scale = 1;  ///< kBump: factor of the texture's gradient
  /// Bits of `flags`.
  enum : std::uint32_t {
    kBump = 1,        ///< the texture is a height field, not a normal map
    kFlipGreen = 2,   ///< green points down
    kFixInvalid = 4,  ///< normals that face away from the viewer are mirrored at the unmapped normal
    kSoften = 8,      ///< soften the shadow terminator
  };
};

/// Writes parameters into a row.
template <template <class> class Parameters>
void set_parameters(MaterialRow& row, ClosureKind kind, const Parameters<Scalar>& parameters) {
  static_assert(kLeafCount<Parameters> <= kMaxClosureWords);
  row.kind = kind;
  int i = 0;
  std::apply([&](const auto&... leaf) { ((row.words[i++] = leaf), ...); }, leaves(parameters));
}

}  // namespace sheaf
