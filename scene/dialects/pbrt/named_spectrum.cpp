// The pbrt dialect: spectra by name or from files, and their luminance.
#include "core/color/color.h"
#include "scene/data/illuminants.h"
#include "scene/data/metals.h"
#include "scene/description/spectrum_check.h"
#include "scene/dialects/pbrt/reader.h"
#include "scene/formats/mesh_io.h"

#include <cmath>

namespace sheaf::pbrt {

namespace {

/// Returns "metal-Au-eta", "metal-Au-k" etc.; nullopt for other names.
std::optional<SpectrumDescription> find_metal_spectrum(const std::string& name) {
  const bool eta = name.ends_with("-eta"), k = name.ends_with("-k");
  if (!name.starts_with("metal-") || (!eta && !k)) return std::nullopt;
  const std::size_t begin = std::string_view("metal-").size();
  const std::span<const MetalSample> samples = find_metal(name.substr(begin, name.rfind('-') - begin));
  if (samples.empty()) return std::nullopt;
  SpectrumDescription::Table table;
  for (const MetalSample& sample : samples) {
    table.wavelengths.push_back(sample.wavelength);
    table.values.push_back(eta ? sample.eta : sample.k);
  }
  return SpectrumDescription{std::move(table)};
}

/// Returns "stdillum-D65" etc. Emission is relative to D65, so D65 is the constant 1.
std::optional<SpectrumDescription> find_illuminant_spectrum(const std::string& name) {
  if (!name.starts_with("stdillum-")) return std::nullopt;
  std::string short_name = name.substr(std::string_view("stdillum-").size());
  for (char& c : short_name) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  if (short_name == "d65") return SpectrumDescription::constant(1);
  std::optional<SpectrumDescription::Table> table = find_illuminant(short_name);
  if (!table) return std::nullopt;
  return SpectrumDescription{std::move(*table)};
}

std::string known_spectra() {
  std::string list;
  for (const std::string& metal : metal_names()) list += fmt::format("metal-{}-eta, metal-{}-k, ", metal, metal);
  for (const std::string& light : illuminant_names()) list += fmt::format("stdillum-{}, ", light);
  return list + "or a file";
}

/// Reads alternating wavelengths and values, with comments after #.
SpectrumDescription read_spectrum_file(const std::filesystem::path& file) {
  Tokens tokens(read_mesh_text(file, "spectrum file"), file.string());
  SpectrumDescription::Table table;
  bool value = false;
  for (; tokens.current().kind != Token::Kind::kEnd; tokens.advance(), value = !value) {
    const double number = number_of(tokens.current(), tokens.where(), value ? "a value" : "a wavelength");
    (value ? table.values : table.wavelengths).push_back(static_cast<float>(number));
  }
  check_table(table, {file.string(), 0});
  return {std::move(table)};
}

/// Returns the luminance Y, normalized to 1 for the equal-energy spectrum.
double luminance_of(const SpectrumDescription& spectrum) {
  using S = SpectrumDescription;
  const auto* table = std::get_if<S::Table>(&spectrum.value);
  const auto* body = std::get_if<S::Blackbody>(&spectrum.value);
  // Evaluate the spectrum
  const auto at = [&](double wavelength) {
    if (body != nullptr) return blackbody_radiance(wavelength, double{body->temperature}) * double{body->scale};
    const auto& x = table->wavelengths;
    for (std::size_t i = 1; i < x.size(); ++i) {
      const double x0 = double{x[i - 1]}, x1 = double{x[i]};
      if (wavelength < x0 || wavelength > x1) continue;
      const double t = (wavelength - x0) / (x1 - x0);
      return (1 - t) * double{table->values[i - 1]} + t * double{table->values[i]};
    }
    return 0.0;
  };
  // Integrate it with the CIE 1931 y-bar function
  double sum = 0, total = 0;
  for (float wavelength = kWavelengthMin; wavelength <= kWavelengthMax; wavelength += 1) {
    const double y = double{cie_1931_xyz(wavelength).y};
    sum += y * at(double{wavelength});
    total += y;
  }
  return sum / total;
}

}  // namespace

SpectrumDescription with_unit_luminance(SpectrumDescription spectrum, const Parameters& p) {
  const double y = luminance_of(spectrum);
  if (!(y > 0) || !std::isfinite(y)) p.fail("has a spectrum of light without luminance, expected a positive luminance");
  return scaled(std::move(spectrum), static_cast<float>(1 / y));
}

SpectrumDescription named_spectrum(Parameters& p, const char* parameter, const std::string& name, Use use) {
  if (std::optional<SpectrumDescription> illuminant = find_illuminant_spectrum(name)) {
    if (use != Use::kLight)
      p.fail_at(parameter, fmt::format("is '{}', an illuminant, expected another kind of spectrum", name));
    return *illuminant;
  }
  std::optional<SpectrumDescription> spectrum = find_metal_spectrum(name);
  if (!spectrum) {
    const bool known_to_pbrt = name.starts_with("metal-") || name.starts_with("glass-") ||
                               name.starts_with("stdillum-") || name.starts_with("illum-");
    if (known_to_pbrt) {
      p.unsupported(fmt::format("'{}' is '{}', expected {}", parameter, name, known_spectra()), "rendered as gray");
      return SpectrumDescription::constant(1);
    }
    spectrum = read_spectrum_file(p.reader().find_file(name, p.find(parameter)->where));
  }
  return use == Use::kLight ? with_unit_luminance(std::move(*spectrum), p) : *spectrum;
}

}  // namespace sheaf::pbrt
