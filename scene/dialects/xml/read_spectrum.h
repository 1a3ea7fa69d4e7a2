// Spectra and colors in XML scene files: <rgb>, <srgb>, <spectrum>, <blackbody>, <float> and their plugins.
#pragma once

#include "scene/description/scaled_spectrum.h"
#include "scene/xml/properties.h"

namespace sheaf {

/// Reads a spectrum from an element: a color, a number, a <spectrum> with a value, file or plugin, or a <texture> with
/// one of kSpectrumPlugins. Throws SceneError; see also check_role.
SpectrumDescription read_spectrum(const XmlElement& element, ReadContext& context);

/// Reads a plugin that defines a spectrum, constant over surfaces. The caller finishes `p`. Throws SceneError.
using SpectrumPluginReader = SpectrumDescription (*)(Properties& p);
extern const NameTable<SpectrumPluginReader> kSpectrumPlugins;

/// read_spectrum() for a property with this role. A constant <spectrum> of an emitter has equal power at every
/// wavelength, which is not white; this follows Mitsuba. Constants written as rgb or float, and `d65`, stay relative to
/// D65.
SpectrumDescription read_property_spectrum(const XmlElement& element, SpectrumRole role, ReadContext& context);

}  // namespace sheaf
