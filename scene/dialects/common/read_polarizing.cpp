// Polarizing materials, reduced to their effect on unpolarised light.
#include "scene/dialects/common/read_bsdf.h"

#include "scene/dialects/common/add_material.h"

namespace sheaf {

namespace {

/// A surface that transmits the fraction `passing` of the light without deflection and absorbs the rest.
MaskDescription straight_through(Properties& p, float passing) {
  MaterialDescription black;
  black.model = DiffuseDescription{SpectrumDescription::constant(0)};
  black.where = p.where();
  return {1 - passing, add_material(p.context(), std::move(black))};
}

/// Reads `transmittance` (default 1), a number.
float read_transmittance(Properties& p) {
  const ScalarInput transmittance = p.scalar_input("transmittance", 1.0f, kUnitInterval);
  if (const float* number = std::get_if<float>(&transmittance)) return *number;
  p.fail_at("transmittance", "is a texture, expected a number");
}

}  // namespace

MaskDescription read_polarizer(Properties& p) {
  // A polarizer passes half of unpolarised light.
  const float passing = p.type() == "retarder" ? 1.0f : 0.5f;
  p.ignore({"theta", "polarizing", "left_handed", "delta"});
  return straight_through(p, passing * read_transmittance(p));
}

void note_polarisation(Properties& p) {
  p.context().note(p.where(), "bsdf '" + p.type() + "' rendered without polarization, which is not simulated");
}

}  // namespace sheaf
