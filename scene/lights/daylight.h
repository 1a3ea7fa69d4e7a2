// Daylight: the sky of Hosek and Wilkie 2012 and the sun of Hosek and Wilkie 2013, with their published coefficients.
#pragma once

#include "scene/lights/envmap_light.h"
#include "scene/lights/make_envmap.h"

#include <array>

namespace sheaf {

/// The sky for one position of the sun, in linear Rec.709, W / (m^2 sr nm), in the units of RGB mode.
class SkyModel {
 public:
  /// `elevation` of the sun in [0, pi / 2], radians; `turbidity` in [1, 10]; `albedo` in [0, 1].
  SkyModel(float turbidity, Vec3f albedo, double elevation);

  /// Radiance from a direction, given by its cosine to the zenith in [0, 1] and its angle to the sun in radians.
  /// Components may be negative.
  std::array<double, 3> radiance(double cos_zenith, double to_sun) const;

 private:
  std::array<std::array<double, 9>, 3> shape_{};  ///< A to I of equation 8, by channel
  std::array<double, 3> radiance_{};
};

/// Radiance of the sun, averaged over its disk, W / (m^2 sr nm), for its elevation in [0, pi / 2], radians.
SpectrumDescription::Table sun_spectrum(float turbidity, double elevation);

/// Color of the sun in RGB mode: the sum over the table's wavelengths, as in Mitsuba 3. About 6% brighter than the
/// integral of emission_rgb().
Vec3f sun_rgb(const SpectrumDescription::Table& spectrum);

/// Multiplies the angle of a unit vector to the zenith `up` by `factor`.
Vec3f stretched(Vec3f direction, Vec3f up, float factor);

/// The sky as an environment map image with +y axis `up` and +z axis `front`, which must be perpendicular.
EnvmapImage sky_image(const SkyDescription& sky, Vec3f front);

}  // namespace sheaf
