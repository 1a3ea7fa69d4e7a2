// Flattens the materials of a description into rows.
#pragma once

#include "scene/compile/spectra.h"
#include "scene/description/description.h"
#include "scene/tables/material_tables.h"

namespace sheaf {

/// Spectra of a material's parameters, in order.
using MaterialSpectra = std::array<SpectrumRow, kMaxClosureSpectra>;

struct CompiledMaterials {
  MaterialTables tables;
  std::vector<MaterialSpectra> spectra;     ///< per row; empty in RGB mode
  std::vector<std::uint32_t> row_of;        ///< per material of the description
  std::vector<std::uint32_t> row_of_phase;  ///< per phase function of the description
  std::vector<std::string> warnings;        ///< about reflectances above 1 and black metals, once for each material
  std::uint32_t default_row = 0;            ///< for shapes without a material: diffuse, reflectance 0.5
};

/// Flattens two-sided materials, masks, blends, coats and maps into rows. Texture indices are unchanged. Phase
/// functions become rows, too. `set` makes the rows of spectra in spectral mode. Throws SceneError for two-sided
/// materials or coats around a transmitting material, for two-sided materials, coats or maps nested in their own kind,
/// and for too deep nesting.
CompiledMaterials compile_materials(const std::vector<MaterialDescription>& materials, SpectrumSet* set = nullptr,
                                    const std::vector<PhaseDescription>& phases = {});

/// Linear Rec.709 of an emission quantity; negative components become zero.
Vec3f emission_rgb(const SpectrumDescription& spectrum);
/// Linear Rec.709 of a reflectance or transmittance; clamped to [0, 1].
Vec3f reflectance_rgb(const SpectrumDescription& spectrum);
/// The warning about a reflectance whose maximum is above 1.
std::string clamped_reflectance(float largest);
/// Linear Rec.709 of an index of refraction or another unbounded quantity; negative components become zero.
Vec3f unbounded_rgb(const SpectrumDescription& spectrum);

}  // namespace sheaf
