// Internal declarations of the Nori dialect: functions that its files share.
#pragma once

#include "scene/dialects/xml/read_spectrum.h"

namespace sheaf::nori {

/// Appends the material of a <bsdf>. Sets `absorption` to the interior absorption coefficient (1/m) of a BSDF with
/// `sigmaA`.
MaterialId read_bsdf(const XmlElement& element, ReadContext& context, std::optional<SpectrumDescription>& absorption);
/// Appends a medium. `in_shape`: the medium fills a shape, not the whole scene.
MediumId read_medium(const XmlElement& element, ReadContext& context, bool in_shape);
/// Appends the purely absorbing medium of a material with `sigmaA`.
MediumId add_absorption(const XmlElement& bsdf, SpectrumDescription sigma_a, ReadContext& context);
/// Reads an integrator of the course's first exercises, which ignores materials and lights: `ao` (ambient occlusion),
/// `av` (average visibility) or `simple` (one point light). Returns false for others. Call it last, because it makes
/// all shapes white and replaces the lights.
bool read_exercise(Properties& p);
using ExerciseReader = void (*)(Properties& p, Description& description);
/// Exercises that only Nori has.
extern const NameTable<ExerciseReader> kExercises;
/// Appends a light that is not attached to a mesh.
void read_emitter(const XmlElement& element, ReadContext& context);
/// Implements TextureReader.
SpectrumInput texture_of(const XmlElement& element, ReadContext& context);

}  // namespace sheaf::nori
