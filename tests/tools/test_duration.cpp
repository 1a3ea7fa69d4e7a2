// Durations: units, rounding at the borders between units, and values that are no durations.
#include "tools/console/duration.h"

#include <doctest/doctest.h>

#include <limits>
#include <string>

namespace sheaf::test_duration {

TEST_CASE("durations have the smallest unit that shows two or three digits") {
  for (const auto& [seconds, text] :
       {std::pair{0.0, "0 s"},  {0.0004, "0 s"},       {0.031, "31 ms"},         {0.0994, "99 ms"},
        {0.0996, "0.10 s"},     {0.42, "0.42 s"},      {0.994, "0.99 s"},        {0.9951, "1.0 s"},
        {9.94, "9.9 s"},        {9.96, "10 s"},        {42.4, "42 s"},           {59.4, "59 s"},
        {59.6, "1 min 00 s"},   {80.0, "1 min 20 s"},  {3599.4, "59 min 59 s"},  {3599.6, "1 h 00 min"},
        {7500.0, "2 h 05 min"}, {86399.0, "1 d 00 h"}, {86000.0, "23 h 53 min"}, {273600.0, "3 d 04 h"}}) {
    const std::string expected = text;
    CAPTURE(expected);
    CHECK(format_duration(seconds) == expected);
  }
}

TEST_CASE("values that are no durations are shown as a question mark") {
  for (const double seconds :
       {-1.0, 1e300, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()})
    CHECK(format_duration(seconds) == "?");
}

}  // namespace sheaf::test_duration
