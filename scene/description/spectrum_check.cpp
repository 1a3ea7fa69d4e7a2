#include "scene/description/spectrum_check.h"

#include <algorithm>
#include <string>

namespace sheaf {

void check_table(const SpectrumDescription::Table& table, const SourceLocation& where) {
  if (table.wavelengths.size() != table.values.size())
    throw SceneError(
        where, fmt::format("spectrum has {} wavelengths and {} values", table.wavelengths.size(), table.values.size()));
  if (table.wavelengths.size() < 2) throw SceneError(where, "spectrum needs at least two wavelength:value pairs");
  if (!(table.wavelengths[0] > 0)) throw SceneError(where, "wavelengths must be positive nanometers");
  for (std::size_t i = 1; i < table.wavelengths.size(); ++i)
    if (!(table.wavelengths[i] > table.wavelengths[i - 1]))
      throw SceneError(where, fmt::format("wavelengths must increase, found {} after {}", table.wavelengths[i],
                                          table.wavelengths[i - 1]));
}

void check_role(const SpectrumDescription& spectrum, SpectrumRole role, const SourceLocation& where,
                std::string_view what) {
  auto check = [&](float value) {
    const bool legal = value >= 0 && (role != SpectrumRole::kReflectance || value <= 1);
    if (legal) return;
    const char* expected = role == SpectrumRole::kReflectance ? "values within [0, 1]" : "non-negative values";
    throw SceneError(where, fmt::format("{} contains {}, expected {}", what, value, expected));
  };
  if (const auto* constant = std::get_if<SpectrumDescription::Constant>(&spectrum.value)) check(constant->value);
  if (const auto* rgb = std::get_if<SpectrumDescription::Rgb>(&spectrum.value))
    for (float v : {rgb->value.x, rgb->value.y, rgb->value.z}) check(v);
  if (const auto* table = std::get_if<SpectrumDescription::Table>(&spectrum.value))
    std::for_each(table->values.begin(), table->values.end(), check);
  if (std::holds_alternative<SpectrumDescription::Blackbody>(spectrum.value) && role != SpectrumRole::kEmission)
    throw SceneError(where, std::string(what) + " is a blackbody, which only emitters can be");
}

}  // namespace sheaf
