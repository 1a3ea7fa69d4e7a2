// Position of the sun by time and location (Blanco-Muriel et al. 2001).
#pragma once

#include <array>

namespace sheaf {

/// A location and its local time.
struct SunTime {
  int year = 2010, month = 7, day = 10;
  double hour = 15, minute = 0, second = 0;
  double latitude = 35.6894, longitude = 139.6917;  ///< degrees north and east; Tokyo
  double timezone = 9;                              ///< hours ahead of UTC
};

/// Returns the days since noon of 1 January 2000, UTC.
double days_since_2000(const SunTime& time);

/// Returns the unit vector to the sun: components to the east, to the north and upwards. Accurate to half a minute of
/// arc from 1999 to 2015, and close in other decades (Blanco-Muriel et al., "Computing the Solar Vector", Solar Energy
/// 70(5), 2001).
std::array<double, 3> sun_position(const SunTime& time);

}  // namespace sheaf
