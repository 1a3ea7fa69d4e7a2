// Measured BRDFs: reading, and the row, which refers to a table.
#include "scene/materials/measured.h"

#include "scene/data/rgb_basis.h"
#include "scene/materials/reading.h"
#include "scene/materials/row_builder.h"

namespace sheaf {

MeasuredDescription MeasuredDescription::read(Properties& p, const BsdfDialect&) { return {p.file("filename")}; }

MeasuredDescription MeasuredDescription::read_polarized(Properties& p, const BsdfDialect&) {
  MeasuredDescription result{p.file("filename"), true};
  result.alpha_sample = p.number("alpha_sample", result.alpha_sample, kPositive);
  result.wavelength = p.number("wavelength", result.wavelength);
  note_polarization(p);
  return result;
}

MaterialRow MeasuredDescription::make_row(RowContext& context) const {
  const bool is_spectral = context.set != nullptr;
  const ClosureTables::Measured& measured = is_polarized
                                                ? context.tables.polarized(file, alpha_sample, wavelength, is_spectral)
                                                : context.tables.measured(file, is_spectral);
  const auto with_flags = [&](MaterialRow row) {
    if (!measured.isotropic) row.flags |= kNeedsUv;
    return row;
  };
  if (!measured.wavelengths.empty()) {
    MaterialRowBuilder<MeasuredSpectralParameters> m{context};
    m.p.table = measured.table;
    m.row_of(m.p.position) = context.set->tabulate(wavelength_positions(measured.wavelengths));
    return with_flags(m.row<MeasuredSpectralClosure>());
  }
  MaterialRowBuilder<MeasuredParameters> m{context};
  m.p.table = measured.table;
  m.p.red = {1, 0, 0, 0}, m.p.green = {0, 1, 0, 0}, m.p.blue = {0, 0, 1, 0};
  if (context.set != nullptr) {
    Spectrum4* const colors[] = {&m.p.red, &m.p.green, &m.p.blue};
    for (int c = 0; c < 3; ++c) m.row_of(*colors[c]) = context.set->tabulate(rgb_basis(c));
  }
  return with_flags(m.row<MeasuredClosure>());
}

}  // namespace sheaf
