// Where the sun stands.
#pragma once

#include <array>

namespace sheaf {

/// A place and a time of the clock there.
struct SunTime {
  int year = 2010, month = 7, day = 10;
  double hour = 15, minute = 0, second = 0;
  double latitude = 35.6894, longitude = 139.6917;  ///< degrees, to the north and to the east; Tokyo
  double timezone = 9;                              ///< hours ahead of universal time
};

/// Days from noon of 1 January 2000, universal time.
double days_since_2000(const SunTime& time);

/// The unit vector to the sun: to the east, to the north and upwards. Within half a minute of arc from 1999 to 2015,
/// and not far off in other decades (Blanco-Muriel et al., "Computing the Solar Vector", Solar Energy 70(5), 2001).
std::array<double, 3> sun_position(const SunTime& time);

}  // namespace sheaf
