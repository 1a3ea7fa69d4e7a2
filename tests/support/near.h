// Comparison of floating-point numbers in tests, by relative error. doctest::Approx adds an absolute tolerance, so that it
// compares nothing below 1; a test of the build rejects its name.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace sheaf {

/// A number that equals all numbers within a distance of it. NaN equals nothing.
struct Near {
  double expected;
  double distance;  ///< largest absolute difference

  friend bool operator==(double value, const Near& near) {
    return value == near.expected || std::fabs(value - near.expected) <= near.distance;
  }
  friend bool operator==(const Near& near, double value) { return value == near; }
  friend doctest::String toString(const Near& near) {
    return doctest::toString(near.expected) + " +- " + doctest::toString(near.distance);
  }
};

/// Equals numbers with a relative error of at most `tolerance`. Zero equals only zero: use within() for rounding errors
/// around zero.
inline Near near(double expected, double tolerance = 1e-5) { return {expected, tolerance * std::fabs(expected)}; }
/// Equals numbers with an absolute error of at most `distance`. For numbers whose expected value may be zero; `distance`
/// must be small compared with the terms that cancel.
inline Near within(double expected, double distance) { return {expected, distance}; }

}  // namespace sheaf
