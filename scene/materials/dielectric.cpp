// Boundaries between dielectrics: reading, and the row.
#include "scene/materials/dielectric.h"

#include "scene/data/glasses.h"
#include "scene/data/named_ior.h"
#include "scene/materials/reading.h"
#include "scene/materials/row_builder.h"

#include <cmath>

namespace sheaf {

namespace {

/// n = A + B / w^2 + C / w^4 with w in micrometers (Cauchy 1830).
Dispersion read_cauchy(Properties& p, const char* name) {
  const std::vector<float> numbers = read_numbers(p, name);
  if (numbers.size() < 2 || numbers.size() > 3)
    p.fail_at(name, fmt::format("has {} numbers, expected two or three: A, B, C", numbers.size()));
  Dispersion result{Dispersion::Form::kPowers, numbers[0], {}};
  for (std::size_t i = 1; i < numbers.size(); ++i) result.terms[i - 1] = {numbers[i], -2.0f * static_cast<float>(i)};
  return result;
}

/// n^2 = 1 + sum of B w^2 / (w^2 - C) (Sellmeier 1871); all B, then all C.
Dispersion read_sellmeier(Properties& p, const char* name) {
  const std::vector<float> numbers = read_numbers(p, name);
  const std::size_t terms = numbers.size() / 2;
  Dispersion result;
  if (terms == 0 || numbers.size() % 2 != 0 || terms > result.terms.size())
    p.fail_at(name, fmt::format("has {} numbers, expected B1 B2 ... C1 C2 ..., as many B as C, {} of each at most",
                                numbers.size(), result.terms.size()));
  for (std::size_t i = 0; i < terms; ++i) result.terms[i] = {numbers[i], numbers[terms + i]};
  return result;
}

/// Throws SceneError at a property that gives an impossible index of refraction.
Dispersion checked(Properties& p, const char* name, const Dispersion& dispersion) {
  for (float lambda = 360; lambda <= 830; ++lambda)
    if (const float n = ior<Scalar>(dispersion, lambda); !(n > 0.0f) || !std::isfinite(n))
      p.fail_at(name,
                fmt::format("has no index of refraction at {} nm, expected positive ones from 360 to 830 nm",
                            static_cast<int>(lambda)),
                SceneErrorCode::kOutOfRange);
  return dispersion;
}

/// Reads the index of refraction of one side of a boundary and its dispersion; `side` is "int" or "ext".
/// `names_disperse`: whether named materials are dispersive; nullopt: all except those of find_ior().
void read_side(Properties& p, const std::string& side, std::optional<bool> names_disperse, float& index,
               std::optional<Dispersion>& dispersion) {
  const std::string plain = side + "_ior", cauchy = side + "_cauchy", sellmeier = side + "_sellmeier";
  const int given = int{p.has(plain.c_str())} + int{p.has(cauchy.c_str())} + int{p.has(sellmeier.c_str())};
  if (given > 1)
    p.fail(fmt::format("has more than one of '{}', '{}' and '{}', expected one", plain, cauchy, sellmeier),
           SceneErrorCode::kDuplicate);
  const auto find = [&](const char* name, Dispersion (*read)(Properties&, const char*)) {
    if (p.has(name)) dispersion = p.attempt(name, [&] { return checked(p, name, read(p, name)); });
  };
  find(cauchy.c_str(), read_cauchy);
  find(sellmeier.c_str(), read_sellmeier);
  if (dispersion) {
    index = catalog_ior(*dispersion);
    return;
  }
  index = read_ior(p, plain.c_str(), index);
  if (!p.is_string(plain.c_str())) return;
  const std::string name = p.string(plain.c_str(), "");
  const Dispersion* named = find_dispersion(name);
  if (named != nullptr && names_disperse.value_or(!find_ior(name))) dispersion = *named;
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

/// Sets the parameters that all dielectrics have, except the index.
void set_factors(auto& m, const DielectricDescription& d) {
  m.set(m.p.reflectance, d.specular_reflectance);
  m.set(m.p.transmittance, d.specular_transmittance);
  m.set(m.p.specular, d.specular);
  m.set(m.p.specular_color, d.specular_color, TextureRole::kUnbounded);
}

MaterialRow make_dispersive_row(const DielectricDescription& d, RowContext& context) {
  const auto make = [&](auto& m) {
    m.p.eta = Spectrum4(d.int_ior / d.ext_ior);
    m.row_of(m.p.eta) = relative_index(*context.set, d);
    set_factors(m, d);
  };
  if (!d.roughness) {
    MaterialRowBuilder<DispersiveDielectricParameters> m{context};
    make(m);
    return d.thin ? m.row<DispersiveThinDielectricClosure>() : m.row<DispersiveDielectricClosure>();
  }
  MaterialRowBuilder<DispersiveRoughDielectricParameters> m{context};
  make(m);
  m.set_roughness(*d.roughness);
  return with_tangent(d.roughness->is_ggx() ? m.row<DispersiveRoughDielectricGgxClosure>()
                                            : m.row<DispersiveRoughDielectricBeckmannClosure>(),
                      *d.roughness);
}

template <template <class> class Parameters>
void set_dielectric(MaterialRowBuilder<Parameters>& m, const DielectricDescription& d) {
  m.p.eta = d.int_ior / d.ext_ior;
  set_factors(m, d);
}

}  // namespace

DielectricDescription DielectricDescription::read_smooth(Properties& p, const BsdfDialect& dialect) {
  DielectricDescription result;
  std::optional<bool> names_disperse;
  if (dialect.names_disperse || p.has("dispersion")) names_disperse = p.boolean("dispersion", true);
  read_side(p, "int", names_disperse, result.int_ior, result.int_dispersion);
  read_side(p, "ext", names_disperse, result.ext_ior, result.ext_dispersion);
  if (p.has("dispersion") && *names_disperse && !result.int_dispersion && !result.ext_dispersion)
    p.report_at("dispersion",
                "is true, but neither side has a dispersion formula, expected coefficients or one of " +
                    list_of(dispersion_names()),
                SceneErrorCode::kMissing);
  result.specular_reflectance = read_reflectance(p, "specular_reflectance", result.specular_reflectance);
  result.specular_transmittance = read_reflectance(p, "specular_transmittance", result.specular_transmittance);
  return result;
}

DielectricDescription DielectricDescription::read_thin(Properties& p, const BsdfDialect& dialect) {
  DielectricDescription result = read_smooth(p, dialect);
  result.thin = true;
  return result;
}

DielectricDescription DielectricDescription::read_rough(Properties& p, const BsdfDialect& dialect) {
  DielectricDescription result = read_smooth(p, dialect);
  result.roughness = read_roughness(p);
  return result;
}

MaterialRow DielectricDescription::make_row(RowContext& context) const {
  if (context.set != nullptr && (int_dispersion || ext_dispersion)) return make_dispersive_row(*this, context);
  if (!roughness) {
    MaterialRowBuilder<DielectricParameters> m{context};
    set_dielectric(m, *this);
    return thin ? m.row<ThinDielectricClosure>() : m.row<DielectricClosure>();
  }
  MaterialRowBuilder<RoughDielectricParameters> m{context};
  set_dielectric(m, *this);
  m.set_roughness(*roughness);
  return with_tangent(
      roughness->is_ggx() ? m.row<RoughDielectricGgxClosure>() : m.row<RoughDielectricBeckmannClosure>(), *roughness);
}

}  // namespace sheaf
