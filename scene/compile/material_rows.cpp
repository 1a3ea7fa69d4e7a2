#include "scene/compile/material_rows.h"

#include "core/color.h"
#include "scene/data/glasses.h"
#include "scene/data/rgb_basis.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace sheaf {

namespace {

using TableToRgb = Vec3f (*)(std::span<const float>, std::span<const float>);

Vec3f to_rgb(const SpectrumDescription& spectrum, TableToRgb table_to_rgb) {
  using S = SpectrumDescription;
  Vec3f rgb{};
  if (const auto* c = std::get_if<S::Constant>(&spectrum.value)) rgb = {c->value, c->value, c->value};
  if (const auto* c = std::get_if<S::Rgb>(&spectrum.value)) rgb = c->value;
  if (const auto* t = std::get_if<S::Table>(&spectrum.value))
    rgb = t->equal_energy ? emission_table_to_rgb(t->wavelengths, t->values) : table_to_rgb(t->wavelengths, t->values);
  if (const auto* b = std::get_if<S::Blackbody>(&spectrum.value)) rgb = blackbody_to_rgb(b->temperature, b->scale);
  return {std::max(rgb.x, 0.0f), std::max(rgb.y, 0.0f), std::max(rgb.z, 0.0f)};
}

/// The maximum value given by the file; 0 for black bodies, which are not reflectances.
float largest_value(const SpectrumDescription& spectrum) {
  using S = SpectrumDescription;
  if (const auto* c = std::get_if<S::Constant>(&spectrum.value)) return c->value;
  if (const auto* c = std::get_if<S::Rgb>(&spectrum.value)) return max_component(c->value);
  const auto* t = std::get_if<S::Table>(&spectrum.value);
  return t != nullptr && !t->values.empty() ? *std::max_element(t->values.begin(), t->values.end()) : 0.0f;
}

/// Builds a row's parameters: constants are stored, textures become bindings of the parameter's words.
template <template <class> class Parameters> struct MaterialRowBuilder {
  RowContext& context;
  Parameters<Scalar> p{};
  std::uint32_t first_binding = static_cast<std::uint32_t>(context.bindings.size());

  void set(float& leaf, const ScalarInput& input) {
    if (const float* value = std::get_if<float>(&input))
      leaf = *value;
    else
      bind(leaf, std::get<TextureId>(input), 1, TextureRole::kScalar);
  }

  void set(Spectrum4& spectrum, const SpectrumInput& input, TextureRole role = TextureRole::kReflectance) {
    if (const auto* value = std::get_if<SpectrumDescription>(&input)) {
      const bool reflectance = role == TextureRole::kReflectance;
      if (reflectance) context.largest_reflectance = std::max(context.largest_reflectance, largest_value(*value));
      const Vec3f rgb = reflectance ? reflectance_rgb(*value) : unbounded_rgb(*value);
      spectrum = {rgb.x, rgb.y, rgb.z, 0.0f};
      if (context.set != nullptr)
        row_of(spectrum) = context.set->row(*value, reflectance ? SpectrumUse::kReflectance : SpectrumUse::kUnbounded);
    } else {
      bind(spectrum.c0, std::get<TextureId>(input), 4, role);
    }
  }

  /// Spectral mode: sets the luminance of `color`, which was set from `input`, with the weights of `role`.
  void set_luminance(float& leaf, const Spectrum4& color, const SpectrumInput& input, TextureRole role) {
    if (context.set == nullptr) return;
    if (const auto* texture = std::get_if<TextureId>(&input)) return bind(leaf, *texture, 1, role);
    leaf = role == TextureRole::kBurleyLuminance ? 0.3f * color.c0 + 0.6f * color.c1 + 0.1f * color.c2
                                                 : luminance({color.c0, color.c1, color.c2});
  }

  /// The spectrum of one of the parameters.
  SpectrumRow& row_of(const Spectrum4& spectrum) {
    constexpr ClosureSpectra kSpectra = closure_spectra<Parameters>();
    const auto* place =
        std::find(kSpectra.word, kSpectra.word + kSpectra.count, static_cast<int>(word_of(spectrum.c0)));
    return context.rows[static_cast<std::size_t>(place - kSpectra.word)];
  }

  std::uint32_t word_of(const float& leaf) const {
    std::uint32_t word = 0, i = 0;
    std::apply([&](const auto&... each) { ((&each == & leaf ? word = i : 0u, ++i), ...); }, leaves(p));
    return word;
  }

  MaterialRow row(ClosureKind kind) const {
    MaterialRow out;
    set_parameters<Parameters>(out, kind, p);
    out.first_binding = first_binding;
    out.binding_count = static_cast<std::uint16_t>(context.bindings.size() - first_binding);
    if (out.binding_count > 0) out.flags |= kNeedsUv;
    return out;
  }

 private:
  void bind(const float& leaf, TextureId texture, std::uint32_t words, TextureRole role) {
    context.bindings.push_back({static_cast<std::uint32_t>(texture), word_of(leaf), words, role});
  }
};

bool is_ggx(const RoughnessDescription& r) { return r.distribution == RoughnessDescription::Distribution::kGgx; }

template <template <class> class Parameters>
void set_roughness(MaterialRowBuilder<Parameters>& m, const RoughnessDescription& roughness) {
  m.set(m.p.alpha_u, roughness.alpha_u);
  m.set(m.p.alpha_v, roughness.alpha_v);
}

/// Only anisotropic surfaces need the tangent.
MaterialRow with_tangent(MaterialRow row, const RoughnessDescription& roughness) {
  if (roughness.alpha_u != roughness.alpha_v) row.flags |= kNeedsUv;
  return row;
}
MaterialRow with_tangent(MaterialRow row, const ScalarInput& anisotropic) {
  if (anisotropic != ScalarInput(0.0f)) row.flags |= kNeedsUv;
  return row;
}

/// Makes the row of a DeclarativeBsdf, whose parameters map one to one.
template <ClosureKind Kind, template <class> class Parameters, DeclarativeBsdf Model>
MaterialRow make_plain_row(const Model& model, RowContext& context) {
  MaterialRowBuilder<Parameters> m{context};
  const auto inputs = Model::fields(model);
  const auto set = [&]<std::size_t... I>(const auto& leaves_of_m, std::index_sequence<I...>) {
    (m.set(std::get<I>(leaves_of_m), std::get<I>(inputs)), ...);
  };
  const auto parameters = Parameters<Scalar>::fields(m.p);
  constexpr std::size_t kCount = std::tuple_size_v<decltype(inputs)>;
  static_assert(std::tuple_size_v<decltype(parameters)> == kCount);
  set(parameters, std::make_index_sequence<kCount>{});
  return m.row(Kind);
}

template <DeclarativeBsdf Model> MaterialRow make_row(const Model& model, RowContext& context) {
  static_assert(closures_of_description<Model>() == 1, "for_each_closure() must name a plain model exactly once");
  MaterialRow row;
  for_each_closure([&]<ClosureKind Kind, template <class> class P, class Of>(ClosureEntry<Kind, P, Of>) {
    if constexpr (std::is_same_v<Of, Model>) row = make_plain_row<Kind, P>(model, context);
  });
  return row;
}

template <template <class> class Parameters>
void set_conductor(MaterialRowBuilder<Parameters>& m, const ConductorDescription& d) {
  const SpectrumInput none = SpectrumDescription::constant(0), mirror = SpectrumDescription::constant(1);
  m.set(m.p.eta, d.ior ? d.ior->eta : none, TextureRole::kUnbounded);
  m.set(m.p.k, d.ior ? d.ior->k : mirror, TextureRole::kUnbounded);
  // The fourth lane is unused in RGB mode. k = 1 keeps its Fresnel term finite.
  m.p.k.c3 = 1.0f;
  m.set(m.p.reflectance, d.specular_reflectance);
}

MaterialRow make_row(const ConductorDescription& d, RowContext& context) {
  if (!d.roughness) {
    MaterialRowBuilder<ConductorParameters> m{context};
    set_conductor(m, d);
    return m.row(ClosureKind::kConductor);
  }
  MaterialRowBuilder<RoughConductorParameters> m{context};
  set_conductor(m, d);
  set_roughness(m, *d.roughness);
  return with_tangent(
      m.row(is_ggx(*d.roughness) ? ClosureKind::kRoughConductorGgx : ClosureKind::kRoughConductorBeckmann),
      *d.roughness);
}

/// Relative index of refraction (inside over outside) by wavelength.
SpectrumRow relative_index(SpectrumSet& set, const DielectricDescription& d) {
  std::vector<float> samples(SpectrumTableView::kSamples);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const float lambda = kWavelengthMin + static_cast<float>(i);
    samples[i] = (d.int_dispersion ? ior<Scalar>(*d.int_dispersion, lambda) : d.int_ior) /
                 (d.ext_dispersion ? ior<Scalar>(*d.ext_dispersion, lambda) : d.ext_ior);
  }
  return set.tabulate(std::move(samples));
}

MaterialRow make_dispersive_row(const DielectricDescription& d, RowContext& context) {
  const auto make = [&](auto& m) {
    m.p.eta = Spectrum4(d.int_ior / d.ext_ior);
    m.row_of(m.p.eta) = relative_index(*context.set, d);
    m.set(m.p.reflectance, d.specular_reflectance);
    m.set(m.p.transmittance, d.specular_transmittance);
  };
  if (!d.roughness) {
    MaterialRowBuilder<DispersiveDielectricParameters> m{context};
    make(m);
    return m.row(d.thin ? ClosureKind::kDispersiveThinDielectric : ClosureKind::kDispersiveDielectric);
  }
  MaterialRowBuilder<DispersiveRoughDielectricParameters> m{context};
  make(m);
  set_roughness(m, *d.roughness);
  return with_tangent(m.row(is_ggx(*d.roughness) ? ClosureKind::kDispersiveRoughDielectricGgx
                                                 : ClosureKind::kDispersiveRoughDielectricBeckmann),
                      *d.roughness);
}

template <template <class> class Parameters>
void set_dielectric(MaterialRowBuilder<Parameters>& m, const DielectricDescription& d) {
  m.p.eta = d.int_ior / d.ext_ior;
  m.set(m.p.reflectance, d.specular_reflectance);
  m.set(m.p.transmittance, d.specular_transmittance);
}

MaterialRow make_row(const DielectricDescription& d, RowContext& context) {
  if (context.set != nullptr && (d.int_dispersion || d.ext_dispersion)) return make_dispersive_row(d, context);
  if (!d.roughness) {
    MaterialRowBuilder<DielectricParameters> m{context};
    set_dielectric(m, d);
    return m.row(d.thin ? ClosureKind::kThinDielectric : ClosureKind::kDielectric);
  }
  MaterialRowBuilder<RoughDielectricParameters> m{context};
  set_dielectric(m, d);
  set_roughness(m, *d.roughness);
  return with_tangent(
      m.row(is_ggx(*d.roughness) ? ClosureKind::kRoughDielectricGgx : ClosureKind::kRoughDielectricBeckmann),
      *d.roughness);
}

template <template <class> class Parameters>
void set_plastic(MaterialRowBuilder<Parameters>& m, const PlasticDescription& d) {
  m.p.eta = d.int_ior / d.ext_ior;
  m.set(m.p.diffuse, d.diffuse_reflectance);
  m.set(m.p.specular, d.specular_reflectance);
  m.p.nonlinear = d.nonlinear ? 1.0f : 0.0f;
}

MaterialRow make_row(const PlasticDescription& d, RowContext& context) {
  if (!d.roughness) {
    MaterialRowBuilder<PlasticParameters> m{context};
    set_plastic(m, d);
    m.p.internal_reflectance = smooth_coat_internal_reflectance(m.p.eta);
    return m.row(ClosureKind::kPlastic);
  }
  MaterialRowBuilder<RoughPlasticParameters> m{context};
  set_plastic(m, d);
  m.set(m.p.alpha, d.roughness->alpha_u);
  const RoughCoat coat = context.coats.coat(d.roughness->distribution, m.p.alpha, m.p.eta);
  m.p.internal_reflectance = coat.internal_reflectance;
  std::copy(coat.transmittance.begin(), coat.transmittance.end(), m.p.transmittance);
  return m.row(is_ggx(*d.roughness) ? ClosureKind::kRoughPlasticGgx : ClosureKind::kRoughPlasticBeckmann);
}

const ScalarInput kNoTint = 0.0f;

MaterialRow make_row(const PrincipledDescription& d, RowContext& context) {
  MaterialRowBuilder<PrincipledParameters> m{context};
  m.set(m.p.base_color, d.base_color);
  m.set(m.p.roughness, d.roughness);
  m.set(m.p.anisotropic, d.anisotropic);
  m.set(m.p.metallic, d.metallic);
  m.set(m.p.spec_trans, d.spec_trans);
  m.set(m.p.spec_tint, d.spec_tint);
  m.set(m.p.sheen, d.sheen);
  m.set(m.p.sheen_tint, d.sheen_tint);
  m.set(m.p.flatness, d.flatness);
  m.set(m.p.clearcoat, d.clearcoat);
  m.set(m.p.clearcoat_gloss, d.clearcoat_gloss);
  // An index-matched boundary would transmit without refraction, a delta lobe without a pdf.
  constexpr float kMinTransmittingEta = 1.001f;
  const bool matched = d.eta == 1.0f && d.spec_trans != ScalarInput(0.0f);
  m.p.eta = matched ? kMinTransmittingEta : d.eta;
  if (d.spec_tint != kNoTint || d.sheen_tint != kNoTint)
    m.set_luminance(m.p.base_luminance, m.p.base_color, d.base_color, TextureRole::kScalar);
  return with_tangent(m.row(ClosureKind::kPrincipled), d.anisotropic);
}

MaterialRow make_row(const PrincipledThinDescription& d, RowContext& context) {
  MaterialRowBuilder<PrincipledThinParameters> m{context};
  m.set(m.p.base_color, d.base_color);
  m.set(m.p.roughness, d.roughness);
  m.set(m.p.anisotropic, d.anisotropic);
  m.set(m.p.spec_trans, d.spec_trans);
  m.set(m.p.eta, d.eta);
  m.set(m.p.spec_tint, d.spec_tint);
  m.set(m.p.sheen, d.sheen);
  m.set(m.p.sheen_tint, d.sheen_tint);
  m.set(m.p.flatness, d.flatness);
  m.set(m.p.diff_trans, d.diff_trans);
  if (d.spec_tint != kNoTint || d.sheen_tint != kNoTint)
    m.set_luminance(m.p.base_luminance, m.p.base_color, d.base_color, TextureRole::kScalar);
  return with_tangent(m.row(ClosureKind::kPrincipledThin), d.anisotropic);
}

MaterialRow make_row(const DisneyDescription& d, RowContext& context) {
  MaterialRowBuilder<DisneyParameters> m{context};
  m.set(m.p.base_color, d.base_color);
  m.set(m.p.metallic, d.metallic);
  m.set(m.p.subsurface, d.subsurface);
  m.set(m.p.specular, d.specular);
  m.set(m.p.specular_tint, d.specular_tint);
  m.set(m.p.roughness, d.roughness);
  m.set(m.p.anisotropic, d.anisotropic);
  m.set(m.p.sheen, d.sheen);
  m.set(m.p.sheen_tint, d.sheen_tint);
  m.set(m.p.clearcoat, d.clearcoat);
  m.set(m.p.clearcoat_gloss, d.clearcoat_gloss);
  if (d.specular_tint != kNoTint || d.sheen_tint != kNoTint)
    m.set_luminance(m.p.base_luminance, m.p.base_color, d.base_color, TextureRole::kBurleyLuminance);
  return with_tangent(m.row(ClosureKind::kDisney), d.anisotropic);
}

MaterialRow make_row(const NoriMicrofacetDescription& d, RowContext& context) {
  MaterialRowBuilder<NoriMicrofacetParameters> m{context};
  m.set(m.p.kd, d.kd);
  m.set(m.p.alpha, d.alpha);
  m.p.eta = d.int_ior / d.ext_ior;
  return m.row(ClosureKind::kNoriMicrofacet);
}

MaterialRow make_row(const RoughDiffuseDescription& d, RowContext& context) {
  MaterialRowBuilder<RoughDiffuseParameters> m{context};
  m.set(m.p.reflectance, d.reflectance);
  m.set(m.p.alpha, d.alpha);
  m.p.fast = d.fast ? 1.0f : 0.0f;
  return m.row(ClosureKind::kRoughDiffuse);
}

MaterialRow make_row(const WardDescription& d, RowContext& context) {
  MaterialRowBuilder<WardParameters> m{context};
  m.set(m.p.diffuse, d.diffuse_reflectance);
  m.set(m.p.specular, d.specular_reflectance);
  m.set(m.p.alpha_u, d.alpha_u);
  m.set(m.p.alpha_v, d.alpha_v);
  m.p.variant = static_cast<float>(d.variant);
  MaterialRow row = m.row(ClosureKind::kWard);
  if (d.alpha_u != d.alpha_v) row.flags |= kNeedsUv;
  return row;
}

MaterialRow make_row(const HanrahanKruegerDescription& d, RowContext& context) {
  MaterialRowBuilder<HanrahanKruegerParameters> m{context};
  m.set(m.p.first, d.first, TextureRole::kUnbounded);
  m.set(m.p.second, d.second, d.by_albedo ? TextureRole::kReflectance : TextureRole::kUnbounded);
  m.p.by_albedo = d.by_albedo ? 1.0f : 0.0f;
  m.p.thickness = d.thickness;
  m.p.g = d.g;
  return m.row(ClosureKind::kHanrahanKrueger);
}

MaterialRow make_row(const MeasuredDescription& d, RowContext& context) {
  const ClosureTables::Measured& measured = context.tables.measured(d.file, context.set != nullptr);
  const auto with_flags = [&](MaterialRow row) {
    if (!measured.isotropic) row.flags |= kNeedsUv;
    return row;
  };
  if (!measured.wavelengths.empty()) {
    MaterialRowBuilder<MeasuredSpectralParameters> m{context};
    m.p.table = measured.table;
    m.row_of(m.p.place) = context.set->tabulate(places_of_wavelengths(measured.wavelengths));
    return with_flags(m.row(ClosureKind::kMeasuredSpectral));
  }
  MaterialRowBuilder<MeasuredParameters> m{context};
  m.p.table = measured.table;
  m.p.red = {1, 0, 0, 0}, m.p.green = {0, 1, 0, 0}, m.p.blue = {0, 0, 1, 0};
  if (context.set != nullptr) {
    Spectrum4* const colors[] = {&m.p.red, &m.p.green, &m.p.blue};
    for (int c = 0; c < 3; ++c) m.row_of(*colors[c]) = context.set->tabulate(rgb_basis(c));
  }
  return with_flags(m.row(ClosureKind::kMeasured));
}

/// Absorption by melanin, per fibre radius and unit of concentration, in linear Rec.709 (d'Eon et al. 2011; PBR 9.9).
const SpectrumDescription kEumelanin = SpectrumDescription::rgb(0.419f, 0.697f, 1.37f);
const SpectrumDescription kPheomelanin = SpectrumDescription::rgb(0.187f, 0.4f, 1.05f);

MaterialRow make_row(const HairDescription& d, RowContext& context) {
  MaterialRowBuilder<HairParameters> m{context};
  if (const auto* by = std::get_if<HairDescription::Melanin>(&d.color)) {
    m.set(m.p.eumelanin_absorption, kEumelanin, TextureRole::kUnbounded);
    m.set(m.p.pheomelanin_absorption, kPheomelanin, TextureRole::kUnbounded);
    m.set(m.p.eumelanin, by->eumelanin);
    m.set(m.p.pheomelanin, by->pheomelanin);
  }
  if (const auto* by = std::get_if<HairDescription::Absorption>(&d.color)) {
    m.set(m.p.absorption, by->sigma_a, TextureRole::kUnbounded);
    m.p.scale = by->scale;
  }
  if (const auto* by = std::get_if<HairDescription::Reflectance>(&d.color)) {
    m.set(m.p.absorption, by->color);
    m.p.by_reflectance = 1;
  }
  m.set(m.p.longitudinal_roughness, d.longitudinal_roughness);
  m.set(m.p.azimuthal_roughness, d.azimuthal_roughness);
  m.p.tilt = d.scale_tilt * (kPi / 180);
  m.p.eta = d.int_ior / d.ext_ior;
  m.p.fourth = context.set != nullptr ? 1.0f : 0.0f;
  MaterialRow row = m.row(ClosureKind::kHair);
  row.flags |= kNeedsUv;  // the fibre is along the tangent
  return row;
}

/// Moves the parameters of `nested`, the most recent row, to their positions after the coat's own.
template <template <class> class Parameters>
void set_nested(MaterialRowBuilder<Parameters>& m, const MaterialRow& nested, const MaterialSpectra& spectra) {
  const std::uint32_t base = m.word_of(m.p.nested_spectra[0].c0);
  constexpr std::size_t kNestedWords = 4 * kCoatableSpectra + kCoatableNumbers;
  float words[kNestedWords] = {};
  for_each_closure([&]<ClosureKind Kind, template <class> class P, class D>(ClosureEntry<Kind, P, D>) {
    if (Kind != nested.kind) return;
    for (int k = 0; k < kLeafCount<P>; ++k) words[coated_word<P>(k)] = nested.words[k];
    for (std::uint32_t b = 0; b < nested.binding_count; ++b) {
      std::uint32_t& word = m.context.bindings[nested.first_binding + b].word;
      word = base + static_cast<std::uint32_t>(coated_word<P>(static_cast<int>(word)));
    }
  });
  const auto to = leaves(m.p);
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    constexpr auto kFirst = static_cast<std::size_t>(kLeafCount<CoatedParameters>) - sizeof...(I);
    ((std::get<kFirst + I>(to) = words[I]), ...);
  }
  (std::make_index_sequence<kNestedWords>{});
  for (std::size_t i = 0; i < kCoatableSpectra; ++i) m.row_of(m.p.nested_spectra[i]) = spectra[i];
  m.p.nested_kind = static_cast<float>(nested.kind);
  m.first_binding = nested.first_binding;
}

template <template <class> class Parameters>
MaterialRow coated_row(ClosureKind kind, const CoatDescription& d, const MaterialRow& nested,
                       MaterialRowBuilder<Parameters>& m) {
  const MaterialSpectra spectra = std::exchange(m.context.rows, {});
  set_nested(m, nested, spectra);
  m.p.coat_eta = d.int_ior / d.ext_ior;
  m.p.coat_thickness = d.thickness;
  m.set(m.p.coat_absorption, d.sigma_a, TextureRole::kUnbounded);
  m.set(m.p.coat_specular, d.specular_reflectance);
  MaterialRow row = m.row(kind);
  row.flags |= nested.flags;
  return row;
}

/// Combinations of materials have no row of their own; see compile_materials().
template <class T, class... Of>
concept OneOf = (std::is_same_v<T, Of> || ...);
template <OneOf<CoatDescription, NullDescription, TwoSidedDescription, MaskDescription, BlendDescription,
                BumpMapDescription, NormalMapDescription>
              Combination>
MaterialRow make_row(const Combination&, RowContext&) {
  return {};
}

}  // namespace

Vec3f emission_rgb(const SpectrumDescription& spectrum) { return to_rgb(spectrum, emission_table_to_rgb); }

Vec3f reflectance_rgb(const SpectrumDescription& spectrum) {
  const Vec3f rgb = to_rgb(spectrum, reflectance_table_to_rgb);
  return {std::min(rgb.x, 1.0f), std::min(rgb.y, 1.0f), std::min(rgb.z, 1.0f)};
}

std::string clamped_reflectance(float largest) {
  char text[128];
  std::snprintf(text, sizeof(text), "a reflectance of %g is clamped to 1", static_cast<double>(largest));
  return text;
}

Vec3f unbounded_rgb(const SpectrumDescription& spectrum) { return to_rgb(spectrum, unbounded_table_to_rgb); }

MaterialRow make_material_row(const MaterialDescription& material, RowContext& context) {
  context.rows = {};
  return std::visit([&](const auto& model) { return make_row(model, context); }, material.model);
}

MaterialRow make_coated_row(const CoatDescription& coat, const MaterialDescription& nested, RowContext& context) {
  const auto first_binding = static_cast<std::uint32_t>(context.bindings.size());
  MaterialRow below = make_material_row(nested, context);
  below.first_binding = first_binding;
  if (!closure_info(below.kind).is_coatable)
    throw SceneError(std::string(closure_info(below.kind).name) + " cannot be coated");
  if (!coat.roughness) {
    MaterialRowBuilder<CoatedParameters> m{context};
    return coated_row(ClosureKind::kCoated, coat, below, m);
  }
  MaterialRowBuilder<RoughCoatedParameters> m{context};
  m.set(m.p.coat_alpha, coat.roughness->alpha_u);
  const RoughCoat rough = context.coats.coat(coat.roughness->distribution, m.p.coat_alpha, coat.int_ior / coat.ext_ior);
  std::copy(rough.transmittance.begin(), rough.transmittance.end(), m.p.transmittance);
  const bool ggx = is_ggx(*coat.roughness);
  return coated_row(ggx ? ClosureKind::kRoughCoatedGgx : ClosureKind::kRoughCoatedBeckmann, coat, below, m);
}

}  // namespace sheaf
