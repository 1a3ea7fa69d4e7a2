// Flattens the materials of a description into rows.
#pragma once

#include "scene/description.h"
#include "scene/description/error_sink.h"
#include "scene/materials/row_builder.h"
#include "scene/tables/material_tables.h"

namespace sheaf {

struct CompiledMaterials {
  MaterialTables tables;
  std::vector<MaterialSpectra> spectra;     ///< per row; empty in RGB mode
  std::vector<std::uint32_t> row_of;        ///< per material of the description
  std::vector<std::uint32_t> row_of_phase;  ///< per phase function of the description
  std::vector<std::string> warnings;        ///< about reflectances above 1 and black metals, once for each material
  std::uint32_t default_row = 0;            ///< for shapes without a material: diffuse, reflectance 0.5
};

/// Flattens two-sided materials, masks, blends, coats and maps into rows. Texture indices are unchanged. Phase
/// functions become rows, too. `set` makes the rows of spectra in spectral mode. Reports materials that are replaced by
/// diffuse ones to `errors` (null: throws): two-sided
/// materials or coats around a transmitting material, for two-sided materials, coats or maps nested in their own kind,
/// and for too deep nesting.
CompiledMaterials compile_materials(const std::vector<MaterialDescription>& materials, SpectrumSet* set = nullptr,
                                    const std::vector<PhaseDescription>& phases = {}, ErrorSink* errors = nullptr);

}  // namespace sheaf
