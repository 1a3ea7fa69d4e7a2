// Materials that polarise light, as what they do to light that is not polarised.
#include "scene/dialects/dialects.h"
#include "scene/dialects/read_bsdf.h"

namespace sheaf {

namespace {

/// A surface that lets `passing` of the light go straight on and absorbs the rest.
MaskDescription straight_through(Properties& p, float passing) {
  MaterialDescription black;
  black.model = DiffuseDescription{SpectrumDescription::constant(0)};
  black.where = p.where();
  return {1 - passing, add_material(p.context(), std::move(black))};
}

/// `transmittance` (1), a number.
float read_transmittance(Properties& p) {
  const ScalarInput transmittance = p.scalar_input("transmittance", 1.0f, kUnitInterval);
  if (const float* number = std::get_if<float>(&transmittance)) return *number;
  p.fail_at("transmittance", "is a texture, expected a number");
}

}  // namespace

MaskDescription read_polarizer(Properties& p) {
  // Half of what is not polarised has the direction that passes.
  const float passing = p.type() == "retarder" ? 1.0f : 0.5f;
  p.ignore({"theta", "polarizing", "left_handed", "delta"});
  return straight_through(p, passing * read_transmittance(p));
}

void note_polarisation(Properties& p) {
  p.context().note(p.where(), "bsdf '" + p.type() + "' does to all light what it does to light that is not polarised");
}

}  // namespace sheaf
