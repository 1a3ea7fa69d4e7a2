// Prefetching of cache lines.
#pragma once

#include "core/simd/lanes.h"

namespace sheaf {

/// Prefetches the cache line at `address`. Any address is allowed; unreadable ones are ignored.
SHEAF_INLINE void prefetch(const void* address) {
#if defined(__GNUC__)
  __builtin_prefetch(address);
#endif
}

}  // namespace sheaf
