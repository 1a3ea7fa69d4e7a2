// A measured BRDF.
#pragma once

#include "scene/materials/model.h"

#include <filesystem>

namespace sheaf {

/// Parameters of a measured BRDF with three color channels (kernels/bsdf/measured.h).
template <class L> struct MeasuredParameters {
  typename L::Float table;       ///< see scene/tables/closure_tables.h
  Spectrum<L> red, green, blue;  ///< spectra of the table's three channels
  static constexpr auto fields(auto& s) { return std::tie(s.table, s.red, s.green, s.blue); }
};

/// Parameters of a measured BRDF with values at many wavelengths. Spectral mode only.
template <class L> struct MeasuredSpectralParameters {
  typename L::Float table;
  Spectrum<L> position;  ///< index of each wavelength in the table, with a fraction for interpolation
  static constexpr auto fields(auto& s) { return std::tie(s.table, s.position); }
};

struct MeasuredClosure : ClosureOf<MeasuredParameters> {
  static constexpr ClosureInfo kInfo = {.name = "measured"};
};
struct MeasuredSpectralClosure : ClosureOf<MeasuredSpectralParameters> {
  static constexpr ClosureInfo kInfo = {.name = "measured_spectral"};
};

/// A measured BRDF in the file format of Dupuy and Jakob 2018, or the unpolarized part of one of Baek et al. 2020.
struct MeasuredDescription {
  std::filesystem::path file;  ///< resolved path
  bool is_polarized = false;   ///< the file is one of Baek et al. 2020
  float alpha_sample = 0.1f;   ///< polarized: roughness of the microfacets that samples follow
  float wavelength = -1;       ///< polarized: nm, the only wavelength that counts; negative: all

  using Closures = ClosureList<MeasuredClosure, MeasuredSpectralClosure>;
  static MeasuredDescription read(Properties& p, const BsdfDialect& dialect);
  static MeasuredDescription read_polarized(Properties& p, const BsdfDialect& dialect);
  static constexpr Plugin<MeasuredDescription> kPlugins[] = {{"measured", read},
                                                             {"measured_polarized", read_polarized}};
  static constexpr auto fields(auto& s) { return std::tie(s.file, s.is_polarized, s.alpha_sample, s.wavelength); }
  bool transmits() const { return false; }
  MaterialRow make_row(RowContext& context) const;
};

}  // namespace sheaf
