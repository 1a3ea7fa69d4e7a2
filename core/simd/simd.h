// The SIMD layer: the only file that includes xsimd and depends on its version.
//
// WideFloat, WideUint and WideMask hold kWidth lanes of the widest vector of the machine. Every operation also exists
// for float, std::uint32_t and bool. So code that is generic in the lane policy (core/simd/lanes.h) compiles for one
// path at a time and for kWidth paths at a time. xsimd 8.1 lacks some operations of xsimd 13 (gather, transpose). These
// are implemented here and in simd_*.h, with intrinsics if they are faster and with plain loops otherwise.
#pragma once

#include <xsimd/xsimd.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

// Leaf functions are always inlined, except under sanitizers: with the checks in every copy, the stages would take ten
// minutes to compile.
#if defined(__GNUC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SHEAF_INLINE inline __attribute__((always_inline))
#define SHEAF_LAMBDA_INLINE __attribute__((always_inline))
#else
#define SHEAF_INLINE inline
#define SHEAF_LAMBDA_INLINE
#endif

namespace sheaf {

using FloatBatch = xsimd::batch<float>;
using UintBatch = xsimd::batch<std::uint32_t>;
using MaskBatch = xsimd::batch_bool<float>;
/// Four floats on every machine; see core/color/float4.h.
using Float4Batch = xsimd::make_sized_batch_t<float, 4>;

/// Lanes of one wide register of floats.
inline constexpr int kWidth = static_cast<int>(FloatBatch::size);
/// Alignment in bytes that wide loads and stores of columns need.
inline constexpr std::size_t kSimdAlignment = 64;

/// One truth value per lane.
struct WideMask {
  MaskBatch v;
  SHEAF_INLINE WideMask() : v(false) {}
  SHEAF_INLINE WideMask(bool b) : v(b) {}
  SHEAF_INLINE WideMask(MaskBatch b) : v(b) {}
};

/// kWidth floats.
struct WideFloat {
  FloatBatch v;
  SHEAF_INLINE WideFloat() : v(0.0f) {}
  SHEAF_INLINE WideFloat(float x) : v(x) {}
  SHEAF_INLINE WideFloat(FloatBatch b) : v(b) {}
  SHEAF_INLINE float operator[](int lane) const {
    alignas(kSimdAlignment) float lanes[kWidth];
    v.store_aligned(lanes);
    return lanes[lane];
  }
};

/// kWidth unsigned 32-bit integers; arithmetic wraps.
struct WideUint {
  UintBatch v;
  SHEAF_INLINE WideUint() : v(0u) {}
  SHEAF_INLINE WideUint(std::uint32_t x) : v(x) {}
  SHEAF_INLINE WideUint(UintBatch b) : v(b) {}
  SHEAF_INLINE std::uint32_t operator[](int lane) const {
    alignas(kSimdAlignment) std::uint32_t lanes[kWidth];
    v.store_aligned(lanes);
    return lanes[lane];
  }
};

/// Reinterprets the bits as another kind of batch. xsimd 8 expects the type of the batch, later versions that of its
/// element.
template <class To, class From> SHEAF_INLINE To cast_bits(From a) {
#if XSIMD_VERSION_MAJOR < 9
  return xsimd::bitwise_cast<To>(a);
#else
  return xsimd::bitwise_cast<typename To::value_type>(a);
#endif
}

// ---- batches --------------------------------------------------------------------------------------------------------
/// Operations on batches with the results of those on floats. On NEON, xsimd 8.1 approximates quotients and roots, and
/// the minimum and maximum of NaN and a number are NaN.
namespace batch {

#if defined(__ARM_NEON)
SHEAF_INLINE FloatBatch divide(FloatBatch a, FloatBatch b) { return vdivq_f32(a, b); }
SHEAF_INLINE FloatBatch sqrt(FloatBatch a) { return vsqrtq_f32(a); }
SHEAF_INLINE FloatBatch floor(FloatBatch a) { return vrndmq_f32(a); }
SHEAF_INLINE FloatBatch min(FloatBatch a, FloatBatch b) { return vbslq_f32(vcltq_f32(a, b), a, b); }
SHEAF_INLINE FloatBatch max(FloatBatch a, FloatBatch b) { return vbslq_f32(vcgtq_f32(a, b), a, b); }
#else
template <class Batch> SHEAF_INLINE Batch divide(Batch a, Batch b) { return a / b; }
template <class Batch> SHEAF_INLINE Batch sqrt(Batch a) { return xsimd::sqrt(a); }
template <class Batch> SHEAF_INLINE Batch floor(Batch a) { return xsimd::floor(a); }
template <class Batch> SHEAF_INLINE Batch min(Batch a, Batch b) { return xsimd::min(a, b); }
template <class Batch> SHEAF_INLINE Batch max(Batch a, Batch b) { return xsimd::max(a, b); }
#endif

}  // namespace batch

// ---- WideFloat ------------------------------------------------------------------------------------------------------
SHEAF_INLINE WideFloat operator+(WideFloat a, WideFloat b) { return a.v + b.v; }
SHEAF_INLINE WideFloat operator-(WideFloat a, WideFloat b) { return a.v - b.v; }
SHEAF_INLINE WideFloat operator*(WideFloat a, WideFloat b) { return a.v * b.v; }
SHEAF_INLINE WideFloat operator/(WideFloat a, WideFloat b) { return batch::divide(a.v, b.v); }
SHEAF_INLINE WideFloat operator-(WideFloat a) { return -a.v; }
SHEAF_INLINE WideFloat& operator+=(WideFloat& a, WideFloat b) { return a = a + b; }
SHEAF_INLINE WideFloat& operator-=(WideFloat& a, WideFloat b) { return a = a - b; }
SHEAF_INLINE WideFloat& operator*=(WideFloat& a, WideFloat b) { return a = a * b; }
SHEAF_INLINE WideFloat& operator/=(WideFloat& a, WideFloat b) { return a = a / b; }
SHEAF_INLINE WideMask operator<(WideFloat a, WideFloat b) { return a.v < b.v; }
SHEAF_INLINE WideMask operator<=(WideFloat a, WideFloat b) { return a.v <= b.v; }
SHEAF_INLINE WideMask operator>(WideFloat a, WideFloat b) { return a.v > b.v; }
SHEAF_INLINE WideMask operator>=(WideFloat a, WideFloat b) { return a.v >= b.v; }
SHEAF_INLINE WideMask operator==(WideFloat a, WideFloat b) { return a.v == b.v; }
/// True for NaN, as for float. The comparison of xsimd 8.1 is false for NaN on AVX.
SHEAF_INLINE WideMask operator!=(WideFloat a, WideFloat b) { return !(a.v == b.v); }

// ---- WideMask -------------------------------------------------------------------------------------------------------
SHEAF_INLINE WideMask operator&(WideMask a, WideMask b) { return a.v & b.v; }
SHEAF_INLINE WideMask operator|(WideMask a, WideMask b) { return a.v | b.v; }
SHEAF_INLINE WideMask operator!(WideMask a) { return !a.v; }
SHEAF_INLINE bool any(WideMask m) { return xsimd::any(m.v); }
SHEAF_INLINE bool all(WideMask m) { return xsimd::all(m.v); }

// ---- WideUint -------------------------------------------------------------------------------------------------------
SHEAF_INLINE WideUint operator+(WideUint a, WideUint b) { return a.v + b.v; }
SHEAF_INLINE WideUint operator-(WideUint a, WideUint b) { return a.v - b.v; }
SHEAF_INLINE WideUint operator*(WideUint a, WideUint b) { return a.v * b.v; }
SHEAF_INLINE WideUint operator&(WideUint a, WideUint b) { return a.v & b.v; }
SHEAF_INLINE WideUint operator|(WideUint a, WideUint b) { return a.v | b.v; }
SHEAF_INLINE WideUint operator^(WideUint a, WideUint b) { return a.v ^ b.v; }
SHEAF_INLINE WideUint operator<<(WideUint a, int n) { return a.v << n; }
SHEAF_INLINE WideUint operator>>(WideUint a, int n) { return a.v >> n; }
SHEAF_INLINE WideUint& operator+=(WideUint& a, WideUint b) { return a = a + b; }
SHEAF_INLINE WideUint& operator^=(WideUint& a, WideUint b) { return a = a ^ b; }
SHEAF_INLINE WideUint& operator|=(WideUint& a, WideUint b) { return a = a | b; }
/// Converts a comparison of integers to a mask of floats. Both are the same register, but xsimd has two types.
SHEAF_INLINE WideMask float_mask(xsimd::batch_bool<std::uint32_t> m) {
#if defined(__AVX512F__)
  return MaskBatch(static_cast<__mmask16>(m));
#elif defined(__AVX__)
  return MaskBatch(_mm256_castsi256_ps(m));
#elif defined(__SSE2__)
  return MaskBatch(_mm_castsi128_ps(m));
#else
  return MaskBatch(static_cast<uint32x4_t>(m));
#endif
}
SHEAF_INLINE WideMask operator==(WideUint a, WideUint b) { return float_mask(a.v == b.v); }
SHEAF_INLINE WideMask operator!=(WideUint a, WideUint b) { return float_mask(a.v != b.v); }
SHEAF_INLINE WideMask operator<(WideUint a, WideUint b) { return float_mask(a.v < b.v); }

/// Reverses the 32 bits by exchanging halves, then quarters, down to single bits.
template <class U> SHEAF_INLINE U reverse_bits_stepwise(U x) {
  x = (x >> 16) | (x << 16);
  x = ((x >> 8) & U(0x00ff00ffu)) | ((x & U(0x00ff00ffu)) << 8);
  x = ((x >> 4) & U(0x0f0f0f0fu)) | ((x & U(0x0f0f0f0fu)) << 4);
  x = ((x >> 2) & U(0x33333333u)) | ((x & U(0x33333333u)) << 2);
  return ((x >> 1) & U(0x55555555u)) | ((x & U(0x55555555u)) << 1);
}
/// Reverses the 32 bits. On machines with byte shuffles, reverses the bits of each byte, by an instruction, by a matrix
/// product or by tables of half bytes, and then the bytes.
SHEAF_INLINE WideUint reverse_bits(WideUint a) {
#if defined(__AVX512BW__)
  const __m512i bytes = _mm512_broadcast_i32x4(_mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12));
#if defined(__GFNI__)
  // Row i of this matrix over GF(2) selects bit 7 - i.
  const __m512i mirror = _mm512_set1_epi64(static_cast<long long>(0x8040201008040201u));
  return UintBatch(_mm512_shuffle_epi8(_mm512_gf2p8affine_epi64_epi8(a.v, mirror, 0), bytes));
#else
  const __m512i half = _mm512_set1_epi8(0x0f);
  const __m512i upper =
      _mm512_broadcast_i32x4(_mm_setr_epi8(0, -128, 64, -64, 32, -96, 96, -32, 16, -112, 80, -48, 48, -80, 112, -16));
  const __m512i lower = _mm512_and_si512(_mm512_srli_epi32(upper, 4), half);
  const __m512i rotated =
      _mm512_or_si512(_mm512_shuffle_epi8(upper, _mm512_and_si512(a.v, half)),
                      _mm512_shuffle_epi8(lower, _mm512_and_si512(_mm512_srli_epi32(a.v, 4), half)));
  return UintBatch(_mm512_shuffle_epi8(rotated, bytes));
#endif
#elif defined(__AVX2__)
  const __m256i half = _mm256_set1_epi8(0x0f);
  const __m256i upper = _mm256_broadcastsi128_si256(
      _mm_setr_epi8(0, -128, 64, -64, 32, -96, 96, -32, 16, -112, 80, -48, 48, -80, 112, -16));
  const __m256i lower = _mm256_and_si256(_mm256_srli_epi32(upper, 4), half);
  const __m256i bytes =
      _mm256_broadcastsi128_si256(_mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12));
  const __m256i rotated =
      _mm256_or_si256(_mm256_shuffle_epi8(upper, _mm256_and_si256(a.v, half)),
                      _mm256_shuffle_epi8(lower, _mm256_and_si256(_mm256_srli_epi32(a.v, 4), half)));
  return UintBatch(_mm256_shuffle_epi8(rotated, bytes));
#elif defined(__ARM_NEON)
  return UintBatch(vreinterpretq_u32_u8(vrev32q_u8(vrbitq_u8(vreinterpretq_u8_u32(a.v)))));
#else
  return reverse_bits_stepwise(a);
#endif
}
SHEAF_INLINE std::uint32_t reverse_bits(std::uint32_t a) { return reverse_bits_stepwise(a); }

// ---- selection, conversion ------------------------------------------------------------------------------------------
/// Per lane: `m ? a : b`.
SHEAF_INLINE WideFloat select(WideMask m, WideFloat a, WideFloat b) { return xsimd::select(m.v, a.v, b.v); }
SHEAF_INLINE WideUint select(WideMask m, WideUint a, WideUint b) {
  return cast_bits<UintBatch>(xsimd::select(m.v, cast_bits<FloatBatch>(a.v), cast_bits<FloatBatch>(b.v)));
}
SHEAF_INLINE WideMask select(WideMask m, WideMask a, WideMask b) { return (m & a) | ((!m) & b); }
SHEAF_INLINE float select(bool m, float a, float b) { return m ? a : b; }
SHEAF_INLINE std::uint32_t select(bool m, std::uint32_t a, std::uint32_t b) { return m ? a : b; }
SHEAF_INLINE bool select(bool m, bool a, bool b) { return m ? a : b; }
SHEAF_INLINE bool any(bool m) { return m; }
SHEAF_INLINE bool all(bool m) { return m; }

/// The bits of a float as an integer, and back.
SHEAF_INLINE WideUint float_bits(WideFloat a) { return cast_bits<UintBatch>(a.v); }
SHEAF_INLINE WideFloat bits_float(WideUint a) { return cast_bits<FloatBatch>(a.v); }
SHEAF_INLINE std::uint32_t float_bits(float a) { return std::bit_cast<std::uint32_t>(a); }
SHEAF_INLINE float bits_float(std::uint32_t a) { return std::bit_cast<float>(a); }

/// Integer to float; exact below 2^24. Values must be below 2^31.
SHEAF_INLINE WideFloat to_float(WideUint a) { return xsimd::to_float(cast_bits<xsimd::batch<std::int32_t>>(a.v)); }
SHEAF_INLINE float to_float(std::uint32_t a) { return static_cast<float>(static_cast<std::int32_t>(a)); }
/// Float to integer, towards zero. The value must lie in [0, 2^31).
SHEAF_INLINE WideUint to_uint(WideFloat a) { return cast_bits<UintBatch>(xsimd::to_int(a.v)); }
SHEAF_INLINE std::uint32_t to_uint(float a) { return static_cast<std::uint32_t>(static_cast<std::int32_t>(a)); }

// ---- mathematics ----------------------------------------------------------------------------------------------------
SHEAF_INLINE WideFloat min(WideFloat a, WideFloat b) { return batch::min(a.v, b.v); }
SHEAF_INLINE WideFloat max(WideFloat a, WideFloat b) { return batch::max(a.v, b.v); }
SHEAF_INLINE WideUint min(WideUint a, WideUint b) { return xsimd::min(a.v, b.v); }
SHEAF_INLINE WideFloat abs(WideFloat a) { return xsimd::abs(a.v); }
SHEAF_INLINE WideFloat sqrt(WideFloat a) { return batch::sqrt(a.v); }
SHEAF_INLINE WideFloat floor(WideFloat a) { return batch::floor(a.v); }
SHEAF_INLINE WideFloat exp(WideFloat a) { return xsimd::exp(a.v); }
SHEAF_INLINE WideFloat log(WideFloat a) { return xsimd::log(a.v); }
SHEAF_INLINE WideFloat pow(WideFloat a, WideFloat b) { return xsimd::pow(a.v, b.v); }
SHEAF_INLINE WideFloat sin(WideFloat a) { return xsimd::sin(a.v); }
SHEAF_INLINE WideFloat cos(WideFloat a) { return xsimd::cos(a.v); }
SHEAF_INLINE WideFloat acos(WideFloat a) { return xsimd::acos(a.v); }
SHEAF_INLINE WideFloat atan2(WideFloat y, WideFloat x) { return xsimd::atan2(y.v, x.v); }
SHEAF_INLINE WideMask is_finite(WideFloat a) { return xsimd::abs(a.v) <= FloatBatch(3.4028234e38f); }
/// a * b + c, with one rounding if the machine has FMA.
SHEAF_INLINE WideFloat fma(WideFloat a, WideFloat b, WideFloat c) {
#if defined(__AVX512F__)
  return FloatBatch(_mm512_fmadd_ps(a.v, b.v, c.v));  // xsimd 8.1 rounds twice
#else
  return xsimd::fma(a.v, b.v, c.v);
#endif
}
/// |a| with the sign of `s`.
SHEAF_INLINE WideFloat copysign(WideFloat a, WideFloat s) {
  const WideUint sign(0x80000000u);
  return bits_float((float_bits(a) & WideUint(0x7fffffffu)) | (float_bits(s) & sign));
}

SHEAF_INLINE float min(float a, float b) { return a < b ? a : b; }
SHEAF_INLINE float max(float a, float b) { return a > b ? a : b; }
SHEAF_INLINE std::uint32_t min(std::uint32_t a, std::uint32_t b) { return a < b ? a : b; }
SHEAF_INLINE float abs(float a) { return std::fabs(a); }
SHEAF_INLINE float sqrt(float a) { return std::sqrt(a); }
SHEAF_INLINE float floor(float a) { return std::floor(a); }
SHEAF_INLINE float exp(float a) { return std::exp(a); }
SHEAF_INLINE float log(float a) { return std::log(a); }
SHEAF_INLINE float pow(float a, float b) { return std::pow(a, b); }
SHEAF_INLINE float sin(float a) { return std::sin(a); }
SHEAF_INLINE float cos(float a) { return std::cos(a); }
SHEAF_INLINE float acos(float a) { return std::acos(a); }
SHEAF_INLINE float atan2(float y, float x) { return std::atan2(y, x); }
SHEAF_INLINE bool is_finite(float a) { return std::fabs(a) <= 3.4028234e38f; }
SHEAF_INLINE float fma(float a, float b, float c) {
#if defined(__FMA__) || defined(__ARM_FEATURE_FMA)
  return std::fma(a, b, c);
#else
  return a * b + c;
#endif
}
SHEAF_INLINE float copysign(float a, float s) { return std::copysign(a, s); }

// ---- memory ---------------------------------------------------------------------------------------------------------
/// Loads kWidth values; `p` must be aligned to kWidth * 4 bytes.
SHEAF_INLINE void load(const float* p, WideFloat& out) { out.v = FloatBatch::load_aligned(p); }
SHEAF_INLINE void load(const std::uint32_t* p, WideUint& out) { out.v = UintBatch::load_aligned(p); }
SHEAF_INLINE void load(const float* p, float& out) { out = *p; }
SHEAF_INLINE void load(const std::uint32_t* p, std::uint32_t& out) { out = *p; }
/// Stores kWidth values; `p` must be aligned to kWidth * 4 bytes.
SHEAF_INLINE void store(float* p, WideFloat a) { a.v.store_aligned(p); }
SHEAF_INLINE void store(std::uint32_t* p, WideUint a) { a.v.store_aligned(p); }
SHEAF_INLINE void store(float* p, float a) { *p = a; }
SHEAF_INLINE void store(std::uint32_t* p, std::uint32_t a) { *p = a; }

/// Per lane: base[index].
SHEAF_INLINE WideFloat gather(const float* base, WideUint index) {
#if defined(__AVX512F__)
  return FloatBatch(_mm512_i32gather_ps(index.v, base, 4));
#elif defined(__AVX2__)
  return FloatBatch(_mm256_i32gather_ps(base, index.v, 4));
#else
  alignas(kSimdAlignment) std::uint32_t i[kWidth];
  alignas(kSimdAlignment) float out[kWidth];
  store(i, index);
  for (int lane = 0; lane < kWidth; ++lane) out[lane] = base[i[lane]];
  return FloatBatch::load_aligned(out);
#endif
}
SHEAF_INLINE WideUint gather(const std::uint32_t* base, WideUint index) {
  return float_bits(gather(reinterpret_cast<const float*>(base), index));
}
SHEAF_INLINE float gather(const float* base, std::uint32_t index) { return base[index]; }
SHEAF_INLINE std::uint32_t gather(const std::uint32_t* base, std::uint32_t index) { return base[index]; }

/// Per lane: the byte base[index]; index is below 2^31. The three bytes behind it must be readable too.
SHEAF_INLINE WideUint gather_bytes(const std::uint8_t* base, WideUint index) {
#if defined(__AVX512F__)
  return UintBatch(_mm512_i32gather_epi32(index.v, base, 1)) & UintBatch(0xffu);
#elif defined(__AVX2__)
  return UintBatch(_mm256_i32gather_epi32(reinterpret_cast<const int*>(base), index.v, 1)) & UintBatch(0xffu);
#else
  alignas(kSimdAlignment) std::uint32_t lanes[kWidth];
  store(lanes, index);
  for (std::uint32_t& lane : lanes) lane = base[lane];
  return UintBatch::load_aligned(lanes);
#endif
}
SHEAF_INLINE std::uint32_t gather_bytes(const std::uint8_t* base, std::uint32_t index) { return base[index]; }

/// Per lane: the word at byte `offset`, of any alignment.
SHEAF_INLINE WideUint gather_unaligned(const std::uint8_t* base, WideUint offset) {
#if defined(__AVX2__)
  // Gathers take signed offsets
  constexpr std::uint32_t kHalf = 1u << 31;
  const std::uint8_t* const middle = base + kHalf;
  const WideUint from_middle = offset ^ WideUint(kHalf);
#endif
#if defined(__AVX512F__)
  return UintBatch(_mm512_i32gather_epi32(from_middle.v, middle, 1));
#elif defined(__AVX2__)
  return UintBatch(_mm256_i32gather_epi32(reinterpret_cast<const int*>(middle), from_middle.v, 1));
#else
  alignas(kSimdAlignment) std::uint32_t lanes[kWidth];
  store(lanes, offset);
  for (std::uint32_t& lane : lanes) std::memcpy(&lane, base + lane, sizeof(lane));
  return UintBatch::load_aligned(lanes);
#endif
}
SHEAF_INLINE std::uint32_t gather_unaligned(const std::uint8_t* base, std::uint32_t offset) {
  std::uint32_t word;
  std::memcpy(&word, base + offset, sizeof(word));
  return word;
}

/// 0, 1, ..., kWidth - 1.
SHEAF_INLINE WideUint lane_index() {
  alignas(kSimdAlignment) std::uint32_t i[kWidth];
  for (int lane = 0; lane < kWidth; ++lane) i[lane] = static_cast<std::uint32_t>(lane);
  return UintBatch::load_aligned(i);
}

/// Bit `lane` is set where the lane is true.
SHEAF_INLINE std::uint32_t mask_bits(WideMask m) {
#if defined(__AVX512F__)
  return static_cast<std::uint32_t>(static_cast<__mmask16>(m.v));
#elif defined(__AVX__)
  return static_cast<std::uint32_t>(_mm256_movemask_ps(m.v));
#elif defined(__SSE2__)
  return static_cast<std::uint32_t>(_mm_movemask_ps(m.v));
#else
  return vaddvq_u32(vandq_u32(m.v, uint32x4_t{1, 2, 4, 8}));
#endif
}
SHEAF_INLINE std::uint32_t mask_bits(bool m) { return m ? 1u : 0u; }

/// The lanes [0, count).
SHEAF_INLINE WideMask first_lanes(int count) { return lane_index() < WideUint(static_cast<std::uint32_t>(count)); }

/// The instruction set that Wide compiles to.
inline constexpr const char* kIsaName =
#if defined(__AVX512F__)
    "avx512";
#elif defined(__AVX2__)
    "avx2";
#elif defined(__AVX__)
    "avx";
#elif defined(__SSE4_2__)
    "sse4.2";
#elif defined(__SSE2__)
    "sse2";
#elif defined(__ARM_NEON)
    "neon";
#else
    "generic";
#endif

}  // namespace sheaf
