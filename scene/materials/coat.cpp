// Coats: reading, and the row over the row of the base.
#include "scene/materials/coat.h"

#include "scene/materials/flattener.h"
#include "scene/materials/reading.h"

#include <algorithm>
#include <utility>

namespace sheaf {

namespace {

/// Moves the parameters of `base`, the most recent row, to their positions after the coat's own.
template <template <class> class Parameters>
void set_base(MaterialRowBuilder<Parameters>& m, const MaterialRow& base, const MaterialSpectra& spectra) {
  // Copy the parameters of the base, and redirect its texture bindings
  const std::uint32_t first_word = m.word_of(m.p.nested_spectra[0].c0);
  constexpr std::size_t kNestedWords = 4 * kCoatableSpectra + kCoatableNumbers;
  float words[kNestedWords] = {};
  for_each_closure([&]<class Closure>(ClosureKind kind, Closure) {
    if constexpr (Closure::kInfo.is_coatable) {
      if (kind != base.kind) return;
      constexpr int kWords = kLeafCount<Closure::template Parameters>;
      for (int k = 0; k < kWords; ++k) words[coated_word<Closure::template Parameters>(k)] = base.words[k];
      for (std::uint32_t b = 0; b < base.binding_count; ++b) {
        std::uint32_t& word = m.context.bindings[base.first_binding + b].word;
        const int moved = coated_word<Closure::template Parameters>(static_cast<int>(word));
        word = first_word + static_cast<std::uint32_t>(moved);
      }
    }
  });
  // Store them in the parameters of the coat
  const auto to = leaves(m.p);
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    constexpr auto kFirst = static_cast<std::size_t>(kLeafCount<CoatedParameters>) - sizeof...(I);
    ((std::get<kFirst + I>(to) = words[I]), ...);
  }
  (std::make_index_sequence<kNestedWords>{});
  for (std::size_t i = 0; i < kCoatableSpectra; ++i) m.row_of(m.p.nested_spectra[i]) = spectra[i];
  m.p.nested_kind = static_cast<std::uint32_t>(base.kind);
  m.first_binding = base.first_binding;
}

template <template <class> class Parameters>
void set_coat(MaterialRowBuilder<Parameters>& m, const CoatDescription& d, const MaterialRow& base) {
  const MaterialSpectra spectra = std::exchange(m.context.rows, {});
  set_base(m, base, spectra);
  m.p.coat_eta = d.int_ior / d.ext_ior;
  m.p.coat_thickness = d.thickness;
  m.set(m.p.coat_absorption, d.sigma_a, TextureRole::kUnbounded);
  m.set(m.p.coat_specular, d.specular_reflectance);
}

MaterialRow with_flags_of(MaterialRow row, const MaterialRow& base) {
  row.flags |= base.flags;
  return row;
}

CoatDescription read_coat(Properties& p, const BsdfDialect& dialect, bool rough) {
  CoatDescription result;
  result.int_ior = read_ior(p, "int_ior", result.int_ior);
  result.ext_ior = read_ior(p, "ext_ior", result.ext_ior);
  result.thickness = p.number("thickness", result.thickness, kNotNegative);
  result.sigma_a = p.spectrum_input("sigma_a", result.sigma_a, SpectrumRole::kIor);
  result.specular_reflectance = read_reflectance(p, "specular_reflectance", result.specular_reflectance);
  if (rough) result.roughness = read_uniform_roughness(p);
  result.nested = read_nested_bsdf(p, dialect);
  expect_opaque(p, result.nested);
  return result;
}

}  // namespace

CoatDescription CoatDescription::read_smooth(Properties& p, const BsdfDialect& dialect) {
  return read_coat(p, dialect, false);
}

CoatDescription CoatDescription::read_rough(Properties& p, const BsdfDialect& dialect) {
  return read_coat(p, dialect, true);
}

std::uint32_t CoatDescription::flatten(MaterialFlattener& flattener, const MaterialWrappers& around,
                                       const SourceLocation& where) const {
  if (around.coat != nullptr) throw SceneError(where, "a coat cannot hold another one");
  if (flattener.transmits(nested)) throw SceneError(where, "a coat cannot hold a material that transmits light");
  MaterialWrappers inside = around;
  inside.coat = this;
  return flattener.flatten(nested, inside);
}

MaterialRow CoatDescription::make_row_over(const MaterialRow& base, RowContext& context) const {
  if (!closure_info(base.kind).is_coatable)
    throw SceneError(std::string(closure_info(base.kind).name) + " cannot be coated");
  if (!roughness) {
    MaterialRowBuilder<CoatedParameters> m{context};
    set_coat(m, *this, base);
    return with_flags_of(m.row<CoatedClosure>(), base);
  }
  MaterialRowBuilder<RoughCoatedParameters> m{context};
  m.p.coat_alpha = uniform_roughness(*roughness);
  const RoughCoat rough = context.coats.coat(roughness->distribution, m.p.coat_alpha, int_ior / ext_ior);
  std::copy(rough.transmittance.begin(), rough.transmittance.end(), m.p.transmittance);
  set_coat(m, *this, base);
  return with_flags_of(roughness->is_ggx() ? m.row<RoughCoatedGgxClosure>() : m.row<RoughCoatedBeckmannClosure>(),
                       base);
}

}  // namespace sheaf
