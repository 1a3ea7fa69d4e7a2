// The floating-point mode of a thread that traces rays.
#pragma once

#include <cstdint>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace sheaf {

/// Flushes denormal numbers to zero on this thread during its lifetime. Embree requests this, and it is faster.
class FlushDenormals {
 public:
  FlushDenormals() : saved_(read_mode()) { write_mode(saved_ | kFlush); }
  ~FlushDenormals() { write_mode(saved_); }
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
#if defined(__SSE__)
  using Mode = unsigned;
  static constexpr Mode kFlush = 0x8040u;  // FTZ and DAZ of MXCSR
  static Mode read_mode() { return _mm_getcsr(); }
  static void write_mode(Mode mode) { _mm_setcsr(mode); }
#elif defined(__aarch64__)
  using Mode = std::uint64_t;
  static constexpr Mode kFlush = Mode{1} << 24;  // FZ of FPCR
  static Mode read_mode() {
    Mode mode;
    asm volatile("mrs %0, fpcr" : "=r"(mode));
    return mode;
  }
  static void write_mode(Mode mode) { asm volatile("msr fpcr, %0" ::"r"(mode) : "memory"); }
#else
  using Mode = unsigned;
  static constexpr Mode kFlush = 0;
  static Mode read_mode() { return 0; }
  static void write_mode(Mode) {}
#endif

  Mode saved_;
};

}  // namespace sheaf
