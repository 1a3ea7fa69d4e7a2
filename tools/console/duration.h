// Durations as text for users.
#pragma once

#include <string>

namespace sheaf {

/// Formats seconds with one or two units: "31 ms", "0.42 s", "9.9 s", "42 s", "1 min 05 s", "2 h 05 min", "3 d 04 h".
/// Negative and non-finite values, and those over 1e9, give "?".
std::string format_duration(double seconds);

}  // namespace sheaf
