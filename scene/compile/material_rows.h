// Compiles a single material that is not a combination into a row.
#pragma once

#include "scene/compile/closure_tables.h"
#include "scene/compile/compile_materials.h"
#include "scene/compile/plastic.h"

namespace sheaf {

/// Destinations and shared state for making rows.
struct RowContext {
  std::vector<TextureBinding>& bindings;  ///< appended to
  ClosureTables& tables;                  ///< appended to
  SpectrumSet* set = nullptr;             ///< spectral mode: makes rows of spectra
  MaterialSpectra rows = {};              ///< spectral mode: spectra of the most recent row
  float largest_reflectance = 0;          ///< maximum of all constants so far, before clamping
  RoughCoats coats = {};
};

/// Makes the row of a material that is not composite, two-sided or mapped. The caller sets `back`, `bucket` and the
/// choices. Throws SceneError for spectra that are not finite.
MaterialRow make_material_row(const MaterialDescription& material, RowContext& context);

/// Makes the row of such a material under a coat. Also throws SceneError for materials that cannot be coated.
MaterialRow make_coated_row(const CoatDescription& coat, const MaterialDescription& nested, RowContext& context);

}  // namespace sheaf
