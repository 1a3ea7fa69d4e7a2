// Conversion of any float to an integer.
#pragma once

#include "core/simd/simd.h"

namespace sheaf {

/// Truncates towards zero. NaN and out-of-range values become a number that is at least 2^31 when read as unsigned.
SHEAF_INLINE std::int32_t truncate(float x) {
#if defined(__SSE__)
  return _mm_cvttss_si32(_mm_set_ss(x));
#else
  return x < 2147483648.0f && x >= -2147483648.0f ? static_cast<std::int32_t>(x) : std::int32_t{-1};
#endif
}

}  // namespace sheaf
