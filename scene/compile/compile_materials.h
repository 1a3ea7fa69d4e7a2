// Materials of a description, flattened into rows.
#pragma once

#include "scene/compile/spectra.h"
#include "scene/description/description.h"
#include "scene/tables/material.h"
#include "scene/tables/texture.h"

namespace sheaf {

/// The rows of the spectra among a material's parameters, in their order.
using MaterialSpectra = std::array<SpectrumRow, kMaxClosureSpectra>;

struct CompiledMaterials {
  std::vector<MaterialRow> rows;         ///< sorted by kind, composite ones last
  std::vector<MaterialSpectra> spectra;  ///< of each row; empty in RGB mode
  std::vector<TextureBinding> bindings;
  std::vector<NormalMapRow> normal_maps;
  std::vector<float> tables;                ///< SceneView::closure_tables
  std::vector<std::uint32_t> row_of;        ///< per material of the description
  std::vector<std::uint32_t> row_of_phase;  ///< per phase function of the description
  std::vector<std::string> warnings;        ///< of reflectances above 1 and black metals, once for each
  std::uint32_t default_row = 0;            ///< what shapes without a material get: diffuse, reflectance 0.5
  std::uint32_t bucket_count = 1;
  std::uint32_t bucket_begin[kClosureKinds + 1] = {};  ///< buckets of each kind are contiguous
  std::uint32_t kind_flags[kClosureKinds] = {};        ///< MaterialFlags of all rows of a kind
};

/// Flattens two-sided materials, masks, blends and maps into rows. Textures keep their numbers. Throws SceneError where
/// a two-sided material holds one that transmits or another two-sided one, where a map holds a map, and where
/// materials are nested too deep. `set`: what makes rows of spectra, in spectral mode. Phase functions become rows
/// among the others.
CompiledMaterials compile_materials(const std::vector<MaterialDescription>& materials, SpectrumSet* set = nullptr,
                                    const std::vector<PhaseDescription>& phases = {});

/// Linear Rec.709 of a radiance, intensity ...; components below zero become zero.
Vec3f emission_rgb(const SpectrumDescription& spectrum);
/// Linear Rec.709 of a reflectance or transmittance; clamped to [0, 1].
Vec3f reflectance_rgb(const SpectrumDescription& spectrum);
/// What is said of a reflectance whose largest value is above 1.
std::string clamped_reflectance(float largest);
/// Linear Rec.709 of an index of refraction and other quantities without an upper bound.
Vec3f unbounded_rgb(const SpectrumDescription& spectrum);

}  // namespace sheaf
