// Comparison of floating-point numbers in tests, by relative error. The comparison of doctest adds an absolute
// tolerance, so that it compares nothing below 1; tests/tools/test_forbidden_names.cpp rejects its name.
#pragma once

#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>

namespace sheaf {

/// A number that equals all numbers within a distance of it. NaN equals nothing.
struct Near {
  double expected;
  double distance;  ///< largest absolute difference

  friend bool operator==(double value, const Near& near) {
    return value == near.expected || std::fabs(value - near.expected) <= near.distance;
  }
  friend doctest::String toString(const Near& near) {
    char text[64];
    std::snprintf(text, sizeof text, "%.9g +- %.3g", near.expected, near.distance);
    return text;
  }
};

/// Equals numbers with an absolute error of at most `distance`. For numbers whose expected value may be zero;
/// `distance` must be small compared with the terms that cancel.
inline Near within(double expected, double distance) { return {expected, distance}; }
/// Equals numbers with a relative error of at most `tolerance`, by default 100 times the rounding error of a float.
/// Zero equals only zero, and infinity only infinity: use within() for rounding errors around zero.
inline Near near(double expected, double tolerance = 1.2e-5) {
  return within(expected, std::isfinite(expected) ? tolerance * std::fabs(expected) : 0.0);
}

}  // namespace sheaf
