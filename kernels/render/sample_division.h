// Division of a pixel's samples into sets and passes.
#pragma once

#include "kernels/film/sample_range.h"

namespace sheaf {

/// Samples are added pass by pass, and a pass ends where a set or the first half ends. Renders of the same scene have
/// the same bits only if their samples are divided equally.
struct SampleDivision {
  std::uint32_t spp = 0;                ///< samples per pixel
  std::uint32_t replicate_samples = 0;  ///< per pixel, of each replicate (set)
  std::uint32_t half_samples = 0;       ///< per pixel, of the first half; 0: halves are not distinguished
  std::uint32_t max_pass_samples = 0;   ///< maximum of samples per pixel of a pass
  SampleRange range;                    ///< samples to be taken, of `spp`

  bool operator==(const SampleDivision&) const = default;

  /// Samples per pixel of the pass that begins at sample `first`.
  std::uint32_t pass_samples(std::uint32_t first) const;
};

/// Whether the passes of `whole` begin with the passes that `part` divides its samples up to `end` into.
bool begins_with(const SampleDivision& whole, const SampleDivision& part, std::uint32_t end);

}  // namespace sheaf
