#include "kernels/render/sample_division.h"

#include <algorithm>

namespace sheaf {

std::uint32_t SampleDivision::pass_samples(std::uint32_t first) const {
  const std::uint32_t count =
      std::min({max_pass_samples, range.end() - first, replicate_samples - first % replicate_samples});
  return half_samples > 0 && first < half_samples ? std::min(count, half_samples - first) : count;
}

bool begins_with(const SampleDivision& whole, const SampleDivision& part, std::uint32_t end) {
  if (whole == part) return true;
  if (whole.range.first != part.range.first || end > whole.range.end() || end > part.range.end()) return false;
  // Without sets there are no variances, and halves depend on the number of samples
  const auto is_one_set = [](const SampleDivision& d) { return d.replicate_samples >= d.spp; };
  if (is_one_set(whole) != is_one_set(part)) return false;
  if (whole.half_samples > 0 || part.half_samples > 0) return false;
  for (std::uint32_t first = part.range.first; first < end;) {
    const std::uint32_t samples = part.pass_samples(first), next = first + samples;
    const bool same_set = first / whole.replicate_samples == first / part.replicate_samples;
    const bool both_end = (next % whole.replicate_samples == 0) == (next % part.replicate_samples == 0);
    if (whole.pass_samples(first) != samples || !same_set || !(both_end || is_one_set(part))) return false;
    first = next;
  }
  return true;
}

}  // namespace sheaf
