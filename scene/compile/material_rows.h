// One material that is no combination of others, as a row.
#pragma once

#include "scene/compile/closure_tables.h"
#include "scene/compile/compile_materials.h"
#include "scene/compile/plastic.h"

namespace sheaf {

/// Where a row's other parts go.
struct RowContext {
  std::vector<TextureBinding>& bindings;  ///< appended to
  ClosureTables& tables;                  ///< likewise
  SpectrumSet* set = nullptr;             ///< spectral mode: what makes rows
  MaterialSpectra rows = {};              ///< spectral mode: those of the row made last
  float largest_reflectance = 0;          ///< of all constants set so far, before they are clamped
  RoughCoats coats = {};
};

/// The row of a material that is neither composite nor two-sided nor mapped. `back`, `bucket` and the choices are left
/// to the caller. Throws SceneError for spectra that are not finite.
MaterialRow make_material_row(const MaterialDescription& material, RowContext& context);

/// The row of such a material under a coat. Throws SceneError also for materials that cannot be coated.
MaterialRow make_coated_row(const CoatDescription& coat, const MaterialDescription& nested, RowContext& context);

}  // namespace sheaf
