// Columns of small unsigned integers, loaded as registers of 32 bits.
#pragma once

#include "core/simd/simd.h"

namespace sheaf {

/// Loads kWidth integers, exactly; `p` must be aligned to kWidth times their size.
SHEAF_INLINE void load(const std::uint16_t* p, WideUint& out) {
#if defined(__AVX512F__)
  out.v = UintBatch(_mm512_cvtepu16_epi32(_mm256_load_si256(reinterpret_cast<const __m256i*>(p))));
#elif defined(__AVX2__)
  out.v = UintBatch(_mm256_cvtepu16_epi32(_mm_load_si128(reinterpret_cast<const __m128i*>(p))));
#else
  alignas(kSimdAlignment) std::uint32_t lanes[kWidth];
  for (int lane = 0; lane < kWidth; ++lane) lanes[lane] = p[lane];
  out.v = UintBatch::load_aligned(lanes);
#endif
}
SHEAF_INLINE void load(const std::uint16_t* p, WideFloat& out) {
  WideUint integers;
  load(p, integers);
  out = to_float(integers);
}
SHEAF_INLINE void load(const std::uint8_t* p, WideFloat& out) {
#if defined(__AVX512F__)
  const __m128i bytes = _mm_load_si128(reinterpret_cast<const __m128i*>(p));
  out.v = FloatBatch(_mm512_cvtepi32_ps(_mm512_cvtepu8_epi32(bytes)));
#elif defined(__AVX2__)
  const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(p));
  out.v = FloatBatch(_mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes)));
#else
  alignas(kSimdAlignment) float lanes[kWidth];
  for (int lane = 0; lane < kWidth; ++lane) lanes[lane] = static_cast<float>(p[lane]);
  out.v = FloatBatch::load_aligned(lanes);
#endif
}
SHEAF_INLINE void load(const std::uint16_t* p, std::uint32_t& out) { out = *p; }
SHEAF_INLINE void load(const std::uint16_t* p, float& out) { out = static_cast<float>(*p); }
SHEAF_INLINE void load(const std::uint8_t* p, float& out) { out = static_cast<float>(*p); }

}  // namespace sheaf
