// Asking for cache lines before they are needed.
#pragma once

#include "core/lanes.h"

namespace sheaf {

/// Starts to fetch the cache line at `address`, which may be any: what cannot be read is not.
SHEAF_INLINE void prefetch(const void* address) {
#if defined(__GNUC__)
  __builtin_prefetch(address);
#endif
}

}  // namespace sheaf
