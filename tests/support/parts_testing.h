// Compares images that are merged from parts with the image of a single render.
#pragma once

#include "core/image/image.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace sheaf {

/// Checks that two images are equal up to rounding.
inline void check_near(const Image& found, const Image& expected) {
  REQUIRE(found.channels == expected.channels);
  REQUIRE(found.data.size() == expected.data.size());
  for (std::size_t c = 0; c < found.channels.size(); ++c) {
    const std::string& name = found.channels[c];
    double largest = 0, worst = 0;
    bool same = true;
    for (std::size_t i = c; i < expected.data.size(); i += found.channels.size())
      largest = std::max(largest, std::fabs(static_cast<double>(expected.data[i])));
    for (std::size_t i = c; i < expected.data.size(); i += found.channels.size()) {
      const double a = found.data[i], b = expected.data[i];
      same = same && std::memcmp(&found.data[i], &expected.data[i], sizeof(float)) == 0;
      worst = std::max(worst, std::fabs(a - b) / (std::fabs(b) + 0.01 * largest + 1e-30));
    }
    CAPTURE(name);
    const bool exact = name == "sampleCount" || name.ends_with("Id") ||
                       (name.starts_with("Crypto") && (name.ends_with("r") || name.ends_with("b")));
    CHECK((exact ? same : worst < 2e-6));
  }
}

}  // namespace sheaf
