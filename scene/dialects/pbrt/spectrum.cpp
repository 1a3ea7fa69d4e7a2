// The pbrt dialect: colors, spectra, and parameters that accept textures.
#include "core/color/color.h"
#include "scene/data/glasses.h"
#include "scene/description/spectrum_check.h"
#include "scene/dialects/pbrt/reader.h"

#include <algorithm>

namespace sheaf::pbrt {

namespace {

/// Wavelength (nm) of cataloged glass indices: the helium d line.
constexpr float kCatalogWavelength = 587.56f;

SpectrumDescription rgb_spectrum(Parameters& p, const char* name, const Parameter& parameter, Use use) {
  const std::vector<double>& n = parameter.numbers;
  if (n.size() != 3) p.fail_at(name, fmt::format("has {} numbers, expected red, green and blue", n.size()));
  const Vec3f rgb{static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2])};
  return {SpectrumDescription::Rgb{to_rec709(p, rgb, use)}};
}

/// Reads alternating wavelengths and values, extended as constant beyond both ends.
SpectrumDescription table_spectrum(Parameters& p, const char* name, const Parameter& parameter) {
  const std::vector<double>& n = parameter.numbers;
  if (n.empty() || n.size() % 2 != 0)
    p.fail_at(name, fmt::format("has {} numbers, expected wavelengths and values in turn", n.size()));
  SpectrumDescription::Table table;
  const auto add = [&](double wavelength, double value) {
    table.wavelengths.push_back(static_cast<float>(wavelength));
    table.values.push_back(static_cast<float>(value));
  };
  constexpr double kFirst = double{kWavelengthMin} - 1, kLast = double{kWavelengthMax} + 1;
  if (n[0] > kFirst) add(kFirst, n[1]);
  for (std::size_t i = 0; i < n.size(); i += 2) add(n[i], n[i + 1]);
  if (n[n.size() - 2] < kLast) add(kLast, n.back());
  check_table(table, parameter.where);
  return {std::move(table)};
}

/// Reads a blackbody, normalized to a maximum of 1 as in pbrt.
SpectrumDescription blackbody_spectrum(Parameters& p, const char* name, const Parameter& parameter) {
  constexpr double kWien = 2.8977721e6;  // Wien's displacement constant, nm K
  if (parameter.numbers.size() != 1 || !(parameter.numbers[0] > 0))
    p.fail_at(name, "is invalid, expected one positive temperature (kelvin)");
  const double temperature = parameter.numbers[0];
  const double largest = blackbody_radiance(kWien / temperature, temperature);
  if (!(largest > 0)) p.fail_at(name, "is too cold, expected a temperature with visible emission (kelvin)");
  return {SpectrumDescription::Blackbody{static_cast<float>(temperature), static_cast<float>(1 / largest)}};
}

SpectrumDescription read_spectrum(Parameters& p, const char* name, const Parameter& parameter, Use use) {
  const std::string& type = parameter.type;
  if (type == "rgb") return rgb_spectrum(p, name, parameter, use);
  if (type == "spectrum" && parameter.strings.size() == 1) return named_spectrum(p, name, parameter.strings[0], use);
  SpectrumDescription spectrum;
  if (type == "spectrum" && parameter.strings.empty()) {
    spectrum = table_spectrum(p, name, parameter);
  } else if (type == "blackbody") {
    spectrum = blackbody_spectrum(p, name, parameter);
  } else {
    p.fail_at(name, fmt::format("is of the type {}, expected rgb, spectrum or blackbody", type));
  }
  return use == Use::kLight ? with_unit_luminance(std::move(spectrum), p) : spectrum;
}

/// Returns the texture that a parameter names.
template <class Input, class Other>
const Input& texture_of(Parameters& p, const char* name, const Parameter& parameter, const char* kind,
                        const std::map<std::string, Input, std::less<>>& known, const Other& others) {
  if (parameter.strings.size() != 1) p.fail_at(name, "is invalid, expected the name of one texture");
  const std::string& texture = parameter.strings[0];
  const auto found = known.find(texture);
  if (found == known.end()) {
    std::vector<std::string> names;
    for (const auto& entry : known) names.push_back(entry.first);
    const bool other = others.find(texture) != others.end();
    p.fail_at(name, fmt::format("is the texture '{}', {}", texture,
                                other ? "of the other kind, expected one of the kind " + std::string(kind)
                                      : fmt::format("not defined yet{} (known of the kind {}: {})",
                                                    did_you_mean(texture, names), kind,
                                                    names.empty() ? "none" : joined(names))));
  }
  p.reader().used_texture = true;
  return found->second;
}

}  // namespace

std::optional<SpectrumDescription> find_spectrum(Parameters& p, const char* name, Use use) {
  const Parameter* parameter = p.find(name);
  if (parameter == nullptr) return std::nullopt;
  SpectrumDescription spectrum = read_spectrum(p, name, *parameter, use);
  const SpectrumRole role = use == Use::kReflectance ? SpectrumRole::kReflectance : SpectrumRole::kEmission;
  check_role(spectrum, role, parameter->where, p.subject(*parameter));
  return spectrum;
}

std::optional<SpectrumInput> find_spectrum_input(Parameters& p, const char* name, Use use) {
  const Parameter* parameter = p.find(name);
  if (parameter == nullptr) return std::nullopt;
  if (parameter->type == "texture")
    return texture_of(p, name, *parameter, "spectrum", p.reader().spectrum_textures, p.reader().float_textures);
  if (parameter->type == "float") return SpectrumDescription::constant(p.number(name, 0, kNotNegative));
  return find_spectrum(p, name, use);
}

std::optional<ScalarInput> find_scalar_input(Parameters& p, const char* name) {
  const Parameter* parameter = p.find(name);
  if (parameter == nullptr) return std::nullopt;
  if (parameter->type == "texture")
    return texture_of(p, name, *parameter, "float", p.reader().float_textures, p.reader().spectrum_textures);
  return p.number(name, 0);
}

Index read_index(Parameters& p, const char* name, float default_value) {
  const Parameter* parameter = p.find(name);
  if (parameter == nullptr) return {default_value, std::nullopt};
  if (parameter->type == "float") return {p.number(name, default_value, kPositive), std::nullopt};
  if (parameter->type == "spectrum" && parameter->strings.size() == 1) {
    std::string glass = parameter->strings[0];
    for (char& c : glass) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    if (glass.starts_with("glass-")) glass.erase(0, 6);
    // pbrt's names of Schott's SF5, SF10 and SF11.
    if (glass == "f5" || glass == "f10" || glass == "f11") glass.insert(0, 1, 's');
    if (const Dispersion* found = find_dispersion(glass)) return {ior<Scalar>(*found, kCatalogWavelength), *found};
    p.unsupported(
        fmt::format("'{}' is '{}', an unknown glass{}", name, parameter->strings[0], known_names(dispersion_names())),
        "rendered with an index of " + number_text(double{default_value}));
    return {default_value, std::nullopt};
  }
  if (parameter->type == "spectrum" && parameter->numbers.size() >= 2) {
    p.unsupported(fmt::format("'{}' is a table of indices by wavelength", name), "rendered with the first one");
    return {static_cast<float>(parameter->numbers[1]), std::nullopt};
  }
  p.fail_at(name, fmt::format("is of the type {}, expected a float or the name of a glass", parameter->type));
}

}  // namespace sheaf::pbrt
