// Binary search, generic in the lane policy.
#pragma once

#include "core/simd/lanes.h"

namespace sheaf {

/// The largest i in [0, count - 2] for which `reached(i)` holds, or 0. `reached` must be true up to some index and
/// false above it.
template <class L, class Reached> SHEAF_INLINE Uint<L> find_interval(Uint<L> count, Reached&& reached) {
  using U = Uint<L>;
  U low(0u), span = count - U(1u);
  while (any(U(1u) < span)) {
    const U half = span >> 1;
    const auto is = reached(low + half);
    low = select(is, low + half, low);
    span = select(is, span - half, half);
  }
  return low;
}

}  // namespace sheaf
