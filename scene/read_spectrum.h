// Spectra and colours as elements of a scene file: <rgb>, <srgb>, <spectrum>, <blackbody>, <float> and their plugins.
#pragma once

#include "scene/properties.h"

namespace sheaf {

/// What an element says: a colour, a number, a <spectrum> with its value, file or plugin, a <texture> with one of
/// spectrum_plugins(). Throws SceneError; see also check_role.
SpectrumDescription read_spectrum(const XmlElement& element, ReadContext& context);

/// The plugins that stand for a spectrum: the same everywhere.
const std::vector<std::string>& spectrum_plugins();

/// Turns a constant spectrum of an emitter, read from `element`, into the same power at every wavelength, which is not
/// white, as Mitsuba takes it; constants written as rgb or float, and `d65`, stay relative to D65.
void make_equal_energy(const XmlElement& element, SpectrumDescription& spectrum);

}  // namespace sheaf
