// Daylight: the sky of Hosek and Wilkie 2012 and the sun of Hosek and Wilkie 2013, from their coefficients.
#pragma once

#include "scene/compile/compile_envmap.h"
#include "scene/description/description.h"

#include <array>

namespace sheaf {

/// The sky for one place of the sun, in linear Rec.709, W / (m^2 sr nm) as RGB mode has it.
class SkyModel {
 public:
  /// `elevation` of the sun in [0, pi / 2], radians; `turbidity` in [1, 10]; `albedo` in [0, 1].
  SkyModel(float turbidity, Vec3f albedo, double elevation);

  /// The radiance from a direction, by its cosine to the zenith, in [0, 1], and its angle to the sun, radians.
  /// Components may be negative.
  std::array<double, 3> radiance(double cos_zenith, double to_sun) const;

 private:
  std::array<std::array<double, 9>, 3> shape_{};  ///< A to I of equation 8, by channel
  std::array<double, 3> radiance_{};
};

/// The sun's radiance, averaged over its disk, W / (m^2 sr nm), by its elevation in [0, pi / 2], radians.
SpectrumDescription::Table sun_spectrum(float turbidity, double elevation);

/// Its colour in RGB mode: the sum over the wavelengths of the table, as Mitsuba 3 has it. About 6 % brighter than the
/// integral that emission_rgb() takes.
Vec3f sun_rgb(const SpectrumDescription::Table& spectrum);

/// A unit vector with `factor` times its angle to the zenith `up`.
Vec3f stretched(Vec3f direction, Vec3f up, float factor);

/// The sky as the picture of an environment map whose +y axis is `up` and whose +z axis is `front`, at right angles.
EnvmapPicture sky_picture(const SkyDescription& sky, Vec3f front);

}  // namespace sheaf
