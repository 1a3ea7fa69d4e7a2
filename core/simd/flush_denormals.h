// The floating-point mode of a thread that traces rays.
#pragma once

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace sheaf {

/// Flushes denormal numbers to zero on this thread during its lifetime. Embree requests this, and it is faster.
class FlushDenormals {
 public:
#if defined(__SSE__)
  FlushDenormals() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | 0x8040u); }
  ~FlushDenormals() { _mm_setcsr(saved_); }
#else
  FlushDenormals() = default;
#endif
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  unsigned saved_ = 0;
};

}  // namespace sheaf
