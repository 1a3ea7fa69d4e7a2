#include "scene/xml/read_declared.h"

namespace sheaf {

void read_parameter(Properties& p, const char* name, SpectrumInput& value, SpectrumRole role, NumberRange) {
  value = p.spectrum_input(name, std::move(value), role);
}

void read_parameter(Properties& p, const char* name, SpectrumDescription& value, SpectrumRole role, NumberRange) {
  value = p.spectrum(name, std::move(value), role);
}

void read_parameter(Properties& p, const char* name, ScalarInput& value, SpectrumRole, NumberRange range) {
  value = p.scalar_input(name, value, range);
}

void read_parameter(Properties& p, const char* name, float& value, SpectrumRole, NumberRange range) {
  value = p.number(name, value, range);
}

void read_parameter(Properties& p, const char* name, bool& value, SpectrumRole, NumberRange) {
  value = p.boolean(name, value);
}

}  // namespace sheaf
