#include "scene/spectra/spectrum_rgb.h"

#include "core/color/color.h"

#include <algorithm>
#include <cstdio>
#include <span>

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

}  // namespace

float largest_value(const SpectrumDescription& spectrum) {
  using S = SpectrumDescription;
  if (const auto* c = std::get_if<S::Constant>(&spectrum.value)) return c->value;
  if (const auto* c = std::get_if<S::Rgb>(&spectrum.value)) return max_component(c->value);
  const auto* t = std::get_if<S::Table>(&spectrum.value);
  return t != nullptr && !t->values.empty() ? *std::max_element(t->values.begin(), t->values.end()) : 0.0f;
}

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

}  // namespace sheaf
