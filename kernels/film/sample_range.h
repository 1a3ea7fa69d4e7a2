// Some of a pixel's samples.
#pragma once

#include <cstdint>

namespace sheaf {

/// Samples that follow each other, of the same plan for all pixels: [first, first + count).
struct SampleRange {
  std::uint32_t first = 0, count = 0;
  std::uint32_t end() const { return first + count; }
  bool operator==(const SampleRange&) const = default;
};

}  // namespace sheaf
