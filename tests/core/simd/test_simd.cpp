// The SIMD layer: every function in wide registers against its scalar version, lane by lane.
#include "core/simd/flush_denormals.h"
#include "core/simd/simd_compress.h"
#include "core/simd/simd_rows.h"
#include "tests/support/lanes_testing.h"

#include <doctest/doctest.h>

#include <vector>

namespace sheaf::test_simd {

namespace {

/// Evenly spaced values in [low, high], with zeros of both signs if they are inside; the count is a multiple of kWidth.
std::vector<float> sweep(float low, float high, int count = 64 * kWidth) {
  std::vector<float> values;
  for (int i = 0; i < count; ++i)
    values.push_back(low + (high - low) * static_cast<float>(i) / static_cast<float>(count - 1));
  if (low < 0.0f && high > 0.0f) values[1] = 0.0f, values[2] = -0.0f;
  return values;
}

/// Maximum difference between the wide and the scalar f over all values.
template <class F> double worst_unary(F&& f, const std::vector<float>& values) {
  double worst = 0;
  for (std::size_t i = 0; i + kWidth <= values.size(); i += kWidth) {
    const auto wide = f(wide_floats([&](int lane) { return values[i + lane]; }));
    for (int lane = 0; lane < kWidth; ++lane) worst = std::max(worst, difference(wide[lane], f(values[i + lane])));
  }
  return worst;
}

/// The same for two arguments, over all pairs of values; the lanes of the second argument are rotated through `bs`.
template <class F> double worst_binary(F&& f, const std::vector<float>& as, const std::vector<float>& bs) {
  double worst = 0;
  for (std::size_t j = 0; j < bs.size(); ++j)
    for (std::size_t i = 0; i + kWidth <= as.size(); i += kWidth) {
      const auto b = [&](int lane) { return bs[(j + lane) % bs.size()]; };
      const auto wide = f(wide_floats([&](int lane) { return as[i + lane]; }), wide_floats(b));
      for (int lane = 0; lane < kWidth; ++lane)
        worst = std::max(worst, difference(wide[lane], f(as[i + lane], b(lane))));
    }
  return worst;
}

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

std::vector<float> specials() {
  std::vector<float> values = {0.0f,          -0.0f,          1.0f,    -1.0f,      0.5f,       2.75f,
                               -3.25f,        1e30f,          -1e-30f, kInfinity,  -kInfinity, kNaN,
                               3.4028234e38f, -3.4028234e38f, 1e-20f,  16777215.0f};
  return values;
}

}  // namespace

TEST_CASE("simd: arithmetic gives the same bits in registers as for single values") {
  const auto v = specials();
  CHECK(worst_binary([](auto a, auto b) { return a + b; }, v, v) == 0);
  CHECK(worst_binary([](auto a, auto b) { return a - b; }, v, v) == 0);
  CHECK(worst_binary([](auto a, auto b) { return a * b; }, v, v) == 0);
  CHECK(worst_binary([](auto a, auto b) { return a / b; }, v, v) == 0);
  CHECK(worst_binary([](auto a, auto b) { return a += b; }, v, v) == 0);
  CHECK(worst_binary([](auto a, auto b) { return a -= b; }, v, v) == 0);
  CHECK(worst_binary([](auto a, auto b) { return a *= b; }, v, v) == 0);
  CHECK(worst_binary([](auto a, auto b) { return a /= b; }, v, v) == 0);
  CHECK(worst_binary([](auto a, auto b) { return min(a, b); }, v, v) == 0);
  CHECK(worst_binary([](auto a, auto b) { return max(a, b); }, v, v) == 0);
  CHECK(worst_binary([](auto a, auto b) { return copysign(a, b); }, v, v) == 0);
  CHECK(worst_unary([](auto a) { return -a; }, v) == 0);
  CHECK(worst_unary([](auto a) { return abs(a); }, v) == 0);
  CHECK(worst_unary([](auto a) { return sqrt(a); }, v) == 0);
  CHECK(worst_unary([](auto a) { return floor(a); }, v) == 0);
  CHECK(worst_unary([](auto a) { return floor(a); }, sweep(-20.0f, 20.0f)) == 0);
  CHECK(float_bits(copysign(WideFloat(2.0f), WideFloat(-0.0f)))[0] == float_bits(-2.0f));
  CHECK(worst_binary([](auto a, auto b) { return fma(a, b, a); }, sweep(-9.0f, 9.0f), {0.5f, -3.25f, 0.1f}) == 0);
}

TEST_CASE("simd: transcendental functions agree with the standard library") {
  CHECK(worst_unary([](auto a) { return exp(a); }, sweep(-80.0f, 80.0f)) < 3e-7);
  CHECK(worst_unary([](auto a) { return log(a); }, sweep(1e-6f, 50.0f)) < 3e-7);
  CHECK(worst_unary([](auto a) { return sin(a); }, sweep(-12.0f, 12.0f)) < 3e-7);
  CHECK(worst_unary([](auto a) { return cos(a); }, sweep(-12.0f, 12.0f)) < 3e-7);
  CHECK(worst_unary([](auto a) { return acos(a); }, sweep(-1.0f, 1.0f)) < 5e-7);
  CHECK(worst_binary([](auto a, auto b) { return atan2(a, b); }, sweep(-2.0f, 2.0f),
                     {0.3f, -0.7f, 1e-3f, 5.0f, -4.0f}) < 5e-7);
  CHECK(worst_binary([](auto a, auto b) { return pow(a, b); }, sweep(0.01f, 8.0f), {0.0f, 0.45f, 1.0f, 2.4f, -1.5f}) <
        2e-6);
}

TEST_CASE("simd: comparisons and masks and selection agree with scalar code") {
  const auto v = specials();
  int wrong = 0;
  for (std::size_t j = 0; j < v.size(); ++j)
    for (std::size_t i = 0; i < v.size(); ++i) {
      const auto x = [&](int lane) { return v[(i + static_cast<std::size_t>(lane)) % v.size()]; };
      const WideFloat a = wide_floats(x), b(v[j]);
      for (int lane = 0; lane < kWidth; ++lane) {
        const float s = x(lane), t = v[j];
        wrong += lane_of(a < b, lane) != (s < t);
        wrong += lane_of(a <= b, lane) != (s <= t);
        wrong += lane_of(a > b, lane) != (s > t);
        wrong += lane_of(a >= b, lane) != (s >= t);
        wrong += lane_of(a == b, lane) != (s == t);
        wrong += lane_of(a != b, lane) != (s != t);
        wrong += lane_of(is_finite(a), lane) != is_finite(s);
        wrong += is_finite(s) != std::isfinite(s);
        wrong += !same(select(a < b, a, b)[lane], select(s < t, s, t));
      }
    }
  CHECK(wrong == 0);

  const WideMask even = wide_mask([](int lane) { return lane % 2 == 0; }),
                 low = wide_mask([](int lane) { return lane < 2; });
  const WideUint index = Wide::index();
  const WideUint chosen = select(even, index, WideUint(99u));
  wrong = 0;
  for (int lane = 0; lane < kWidth; ++lane) {
    const bool e = lane % 2 == 0, l = lane < 2;
    wrong += lane_of(even & low, lane) != (e && l);
    wrong += lane_of(even | low, lane) != (e || l);
    wrong += lane_of(!even, lane) == e;
    wrong += lane_of(select(low, even, !even), lane) != (l ? e : !e);
    wrong += chosen[lane] != (e ? static_cast<std::uint32_t>(lane) : 99u);
  }
  CHECK(wrong == 0);
  CHECK(any(even));
  CHECK_FALSE(all(even));
  CHECK(all(WideMask(true)));
  CHECK_FALSE(any(WideMask()));
  CHECK(select(true, 1u, 2u) == 1u);
  CHECK_FALSE(select(false, true, false));
  CHECK((any(true) && all(true) && !any(false) && !all(false)));
}

TEST_CASE("simd: integers wrap and shift and compare as unsigned") {
  const std::vector<std::uint32_t> values = {0u,          1u,          2u,       3u,          0x7fffffffu, 0x80000000u,
                                             0x80000001u, 0xffffffffu, 1664525u, 0xdeadbeefu, 65536u,      16777216u};
  int wrong = 0;
  for (const std::uint32_t t : values)
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto x = [&](int lane) { return values[(i + static_cast<std::size_t>(lane)) % values.size()]; };
      const WideUint a = wide_uints(x), b(t);
      WideUint added = a, mixed = a, joined = a;
      added += b, mixed ^= b, joined |= b;
      for (int lane = 0; lane < kWidth; ++lane) {
        const std::uint32_t s = x(lane);
        wrong += (a + b)[lane] != s + t || added[lane] != s + t;
        wrong += (a - b)[lane] != s - t;
        wrong += (a * b)[lane] != s * t;
        wrong += (a & b)[lane] != (s & t);
        wrong += (a | b)[lane] != (s | t) || joined[lane] != (s | t);
        wrong += (a ^ b)[lane] != (s ^ t) || mixed[lane] != (s ^ t);
        wrong += min(a, b)[lane] != min(s, t);
        wrong += lane_of(a == b, lane) != (s == t);
        wrong += lane_of(a != b, lane) != (s != t);
        wrong += lane_of(a < b, lane) != (s < t);
        for (const int n : {0, 1, 8, 16, 31}) wrong += (a >> n)[lane] != s >> n || (a << n)[lane] != s << n;
      }
    }
  CHECK(wrong == 0);
}

TEST_CASE("simd: conversions agree with scalar code") {
  for (const float x : specials()) {
    CHECK(float_bits(WideFloat(x))[kWidth - 1] == float_bits(x));
    CHECK(same(bits_float(float_bits(WideFloat(x)))[0], x));
    CHECK(same(bits_float(float_bits(x)), x));
  }
  for (const std::uint32_t n : {0u, 1u, 255u, 16777215u, 16777217u, 0x7fffffffu}) {
    CHECK(to_float(WideUint(n))[kWidth - 1] == to_float(n));
    CHECK(to_float(n) == static_cast<float>(n));
  }
  for (const float x : {0.0f, 0.99999994f, 1.0f, 7.9f, 16777215.0f, 2147483520.0f}) {
    CHECK(to_uint(WideFloat(x))[0] == to_uint(x));
    CHECK(to_uint(x) == static_cast<std::uint32_t>(x));
  }
}

TEST_CASE("simd: loads and stores and gathers and lane masks agree with scalar code") {
  alignas(kSimdAlignment) float floats[4 * kWidth], back[kWidth];
  alignas(kSimdAlignment) std::uint32_t uints[4 * kWidth], uints_back[kWidth];
  for (int i = 0; i < 4 * kWidth; ++i)
    floats[i] = 0.5f + static_cast<float>(i), uints[i] = 0xfff00000u + static_cast<std::uint32_t>(i);
  WideFloat a;
  WideUint b;
  load(floats + kWidth, a);
  load(uints + kWidth, b);
  store(back, a);
  store(uints_back, b);
  const auto backwards = [](int lane) { return static_cast<std::uint32_t>(4 * kWidth - 1 - 3 * lane); };
  const WideFloat gathered = gather(floats, wide_uints(backwards));
  const WideUint gathered_uints = gather(uints, wide_uints(backwards));
  int wrong = 0;
  for (int lane = 0; lane < kWidth; ++lane) {
    wrong += back[lane] != floats[kWidth + lane] || uints_back[lane] != uints[kWidth + lane];
    wrong += gathered[lane] != gather(floats, backwards(lane)) || gathered[lane] != floats[backwards(lane)];
    wrong += gathered_uints[lane] != gather(uints, backwards(lane)) || gathered_uints[lane] != uints[backwards(lane)];
    wrong += lane_index()[lane] != static_cast<std::uint32_t>(lane);
  }
  CHECK(wrong == 0);
  for (int count = 0; count <= kWidth; ++count) {
    CHECK(mask_bits(first_lanes(count)) == (1u << count) - 1u);
    CHECK(mask_bits(Wide::first(count)) == (1u << count) - 1u);
  }
  CHECK(mask_bits(Scalar::first(0)) == 0u);
  CHECK(mask_bits(Scalar::first(1)) == 1u);
  float x = 0;
  std::uint32_t n = 0;
  load(floats, x), load(uints, n);
  CHECK((x == floats[0] && n == uints[0]));
}

TEST_CASE("simd: gathers of words from any byte take offsets of all 32 bits") {
  std::uint8_t bytes[3 * kWidth + 4];
  for (std::size_t i = 0; i < sizeof(bytes); ++i) bytes[i] = static_cast<std::uint8_t>(7 * i + 3);
  for (const std::uint32_t start : {0u, 0x7ffffff0u, 0x80000000u, 0xf0000000u}) {
    CAPTURE(start);
    const auto* const base = reinterpret_cast<const std::uint8_t*>(
        reinterpret_cast<std::uintptr_t>(static_cast<const void*>(bytes)) - start);
    const auto offset = [start](int lane) { return start + 3 * static_cast<std::uint32_t>(lane); };
    const WideUint words = gather_unaligned(base, wide_uints(offset));
    for (int lane = 0; lane < kWidth; ++lane) {
      std::uint32_t expected = 0;
      std::memcpy(&expected, bytes + 3 * lane, sizeof(expected));
      CHECK(words[lane] == expected);
      CHECK(gather_unaligned(base, offset(lane)) == expected);
    }
  }
}

TEST_CASE("simd: load_rows4 and store_rows4 are inverses and leave other rows alone") {
  constexpr int kRows = 3 * kWidth, kStride = 5;  // an odd stride, to exclude any alignment
  std::vector<float> rows(kRows * kStride);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<float>(i);
  const auto row_of = [](int lane) { return (lane * 7 + 2) % kRows; };
  const float* sources[kWidth];
  for (int lane = 0; lane < kWidth; ++lane) sources[lane] = rows.data() + row_of(lane) * kStride;
  WideFloat words[4];
  load_rows4(sources, words);
  int wrong = 0;
  for (int lane = 0; lane < kWidth; ++lane)
    for (int j = 0; j < 4; ++j) wrong += words[j][lane] != sources[lane][j];
  CHECK(wrong == 0);

  for (int count = 0; count <= kWidth; ++count) {
    std::vector<float> target(rows.size(), -1.0f), expected = target;
    float* targets[kWidth];
    for (int lane = 0; lane < kWidth; ++lane) {
      targets[lane] = target.data() + row_of(lane) * kStride;
      if (lane < count) std::copy_n(sources[lane], 4, expected.begin() + row_of(lane) * kStride);
    }
    store_rows4(targets, words, count);
    CHECK(target == expected);
  }
  float one[4], *target = one;
  const float* source = rows.data() + 3;
  load_rows4(&source, one);
  CHECK((one[0] == 3.0f && one[3] == 6.0f));
  const float other[4] = {9, 8, 7, 6};
  store_rows4(&target, other, 0);
  CHECK(one[0] == 3.0f);
  store_rows4(&target, other, 1);
  CHECK((one[0] == 9.0f && one[3] == 6.0f));
}

TEST_CASE("simd: compress_store keeps the selected lanes for every mask") {
  const WideFloat a = wide_floats([](int lane) { return 10.0f + static_cast<float>(lane); });
  const WideUint b = wide_uints([](int lane) { return 0xff800000u + static_cast<std::uint32_t>(lane); });
  int wrong = 0;
  for (std::uint32_t bits = 0; bits < 1u << kWidth; ++bits) {
    float floats[kWidth + 2];
    std::uint32_t uints[kWidth + 2];
    std::fill_n(floats, kWidth + 2, -1.0f);
    std::fill_n(uints, kWidth + 2, 7u);
    compress_store(floats + 1, a, bits);
    compress_store(uints + 1, b, bits);
    int n = 1;
    for (int lane = 0; lane < kWidth; ++lane)
      if (bits >> lane & 1u) {
        wrong += floats[n] != a[lane] || uints[n] != b[lane];
        ++n;
      }
    wrong += floats[0] != -1.0f || floats[kWidth + 1] != -1.0f || uints[0] != 7u || uints[kWidth + 1] != 7u;
  }
  CHECK(wrong == 0);
  float x = 1.0f;
  std::uint32_t n = 1;
  compress_store(&x, 2.0f, 0u), compress_store(&n, 2u, 0u);
  CHECK((x == 1.0f && n == 1u));
  compress_store(&x, 2.0f, 1u), compress_store(&n, 2u, 1u);
  CHECK((x == 2.0f && n == 2u));
}

TEST_CASE("simd: compress_copy keeps the selected integers for every mask") {
  std::uint16_t from[kWidth + 1], to[kWidth + 2];
  for (int lane = 0; lane <= kWidth; ++lane) from[lane] = static_cast<std::uint16_t>(65535 - 257 * lane);
  int wrong = 0;
  for (std::uint32_t bits = 0; bits < 1u << kWidth; ++bits) {
    std::fill_n(to, kWidth + 2, std::uint16_t{7});
    compress_copy(to + 1, from + 1, bits);
    int n = 1;
    for (int lane = 0; lane < kWidth; ++lane)
      if (bits >> lane & 1u) wrong += to[n++] != from[lane + 1];
    wrong += to[0] != 7 || to[kWidth + 1] != 7;
  }
  CHECK(wrong == 0);
}

#if defined(__SSE__) || defined(__aarch64__)
TEST_CASE("simd: FlushDenormals flushes tiny operands and results to zero during its lifetime") {
  volatile float tiny = 1e-30f, denormal = bits_float(1u);
  {
    const FlushDenormals flush;
    const float product = tiny * tiny * 1e20f, scaled = denormal * 1e30f;
    CHECK(product == 0.0f);
    CHECK(scaled == 0.0f);
  }
  const float scaled = denormal * 1e30f;
  CHECK(scaled > 0.0f);
}
#endif

TEST_CASE("lanes: small helpers agree between the lane policies") {
  const auto v = sweep(-3.0f, 3.0f);
  CHECK(worst_unary([](auto a) { return sqr(a); }, v) == 0);
  CHECK(worst_unary([](auto a) { return safe_sqrt(a); }, v) == 0);
  CHECK(worst_unary([](auto a) { return clamp(a, decltype(a)(-1.0f), decltype(a)(0.5f)); }, v) == 0);
  CHECK(worst_unary([](auto a) { return lerp(a, decltype(a)(2.0f), decltype(a)(5.0f)); }, v) < 1e-6);
  CHECK(lerp(0.25f, 2.0f, 4.0f) == 2.5f);
  CHECK(safe_sqrt(-1e-9f) == 0.0f);
}

}  // namespace sheaf::test_simd
