// Colors of described spectra.
#pragma once

#include "scene/description/inputs.h"

#include <string>

namespace sheaf {

/// Linear Rec.709 of an emission quantity; negative components become zero.
Vec3f emission_rgb(const SpectrumDescription& spectrum);
/// Linear Rec.709 of a reflectance or transmittance; clamped to [0, 1].
Vec3f reflectance_rgb(const SpectrumDescription& spectrum);
/// Linear Rec.709 of an index of refraction or another unbounded quantity; negative components become zero.
Vec3f unbounded_rgb(const SpectrumDescription& spectrum);

/// The maximum value given by the file; 0 for black bodies, which are not reflectances.
float largest_value(const SpectrumDescription& spectrum);
/// The warning about a reflectance whose maximum is above 1.
std::string clamped_reflectance(float largest);

}  // namespace sheaf
