// Records of four floats, one pointer per lane: loads and stores that transpose between records and registers.
#pragma once

#include "core/simd/simd.h"

namespace sheaf {

#if !defined(__AVX__)
namespace detail {

/// Transposes four registers of four lanes.
SHEAF_INLINE void transpose4(const FloatBatch* in, WideFloat* out) {
  using Register = FloatBatch::register_type;
  const auto zip_low = [](Register a, Register b) -> Register { return __builtin_shufflevector(a, b, 0, 4, 1, 5); };
  const auto zip_high = [](Register a, Register b) -> Register { return __builtin_shufflevector(a, b, 2, 6, 3, 7); };
  const Register even_low = zip_low(in[0], in[2]), odd_low = zip_low(in[1], in[3]);
  const Register even_high = zip_high(in[0], in[2]), odd_high = zip_high(in[1], in[3]);
  out[0] = FloatBatch(zip_low(even_low, odd_low));
  out[1] = FloatBatch(zip_high(even_low, odd_low));
  out[2] = FloatBatch(zip_low(even_high, odd_high));
  out[3] = FloatBatch(zip_high(even_high, odd_high));
}

}  // namespace detail
#endif

/// Reads four consecutive floats per lane, lane k from rows[k], and transposes them: out[j] holds word j of every lane.
/// Rows need no alignment.
SHEAF_INLINE void load_rows4(const float* const* rows, WideFloat* out) {
#if defined(__AVX512F__)
  // Load rows q, q + 4, q + 8, q + 12 into one register
  __m512 quad[4];
  for (int q = 0; q < 4; ++q) {
    __m512 r = _mm512_castps128_ps512(_mm_loadu_ps(rows[q]));
    r = _mm512_insertf32x4(r, _mm_loadu_ps(rows[q + 4]), 1);
    r = _mm512_insertf32x4(r, _mm_loadu_ps(rows[q + 8]), 2);
    quad[q] = _mm512_insertf32x4(r, _mm_loadu_ps(rows[q + 12]), 3);
  }
  const __m512 t0 = _mm512_unpacklo_ps(quad[0], quad[1]), t1 = _mm512_unpackhi_ps(quad[0], quad[1]);
  const __m512 t2 = _mm512_unpacklo_ps(quad[2], quad[3]), t3 = _mm512_unpackhi_ps(quad[2], quad[3]);
  out[0] = FloatBatch(_mm512_shuffle_ps(t0, t2, 0x44));
  out[1] = FloatBatch(_mm512_shuffle_ps(t0, t2, 0xee));
  out[2] = FloatBatch(_mm512_shuffle_ps(t1, t3, 0x44));
  out[3] = FloatBatch(_mm512_shuffle_ps(t1, t3, 0xee));
#elif defined(__AVX__)
  __m256 pair[4];
  for (int q = 0; q < 4; ++q)
    pair[q] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(rows[q])), _mm_loadu_ps(rows[q + 4]), 1);
  const __m256 t0 = _mm256_unpacklo_ps(pair[0], pair[1]), t1 = _mm256_unpackhi_ps(pair[0], pair[1]);
  const __m256 t2 = _mm256_unpacklo_ps(pair[2], pair[3]), t3 = _mm256_unpackhi_ps(pair[2], pair[3]);
  out[0] = FloatBatch(_mm256_shuffle_ps(t0, t2, 0x44));
  out[1] = FloatBatch(_mm256_shuffle_ps(t0, t2, 0xee));
  out[2] = FloatBatch(_mm256_shuffle_ps(t1, t3, 0x44));
  out[3] = FloatBatch(_mm256_shuffle_ps(t1, t3, 0xee));
#else
  static_assert(kWidth == 4);
  FloatBatch quad[4];
  for (int q = 0; q < 4; ++q) quad[q] = FloatBatch::load_unaligned(rows[q]);
  detail::transpose4(quad, out);
#endif
}
SHEAF_INLINE void load_rows4(const float* const* rows, float* out) { std::memcpy(out, rows[0], 4 * sizeof(float)); }

/// The inverse of load_rows4: writes four consecutive floats to rows[k] for every lane k < count.
SHEAF_INLINE void store_rows4(float* const* rows, const WideFloat* in, int count) {
#if defined(__AVX512F__)
  const __m512 t0 = _mm512_unpacklo_ps(in[0].v, in[1].v), t1 = _mm512_unpackhi_ps(in[0].v, in[1].v);
  const __m512 t2 = _mm512_unpacklo_ps(in[2].v, in[3].v), t3 = _mm512_unpackhi_ps(in[2].v, in[3].v);
  __m512 quad[4];
  quad[0] = _mm512_shuffle_ps(t0, t2, 0x44);
  quad[1] = _mm512_shuffle_ps(t0, t2, 0xee);
  quad[2] = _mm512_shuffle_ps(t1, t3, 0x44);
  quad[3] = _mm512_shuffle_ps(t1, t3, 0xee);
  if (count >= kWidth) {
    for (int q = 0; q < 4; ++q) {
      _mm_storeu_ps(rows[q], _mm512_castps512_ps128(quad[q]));
      _mm_storeu_ps(rows[q + 4], _mm512_extractf32x4_ps(quad[q], 1));
      _mm_storeu_ps(rows[q + 8], _mm512_extractf32x4_ps(quad[q], 2));
      _mm_storeu_ps(rows[q + 12], _mm512_extractf32x4_ps(quad[q], 3));
    }
    return;
  }
  alignas(kSimdAlignment) float parts[4][kWidth];
  for (int q = 0; q < 4; ++q) _mm512_store_ps(parts[q], quad[q]);
  for (int lane = 0; lane < count; ++lane) _mm_storeu_ps(rows[lane], _mm_load_ps(parts[lane & 3] + 4 * (lane >> 2)));
#elif defined(__AVX__)
  const __m256 t0 = _mm256_unpacklo_ps(in[0].v, in[1].v), t1 = _mm256_unpackhi_ps(in[0].v, in[1].v);
  const __m256 t2 = _mm256_unpacklo_ps(in[2].v, in[3].v), t3 = _mm256_unpackhi_ps(in[2].v, in[3].v);
  __m256 pair[4];
  pair[0] = _mm256_shuffle_ps(t0, t2, 0x44);
  pair[1] = _mm256_shuffle_ps(t0, t2, 0xee);
  pair[2] = _mm256_shuffle_ps(t1, t3, 0x44);
  pair[3] = _mm256_shuffle_ps(t1, t3, 0xee);
  if (count >= kWidth) {
    for (int q = 0; q < 4; ++q) {
      _mm_storeu_ps(rows[q], _mm256_castps256_ps128(pair[q]));
      _mm_storeu_ps(rows[q + 4], _mm256_extractf128_ps(pair[q], 1));
    }
    return;
  }
  for (int lane = 0; lane < count; ++lane)
    _mm_storeu_ps(rows[lane], lane < 4 ? _mm256_castps256_ps128(pair[lane]) : _mm256_extractf128_ps(pair[lane - 4], 1));
#else
  const FloatBatch columns[4] = {in[0].v, in[1].v, in[2].v, in[3].v};
  WideFloat quad[4];
  detail::transpose4(columns, quad);
  for (int lane = 0; lane < count && lane < kWidth; ++lane) quad[lane].v.store_unaligned(rows[lane]);
#endif
}
SHEAF_INLINE void store_rows4(float* const* rows, const float* in, int count) {
  if (count > 0) std::memcpy(rows[0], in, 4 * sizeof(float));
}

}  // namespace sheaf
