// Reading of spectra and colors.
#include "scene/dialects/xml/read_spectrum.h"

#include "scene/data/illuminants.h"
#include "scene/xml/xml_values.h"

#include <algorithm>

namespace sheaf {

namespace {

/// Reads a named illuminant with luminance `scale`.
SpectrumDescription read_illuminant(Properties& p) {
  const std::string name = p.required_string("name");
  std::optional<SpectrumDescription::Table> table = find_illuminant(name);
  if (!table) p.fail_choice("name", name, illuminant_names());
  const float scale = p.number("scale", 1, kNotNegative);
  for (float& value : table->values) value *= scale;
  return {std::move(*table)};
}

/// Reads `value`: a number, or three numbers without color conversion.
SpectrumDescription read_raw_constant(Properties& p) {
  if (!p.has("value")) p.fail("needs the property 'value'", SceneErrorCode::kMissing);
  const auto is_vector = [](const XmlElement& child) {
    return child.find_attribute("name") != nullptr && child.attribute("name") == "value" &&
           (child.name == "vector" || child.name == "point");
  };
  const std::vector<XmlElement>& children = p.element().children;
  if (std::any_of(children.begin(), children.end(), is_vector))
    return {SpectrumDescription::Rgb{p.find_vec3("value").value_or(Vec3f{1, 1, 1})}};
  return p.find_spectrum("value", SpectrumRole::kIor).value_or(SpectrumDescription::constant(1));
}

SpectrumDescription read_uniform(Properties& p) {
  p.ignore({"wavelength_min", "wavelength_max"});
  return SpectrumDescription::constant(p.number("value", 1));
}

SpectrumDescription read_d65(Properties& p) {
  return SpectrumDescription::constant(p.number("scale", 1, kNotNegative));
}

SpectrumDescription read_srgb(Properties& p) {
  std::optional<SpectrumDescription> color = p.find_spectrum("color", SpectrumRole::kIor);
  if (!color) p.fail("needs the property 'color'", SceneErrorCode::kMissing);
  return *std::move(color);
}

SpectrumDescription read_blackbody_plugin(Properties& p) {
  const std::optional<float> temperature = p.find_number("temperature", kPositive);
  if (!temperature) p.fail("needs the float 'temperature' (kelvin)", SceneErrorCode::kMissing);
  p.ignore({"wavelength_min", "wavelength_max"});
  return {SpectrumDescription::Blackbody{*temperature, p.number("scale", 1, kNotNegative)}};
}

/// Reads a string of numbers.
std::vector<float> read_list(Properties& p, const char* name) {
  return parse_floats(p.required_string(name), p.where(), name);
}

/// Reads wavelengths and values.
SpectrumDescription read_irregular(Properties& p) {
  std::vector<float> wavelengths = read_list(p, "wavelengths");
  return {SpectrumDescription::Table{std::move(wavelengths), read_list(p, "values")}};
}

/// Reads values at equal steps of the wavelength.
SpectrumDescription read_regular(Properties& p) {
  SpectrumDescription::Table table{{}, read_list(p, "values")};
  const float low = p.number("wavelength_min", 360, kPositive), high = p.number("wavelength_max", 830, kPositive);
  const std::size_t n = table.values.size();
  for (std::size_t i = 0; i < n; ++i) {
    const float t = n > 1 ? static_cast<float>(i) / static_cast<float>(n - 1) : 0.0f;
    table.wavelengths.push_back((1 - t) * low + t * high);
  }
  return {std::move(table)};
}

/// Reads a spectrum plugin, <spectrum type="...">.
SpectrumDescription read_spectrum_plugin(const XmlElement& element, ReadContext& context) {
  Properties p(element, context);
  SpectrumDescription result = p.plugin(kSpectrumPlugins)(p);
  p.reject_unused();
  if (const auto* table = std::get_if<SpectrumDescription::Table>(&result.value)) check_table(*table, element.where);
  return result;
}

SpectrumDescription read_blackbody(const XmlElement& element) {
  element.expect_attributes({"name", "id", "temperature", "scale"});
  std::string_view kelvin = element.attribute("temperature");
  if (!kelvin.empty() && (kelvin.back() == 'K' || kelvin.back() == 'k')) kelvin.remove_suffix(1);
  SpectrumDescription::Blackbody result;
  result.temperature = parse_float(kelvin, element.where, "temperature");
  if (const std::string* scale = element.find_attribute("scale"))
    result.scale = parse_float(*scale, element.where, "scale");
  if (!(result.temperature > 0)) throw SceneError(element.where, "the temperature of <blackbody> must be positive");
  if (!(result.scale >= 0)) throw SceneError(element.where, "the scale of <blackbody> must not be negative");
  return {result};
}

}  // namespace

constexpr NameTable<SpectrumPluginReader> kSpectrumPlugins{{{"blackbody", read_blackbody_plugin},
                                                            {"d65", read_d65},
                                                            {"illuminant", read_illuminant},
                                                            {"irregular", read_irregular},
                                                            {"rawconstant", read_raw_constant},
                                                            {"regular", read_regular},
                                                            {"srgb", read_srgb},
                                                            {"uniform", read_uniform}}};

SpectrumDescription read_spectrum(const XmlElement& element, ReadContext& context) {
  if (element.name == "blackbody") return read_blackbody(element);
  const bool may_be_plugin = element.name == "spectrum" || element.name == "texture";
  if (may_be_plugin && element.find_attribute("type") != nullptr) return read_spectrum_plugin(element, context);
  element.expect_attributes({"name", "id", "value", element.name == "spectrum" ? "filename" : "value"});
  const std::string* file = element.find_attribute("filename");
  if (file != nullptr) {
    if (element.find_attribute("value") != nullptr)
      throw SceneError(element.where, "<spectrum> has both 'value' and 'filename'");
    return {read_spd(context.scene.find_file(*file, element.where))};
  }
  const std::string& text = element.attribute("value");
  if (element.name == "spectrum") return parse_spectrum_text(text, element.where);
  if (element.name == "rgb" || element.name == "color")
    return {SpectrumDescription::Rgb{parse_rgb(text, element.where)}};
  if (element.name == "srgb") return {SpectrumDescription::Rgb{parse_srgb(text, element.where)}};
  return SpectrumDescription::constant(parse_float(text, element.where, element.name));
}

SpectrumDescription read_property_spectrum(const XmlElement& element, SpectrumRole role, ReadContext& context) {
  SpectrumDescription spectrum = read_spectrum(element, context);
  if (role != SpectrumRole::kEmission || element.name != "spectrum") return spectrum;
  const auto* constant = std::get_if<SpectrumDescription::Constant>(&spectrum.value);
  const std::string* type = element.find_attribute("type");
  if (constant != nullptr && (type == nullptr || *type == "uniform"))
    spectrum.value = SpectrumDescription::Table{{360, 830}, {constant->value, constant->value}};
  return spectrum;
}

}  // namespace sheaf
