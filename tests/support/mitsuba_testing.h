// Materials in small scenes of Mitsuba.
#pragma once

#include "tests/support/files/scene_files.h"
#include "tests/support/xml_elements.h"

#include <string>
#include <variant>

namespace sheaf::test {

/// Reads a scene of version 0.6 with the given elements.
inline Description read_mitsuba06(const std::string& elements) {
  return read_text(mitsuba_scene(elements, "<sensor type='perspective'/>", "<integrator type='path'/>", "0.6.0"));
}

/// The outermost material of a BSDF, as text.
inline std::string material(const std::string& type, const std::string& inside = "") {
  return dump(read_text(mitsuba_scene(bsdf(type, inside))).materials.back());
}

/// The number of a constant spectrum or scalar. Throws std::bad_variant_access for others.
inline float constant_of(const SpectrumDescription& spectrum) {
  return std::get<SpectrumDescription::Constant>(spectrum.value).value;
}
inline float constant_of(const SpectrumInput& input) { return constant_of(std::get<SpectrumDescription>(input)); }
inline float constant_of(const ScalarInput& input) { return std::get<float>(input); }

/// The values of a color. Throws std::bad_variant_access for other spectra.
inline Vec3f rgb_of(const SpectrumInput& input) {
  return std::get<SpectrumDescription::Rgb>(std::get<SpectrumDescription>(input).value).value;
}

/// The outermost material of a BSDF, which is of type T.
template <class T> T read_material(const std::string& type, const std::string& inside = "") {
  return std::get<T>(read_text(mitsuba_scene(bsdf(type, inside))).materials.back().model);
}

/// The error message of a scene with the given elements, which begin in line 4.
inline std::string error_of_elements(const std::string& elements) { return error_of_text(mitsuba_scene(elements)); }

}  // namespace sheaf::test
