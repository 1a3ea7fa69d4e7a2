// Spectra and colours as elements of a scene file: <rgb>, <srgb>, <spectrum>, <blackbody>, <float> and their plugins.
#pragma once

#include "scene/xml/properties.h"

namespace sheaf {

/// What an element says: a colour, a number, a <spectrum> with its value, file or plugin, a <texture> with one of
/// spectrum_plugins(). Throws SceneError; see also check_role.
SpectrumDescription read_spectrum(const XmlElement& element, ReadContext& context);

/// The same spectrum times `by`.
SpectrumDescription scaled(SpectrumDescription spectrum, float by);

/// The plugins that stand for a spectrum: the same everywhere.
const std::vector<std::string>& spectrum_plugins();

/// read_spectrum() for a property of that role. A constant <spectrum> of an emitter is the same power at every
/// wavelength, which is not white, as Mitsuba takes it; constants written as rgb or float, and `d65`, stay relative to
/// D65.
SpectrumDescription read_property_spectrum(const XmlElement& element, SpectrumRole role, ReadContext& context);

}  // namespace sheaf
