// The smallest unit is chosen so that the text has two or three significant digits.
#include "tools/console/duration.h"

#include <fmt/format.h>

#include <cmath>

namespace sheaf {

std::string format_duration(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0 || seconds > 1e9) return "?";
  if (seconds < 0.0005) return "0 s";
  if (seconds < 0.0995) return fmt::format("{:.0f} ms", seconds * 1e3);
  if (seconds < 0.995) return fmt::format("{:.2f} s", seconds);
  if (seconds < 9.95) return fmt::format("{:.1f} s", seconds);
  const long long whole = std::llround(seconds), minutes = std::llround(seconds / 60), hours = minutes / 60;
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  if (hours < 24) return fmt::format("{} h {:02} min", hours, minutes % 60);
  const long long all_hours = std::llround(seconds / 3600);
  return fmt::format("{} d {:02} h", all_hours / 24, all_hours % 24);
}

}  // namespace sheaf
