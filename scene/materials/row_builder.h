// Building of rows of the material table from the parameters of a model.
#pragma once

#include "core/color/color.h"
#include "scene/materials/closure_tables.h"
#include "scene/materials/list.h"
#include "scene/materials/rough_coat.h"
#include "scene/spectra/spectrum_rgb.h"
#include "scene/spectra/spectrum_set.h"
#include "scene/tables/texture.h"

#include <algorithm>

namespace sheaf {

/// Spectra of a material's parameters, in order.
using MaterialSpectra = std::array<SpectrumRow, kMaxClosureSpectra>;

/// Destinations and shared state for making rows.
struct RowContext {
  std::vector<TextureBinding>& bindings;  ///< appended to
  ClosureTables& tables;                  ///< appended to
  SpectrumSet* set = nullptr;             ///< spectral mode: makes rows of spectra
  MaterialSpectra rows = {};              ///< spectral mode: spectra of the most recent row
  float largest_reflectance = 0;          ///< maximum of all constants so far, before clamping
  const char* warning = nullptr;          ///< about the most recent row
  RoughCoats coats = {};
};

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

  void set(std::uint32_t& leaf, bool flag) { leaf = flag ? 1 : 0; }

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

  /// Sets the first parameters to the inputs that a model declares by kParameters, in order.
  template <class Model> void set_declared(const Model& model) {
    const auto inputs = Model::fields(model);
    const auto parameters = Parameters<Scalar>::fields(p);
    constexpr std::size_t kCount = std::size(Model::kParameters);
    static_assert(!DeclarativeBsdf<Model> || std::tuple_size_v<decltype(parameters)> == kCount);
    [&]<std::size_t... I>(std::index_sequence<I...>) { (set(std::get<I>(parameters), std::get<I>(inputs)), ...); }
    (std::make_index_sequence<kCount>{});
  }

  void set_roughness(const RoughnessDescription& roughness) {
    set(p.alpha_u, roughness.alpha_u);
    set(p.alpha_v, roughness.alpha_v);
  }

  /// Spectral mode: sets the luminance of the base color, with the weights of `role`, if one of the tints is used.
  void set_base_luminance(const SpectrumInput& base_color, std::initializer_list<ScalarInput> tints, TextureRole role) {
    const auto is_used = [](const ScalarInput& tint) { return tint != ScalarInput(0.0f); };
    if (context.set == nullptr || std::none_of(tints.begin(), tints.end(), is_used)) return;
    if (const auto* texture = std::get_if<TextureId>(&base_color)) return bind(p.base_luminance, *texture, 1, role);
    const Spectrum4& color = p.base_color;
    p.base_luminance = role == TextureRole::kBurleyLuminance ? 0.3f * color.c0 + 0.6f * color.c1 + 0.1f * color.c2
                                                             : luminance({color.c0, color.c1, color.c2});
  }

  /// The spectrum of one of the parameters.
  SpectrumRow& row_of(const Spectrum4& spectrum) {
    constexpr ClosureSpectra kSpectra = closure_spectra<Parameters>();
    const auto* found =
        std::find(kSpectra.word, kSpectra.word + kSpectra.count, static_cast<int>(word_of(spectrum.c0)));
    return context.rows[static_cast<std::size_t>(found - kSpectra.word)];
  }

  std::uint32_t word_of(const float& leaf) const {
    std::uint32_t word = 0, i = 0;
    std::apply([&](const auto&... each) { ((static_cast<const void*>(&each) == & leaf ? word = i : 0u, ++i), ...); },
               leaves(p));
    return word;
  }

  /// The row of a closure with these parameters.
  template <class Closure> MaterialRow row() const {
    static_assert(std::is_same_v<typename Closure::template Parameters<Scalar>, Parameters<Scalar>>);
    MaterialRow out;
    set_parameters<Parameters>(out, kClosureKind<Closure>, p);
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

/// Only anisotropic surfaces need the tangent.
inline MaterialRow with_tangent(MaterialRow row, const RoughnessDescription& roughness) {
  if (roughness.alpha_u != roughness.alpha_v) row.flags |= kNeedsUv;
  return row;
}
inline MaterialRow with_tangent(MaterialRow row, const ScalarInput& anisotropic) {
  if (anisotropic != ScalarInput(0.0f)) row.flags |= kNeedsUv;
  return row;
}

/// Makes the row of a model that is not a composite. The caller sets `back`, `bucket` and the choices. Throws
/// SceneError for spectra that are not finite.
template <DerivedBsdf Model> MaterialRow make_row(const Model& model, RowContext& context) {
  return model.make_row(context);
}
template <DeclarativeBsdf Model> MaterialRow make_row(const Model& model, RowContext& context) {
  return [&]<class Closure>(ClosureList<Closure>) {
    MaterialRowBuilder<Closure::template Parameters> m{context};
    m.set_declared(model);
    return m.template row<Closure>();
  }(typename Model::Closures{});
}

}  // namespace sheaf
