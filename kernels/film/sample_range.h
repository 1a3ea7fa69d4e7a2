// A range of a pixel's samples.
#pragma once

#include <cstdint>

namespace sheaf {

/// Consecutive samples [first, first + count) of the same sampling plan for all pixels.
struct SampleRange {
  std::uint32_t first = 0, count = 0;
  std::uint32_t end() const { return first + count; }
  bool operator==(const SampleRange&) const = default;
};

}  // namespace sheaf
