// Fills registers lane by lane and compares them with the results of scalar code.
#pragma once

#include "core/soa/lane_array.h"

namespace sheaf {

/// A register whose lane k holds f(k).
template <class F> WideFloat wide_floats(F&& f) { return make_lanes<WideFloat>(f); }
template <class F> WideUint wide_uints(F&& f) { return make_lanes<WideUint>(f); }
template <class F> WideMask wide_mask(F&& f) {
  return wide_uints([&](int lane) { return f(lane) ? 1u : 0u; }) != WideUint(0u);
}
inline bool lane_of(WideMask m, int lane) { return (mask_bits(m) >> lane & 1u) != 0; }

/// Whether both have the same bits or are both NaN.
inline bool same(float a, float b) { return float_bits(a) == float_bits(b) || (a != a && b != b); }
/// |a - b| relative to max(|b|, 1); infinite if exactly one of them is NaN.
inline double difference(float a, float b) {
  if (same(a, b) || a == b) return 0.0;
  const double d = std::fabs(static_cast<double>(a) - b) / std::max(1.0, std::fabs(static_cast<double>(b)));
  return d == d ? d : std::numeric_limits<double>::infinity();
}

}  // namespace sheaf
