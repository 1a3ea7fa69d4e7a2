// Inside the Nori dialect: what its readers call of each other.
#pragma once

#include "scene/dialects/dialects.h"
#include "scene/dialects/read_spectrum.h"

namespace sheaf::nori {

/// Appends the material of a <bsdf>. `absorption`: set to what is inside of a boundary with `sigmaA`, per metre.
MaterialId read_bsdf(const XmlElement& element, ReadContext& context, std::optional<SpectrumDescription>& absorption);
/// Appends a medium; `in_shape`: a shape holds it, not the whole scene.
MediumId read_medium(const XmlElement& element, ReadContext& context, bool in_shape);
/// Appends a medium that only absorbs, as a material says.
MediumId add_absorption(const XmlElement& bsdf, SpectrumDescription sigma_a, ReadContext& context);
/// An integrator of the course's first exercises, which looks at shapes and not at their materials and lights: `ao`
/// (ambient occlusion), `av` (average visibility) and `simple` (one point light). Returns false for others. To be
/// called last: what the scene holds becomes white, lit by what the exercise says.
bool read_exercise(Properties& p);
/// Appends a light that is not on a mesh.
void read_emitter(const XmlElement& element, ReadContext& context);
/// A TextureReader.
SpectrumInput texture_of(const XmlElement& element, ReadContext& context);

}  // namespace sheaf::nori
