// Masks and polarizing filters: reading, and their rows.
#include "scene/materials/mask.h"

#include "scene/materials/flattener.h"
#include "scene/materials/reading.h"

namespace sheaf {

namespace {

/// Reads a filter that transmits the fraction `passing` of unpolarized light without deflection and absorbs the rest.
/// `transmittance` (default 1), a number, scales it.
MaskDescription read_filter(Properties& p, float passing) {
  p.ignore({"theta", "polarizing", "left_handed", "delta"});
  const ScalarInput transmittance = p.scalar_input("transmittance", 1.0f, kUnitInterval);
  const float* number = std::get_if<float>(&transmittance);
  if (number == nullptr) p.report_at("transmittance", "is a texture, expected a number", SceneErrorCode::kWrongType);
  const MaskDescription filter{1 - passing * (number != nullptr ? *number : 1.0f), add_black_material(p)};
  note_polarization(p);
  return filter;
}

}  // namespace

MaskDescription MaskDescription::read(Properties& p, const BsdfDialect& dialect) {
  const ScalarInput opacity = p.scalar_input("opacity", 0.5f, kUnitInterval);
  return {opacity, read_nested_bsdf(p, dialect)};
}

MaskDescription MaskDescription::read_polarizer(Properties& p, const BsdfDialect&) { return read_filter(p, 0.5f); }

MaskDescription MaskDescription::read_retarder(Properties& p, const BsdfDialect&) { return read_filter(p, 1.0f); }

std::uint32_t MaskDescription::flatten(MaterialFlattener& flattener, const MaterialWrappers& around,
                                       const SourceLocation&) const {
  return flattener.push_choice(MaterialRow::kNothing, flattener.flatten(nested, around), opacity);
}

}  // namespace sheaf
