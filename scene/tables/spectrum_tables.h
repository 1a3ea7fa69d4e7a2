// The spectra of a scene in spectral mode.
#pragma once

#include "core/color/spectral_sensor.h"
#include "core/color/spectrum_row.h"
#include "core/color/uplift.h"
#include "scene/tables/table_bytes.h"

#include <vector>

namespace sheaf {

/// Spectra that replace the colors of other tables in spectral mode.
struct SpectralView {
  SpectrumTableView tables;
  /// Spectra of each material's closure parameters, in order: kMaxClosureSpectra rows per material.
  const SpectrumRow* materials = nullptr;
  /// Spectrum of each light, instead of LightRecord::radiance. Colors of textures and maps are upsampled and
  /// multiplied by it.
  const SpectrumRow* lights = nullptr;
  const SpectrumRow* media = nullptr;   ///< see MediumRow
  const UpliftTable* uplift = nullptr;  ///< null: the scene has no textures
  const SensorCurves* sensor = nullptr;
};

/// Owns the spectra; empty in RGB mode.
struct SpectrumTables {
  std::vector<float> samples;  ///< SpectrumTableView::samples
  std::vector<SpectrumRow> materials, lights, media;

  SpectralView view(bool has_textures) const {
    return {{samples.data()},
            materials.data(),
            lights.data(),
            media.data(),
            has_textures ? &UpliftTable::get() : nullptr,
            &SensorCurves::get()};
  }
  /// Memory in bytes.
  std::size_t bytes() const { return bytes_of(samples, materials, lights, media); }
};

}  // namespace sheaf
