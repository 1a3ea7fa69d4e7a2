// Values of parameters as given by a file: spectra, numbers and textures, and which of them are valid; and the ids of
// named objects.
#pragma once

#include "core/math/vec.h"

#include <cstdint>
#include <limits>
#include <variant>
#include <vector>

namespace sheaf {

/// Index into Description::materials.
enum class MaterialId : std::uint32_t {};
/// Index into Description::textures.
enum class TextureId : std::uint32_t {};
/// Index into Description::media.
enum class MediumId : std::uint32_t {};
/// Index into Description::phases.
enum class PhaseId : std::uint32_t {};

/// A spectral quantity as given by a file. The owner determines its meaning (reflectance, radiance ...).
struct SpectrumDescription {
  /// The same value at every wavelength. Emission is relative to D65.
  struct Constant {
    float value = 0;
  };
  /// Linear Rec.709. Components may exceed 1 where the quantity may.
  struct Rgb {
    Vec3f value;
  };
  /// Piecewise linear over wavelength, zero outside. Wavelengths in nanometers, strictly increasing.
  struct Table {
    std::vector<float> wavelengths, values;
    /// RGB mode: convert with illuminant E instead of D65, as Mitsuba does for named metals.
    bool equal_energy = false;
  };
  /// Planck's law, absolute, W / (m^2 sr nm), times `scale`.
  struct Blackbody {
    float temperature = 6500;
    float scale = 1;
  };

  std::variant<Constant, Rgb, Table, Blackbody> value = Constant{};

  static SpectrumDescription constant(float v) { return {Constant{v}}; }
  static SpectrumDescription rgb(float r, float g, float b) { return {Rgb{{r, g, b}}}; }
};

/// A color parameter: a constant or a texture.
using SpectrumInput = std::variant<SpectrumDescription, TextureId>;
/// A scalar parameter: a constant or a texture (the luminance of a colored one).
using ScalarInput = std::variant<float, TextureId>;

/// The use of a spectrum; determines which values are valid.
enum class SpectrumRole {
  kReflectance,  ///< within [0, 1]
  kEmission,     ///< not negative
  kIor,          ///< not negative
};

/// Valid range of a number.
struct NumberRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool open = false;  ///< excludes the ends
};
inline constexpr NumberRange kAnyNumber{};
inline constexpr NumberRange kPositive{0, std::numeric_limits<double>::infinity(), true};
inline constexpr NumberRange kNotNegative{0, std::numeric_limits<double>::infinity(), false};
inline constexpr NumberRange kUnitInterval{0, 1, false};

}  // namespace sheaf
