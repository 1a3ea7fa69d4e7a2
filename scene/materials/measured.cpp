// Measured BRDFs: reading, and the row, which refers to a table.
#include "scene/materials/measured.h"

#include "scene/data/rgb_basis.h"
#include "scene/materials/reading.h"
#include "scene/materials/row_builder.h"

namespace sheaf {

MeasuredDescription MeasuredDescription::read(Properties& p, const BsdfDialect&) { return {p.file("filename")}; }

MaterialRow MeasuredDescription::make_row(RowContext& context) const {
  const ClosureTables::Measured& measured = context.tables.measured(file, context.set != nullptr);
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
