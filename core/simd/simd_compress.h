// Compaction: moves the lanes that a mask selects next to each other.
#pragma once

#include "core/simd/simd.h"

namespace sheaf {

#if defined(__AVX2__) && !defined(__AVX512F__)
/// For each mask of eight lanes, the permutation that moves the set lanes to the front.
struct CompressTable {
  alignas(kSimdAlignment) std::uint32_t lanes[256][8];
  constexpr CompressTable() : lanes{} {
    for (unsigned bits = 0; bits < 256; ++bits)
      for (unsigned lane = 0, n = 0; lane < 8; ++lane)
        if (bits >> lane & 1u) lanes[bits][n++] = lane;
  }
};
inline constexpr CompressTable kCompressTable{};
#elif (defined(__SSSE3__) && !defined(__AVX__)) || defined(__ARM_NEON)
/// For each mask of four lanes of kBytes bytes, the permutation of bytes that moves the set lanes to the front.
template <int kBytes> struct CompressTable {
  alignas(16) std::uint8_t bytes[16][4 * kBytes];
  constexpr CompressTable() : bytes{} {
    for (unsigned bits = 0; bits < 16; ++bits)
      for (int lane = 0, n = 0; lane < 4; ++lane)
        if (bits >> lane & 1u)
          for (int i = 0; i < kBytes; ++i) bytes[bits][n++] = static_cast<std::uint8_t>(lane * kBytes + i);
  }
};
inline constexpr CompressTable<4> kCompressWords{};
inline constexpr CompressTable<2> kCompressHalves{};
#endif

/// Writes the lanes set in `bits` next to each other, in lane order. Writes up to kWidth values at `p` (no alignment
/// needed), of which the first popcount(bits) are valid.
SHEAF_INLINE void compress_store(float* p, WideFloat a, std::uint32_t bits) {
#if defined(__AVX512F__)
  // Compressing to memory is microcoded on some machines; compressing to a register never is.
  _mm512_storeu_ps(p, _mm512_maskz_compress_ps(static_cast<__mmask16>(bits), a.v));
#elif defined(__AVX2__)
  const __m256i lanes = _mm256_load_si256(reinterpret_cast<const __m256i*>(kCompressTable.lanes[bits]));
  _mm256_storeu_ps(p, _mm256_permutevar8x32_ps(a.v, lanes));
#elif defined(__SSSE3__) && !defined(__AVX__)
  const __m128i order = _mm_load_si128(reinterpret_cast<const __m128i*>(kCompressWords.bytes[bits]));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(p), _mm_shuffle_epi8(_mm_castps_si128(a.v), order));
#elif defined(__ARM_NEON)
  const uint8x16_t order = vld1q_u8(kCompressWords.bytes[bits]);
  vst1q_u8(reinterpret_cast<std::uint8_t*>(p), vqtbl1q_u8(vreinterpretq_u8_f32(a.v), order));
#else
  alignas(kSimdAlignment) float t[kWidth];
  store(t, a);
  for (int lane = 0; lane < kWidth; ++lane) {
    *p = t[lane];
    p += bits >> lane & 1u;
  }
#endif
}
SHEAF_INLINE void compress_store(std::uint32_t* p, WideUint a, std::uint32_t bits) {
  compress_store(reinterpret_cast<float*>(p), bits_float(a), bits);
}
SHEAF_INLINE void compress_store(float* p, float a, std::uint32_t bits) {
  if (bits & 1u) *p = a;
}
SHEAF_INLINE void compress_store(std::uint32_t* p, std::uint32_t a, std::uint32_t bits) {
  if (bits & 1u) *p = a;
}

/// Copies from[lane] for each lane set in `bits` next to each other, in lane order. Reads kWidth values at `from` and
/// writes up to kWidth at `to` (no alignment needed), of which the first popcount(bits) are valid.
SHEAF_INLINE void compress_copy(std::uint16_t* to, const std::uint16_t* from, std::uint32_t bits) {
#if defined(__AVX512VBMI2__) && defined(__AVX512VL__)
  const __m256i all = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_maskz_compress_epi16(static_cast<__mmask16>(bits), all));
#elif defined(__AVX512F__)
  const __m512i all = _mm512_cvtepu16_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(from)));
  const __m512i chosen = _mm512_maskz_compress_epi32(static_cast<__mmask16>(bits), all);
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm512_cvtepi32_epi16(chosen));
#elif defined(__AVX2__)
  const __m256i all = _mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from)));
  const __m256i lanes = _mm256_load_si256(reinterpret_cast<const __m256i*>(kCompressTable.lanes[bits]));
  const __m256i chosen = _mm256_permutevar8x32_epi32(all, lanes);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to),
                   _mm_packus_epi32(_mm256_castsi256_si128(chosen), _mm256_extracti128_si256(chosen, 1)));
#elif defined(__SSSE3__) && !defined(__AVX__)
  const __m128i order = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(kCompressHalves.bytes[bits]));
  const __m128i all = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(from));
  _mm_storel_epi64(reinterpret_cast<__m128i*>(to), _mm_shuffle_epi8(all, order));
#elif defined(__ARM_NEON)
  const uint8x8_t all = vld1_u8(reinterpret_cast<const std::uint8_t*>(from));
  vst1_u8(reinterpret_cast<std::uint8_t*>(to), vtbl1_u8(all, vld1_u8(kCompressHalves.bytes[bits])));
#else
  for (; bits != 0; bits &= bits - 1) *to++ = from[std::countr_zero(bits)];
#endif
}

}  // namespace sheaf
