#include "scene/description/scaled_spectrum.h"

namespace sheaf {

SpectrumDescription scaled(SpectrumDescription spectrum, float by) {
  using S = SpectrumDescription;
  if (auto* constant = std::get_if<S::Constant>(&spectrum.value)) constant->value *= by;
  if (auto* rgb = std::get_if<S::Rgb>(&spectrum.value)) rgb->value = rgb->value * by;
  if (auto* body = std::get_if<S::Blackbody>(&spectrum.value)) body->scale *= by;
  if (auto* table = std::get_if<S::Table>(&spectrum.value))
    for (float& value : table->values) value *= by;
  return spectrum;
}

}  // namespace sheaf
