// Position of the sun (Blanco-Muriel et al., "Computing the Solar Vector", Solar Energy 70(5), 2001).
#include "scene/dialects/common/sun_position.h"

#include <cmath>
#include <numbers>

namespace sheaf {

namespace {

constexpr double kDegrees = std::numbers::pi / 180;

/// Julian day number; Julian days start at noon (Fliegel and Van Flandern 1968).
int julian_day(int year, int month, int day) {
  const int from_march = (month - 14) / 12;
  return 1461 * (year + 4800 + from_march) / 4 + 367 * (month - 2 - 12 * from_march) / 12 -
         3 * ((year + 4900 + from_march) / 100) / 4 + day - 32075;
}

double universal_hours(const SunTime& time) {
  return time.hour - time.timezone + (time.minute + time.second / 60) / 60;
}

}  // namespace

double days_since_2000(const SunTime& time) {
  return julian_day(time.year, time.month, time.day) - 2451545 - 0.5 + universal_hours(time) / 24;
}

std::array<double, 3> sun_position(const SunTime& time) {
  const double n = days_since_2000(time);
  // Ecliptic coordinates.
  const double omega = 2.1429 - 0.0010394594 * n;
  const double anomaly = 6.2400600 + 0.0172019699 * n;
  const double longitude = 4.8950630 + 0.017202791698 * n + 0.03341607 * std::sin(anomaly) +
                           0.00034894 * std::sin(2 * anomaly) - 0.0001134 - 0.0000203 * std::sin(omega);
  const double obliquity = 0.4090928 - 6.2140e-9 * n + 0.0000396 * std::cos(omega);
  // Unit vector to the sun in equatorial coordinates.
  const double x = std::cos(longitude), y = std::cos(obliquity) * std::sin(longitude);
  const double z = std::sin(obliquity) * std::sin(longitude);
  // Rotate by the sidereal time: components to the meridian, to the west, and to the pole.
  const double sidereal_hours = 6.6974243242 + 0.0657098283 * n + universal_hours(time);
  const double azimuth = (15 * sidereal_hours + time.longitude) * kDegrees;
  const double meridian = std::cos(azimuth) * x + std::sin(azimuth) * y,
               west = std::sin(azimuth) * x - std::cos(azimuth) * y;
  const double latitude = time.latitude * kDegrees;
  const double north = std::cos(latitude) * z - std::sin(latitude) * meridian;
  const double up = std::sin(latitude) * z + std::cos(latitude) * meridian;
  // Correct for parallax: seen from the surface instead of the center of the earth, the sun is lower.
  constexpr double kParallax = 6371.01 / 149597890;
  const double zenith = std::atan2(std::hypot(west, north), up);
  const double seen = zenith + kParallax * std::sin(zenith);
  const double across = std::hypot(west, north) > 0 ? std::sin(seen) / std::hypot(west, north) : 0;
  return {-west * across, north * across, std::cos(seen)};
}

}  // namespace sheaf
