// Inside the Nori dialect: what its readers call of each other.
#pragma once

#include "scene/dialects.h"

namespace sheaf::nori {

/// Appends the material of a <bsdf>.
MaterialId read_bsdf(const XmlElement& element, ReadContext& context);
/// The radiance of an area light.
SpectrumInput read_area_emitter(const XmlElement& element, ReadContext& context);
/// Appends a light that is not on a mesh.
void read_emitter(const XmlElement& element, ReadContext& context);
/// A TextureReader.
SpectrumInput texture_of(const XmlElement& element, ReadContext& context);

}  // namespace sheaf::nori
