// Implementation of the samplers. Their kind is selected once per register of paths.
#include "core/sampling/sampler.h"

#include "core/sampling/sobol.h"

namespace sheaf {

namespace {

/// The smallest grid of at least `count` cells whose sides differ by at most a factor of two.
SampleGrid make_grid(std::uint32_t count) {
  for (std::uint32_t size = std::max(count, 1u);; ++size)
    for (auto rows = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(size))); 2 * rows * rows >= size; --rows)
      if (size % rows == 0) return {size / rows, rows};
}

bool has_grid(SamplerKind kind) { return kind == SamplerKind::kStratified || kind == SamplerKind::kMultijitter; }

bool is_sobol(SamplerKind kind) { return kind == SamplerKind::kSobol || kind == SamplerKind::kZSobol; }

constexpr std::uint32_t kGoldenRatio = 0x9e3779b9u;

/// a / b and its remainder for a below 2^31 and b below 2^30.
template <class U> SHEAF_INLINE Division<U> divide_any(U a, std::uint32_t b) {
  using F = decltype(to_float(a));
  // The guess is too small by at most 2^-20 of itself. The second step corrects that.
  const U guess = to_uint(to_float(a) * F(0x1.fffffp-1f / static_cast<float>(b)));
  const auto [more, remainder] = divide(a - guess * U(b), b);
  return {guess + more, remainder};
}

/// Spreads the lower 16 bits: bit i moves to bit 2 i.
template <class U> SHEAF_INLINE U spread_bits(U x) {
  x = (x | (x << 8)) & U(0x00ff00ffu);
  x = (x | (x << 4)) & U(0x0f0f0f0fu);
  x = (x | (x << 2)) & U(0x33333333u);
  return (x | (x << 1)) & U(0x55555555u);
}

/// The index of a sample in the sequence of kSobol or kZSobol. kZSobol implements Ahmed and Wonka, "Screen-Space
/// Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels", 2020. The index of a pixel
/// in the sequence is its index on a Z-order (Morton) curve. Shuffling the sequence permutes the quadrants of each
/// square of the curve.
template <class L>
SHEAF_INLINE SobolPoint<L> sobol_point(const SamplerView& sampler, Uint<L> pixel, Uint<L> sample, SampleSet set) {
  using U = Uint<L>;
  const U seed(sampler.seed);
  if (sampler.kind == SamplerKind::kSobol) return {seed, pixel, sample * U(set.count) + U(set.index)};

  // A pixel reserves indices for the sets of 2^sample_bits samples. A sequence covers a square of pixels: usually the
  // whole frame, but at most what 32 bits can count.
  const int sample_bits = std::bit_width(sampler.sample_count - 1);
  const int room_bits = std::bit_width((std::uint64_t{set.count} << sample_bits) - 1);
  const int side_bits = std::clamp((32 - room_bits) / 2, 0, 16);
  const auto [y, x] = divide_any(pixel, sampler.frame_width);
  const U square = (y >> side_bits) * U((sampler.frame_width >> side_bits) + 1) + (x >> side_bits);
  const U side_mask((1u << side_bits) - 1u);
  const U curve = spread_bits(x & side_mask) | (spread_bits(y & side_mask) << 1);
  const U round = sample >> sample_bits;
  const U in_pixel = (sample & U((1u << sample_bits) - 1u)) * U(set.count) + U(set.index);
  return {seed + round * U(0x85ebca6bu), square, (curve << std::min(room_bits, 31)) + in_pixel};
}

template <class L>
SHEAF_INLINE Random4<L> numbers(const SamplerView& sampler, Uint<L> pixel, Uint<L> sample, Uint<L> block, SampleSet set,
                                unsigned requested) {
  const std::uint32_t seed = sampler.seed + set.index * kGoldenRatio;
  switch (sampler.kind) {
    case SamplerKind::kStratified:
      return stratified_random4<L>(seed, sampler.grid, false, pixel, sample, block);
    case SamplerKind::kMultijitter:
      return stratified_random4<L>(seed, sampler.grid, true, pixel, sample, block);
    case SamplerKind::kSobol:
    case SamplerKind::kZSobol:
      return sobol_random4<L>(sobol_point<L>(sampler, pixel, sample, set), block, requested);
    case SamplerKind::kIndependent:
      break;
  }
  return random4<L>(seed, pixel, sample, block);
}

}  // namespace

SamplerView make_sampler(SamplerKind kind, std::uint32_t seed, std::uint32_t sample_count, std::uint32_t frame_width) {
  SamplerView sampler{kind, seed};
  if (has_grid(kind)) sampler.grid = make_grid(sample_count);
  if (kind == SamplerKind::kZSobol) {
    sampler.frame_width = frame_width;
    sampler.sample_count = std::max(sample_count, 1u);
  }
  return sampler;
}

SamplerView without_frame(SamplerView sampler) {
  if (sampler.kind == SamplerKind::kZSobol) sampler.kind = SamplerKind::kSobol;
  return sampler;
}

SamplerView sampler_of_replicate(SamplerView sampler, std::uint32_t replicate, std::uint32_t samples) {
  if (replicate == 0) return sampler;
  std::uint32_t seed = sampler.seed ^ (sampler.seed >> 16), number = replicate, first = 0x7feb352du, second = 0;
  hash4(seed, number, first, second);
  sampler.seed = seed;
  sampler.first_sample = replicate * samples;
  return sampler;
}

std::uint32_t rounded_sample_count(SamplerKind kind, std::uint32_t sample_count) {
  if (sample_count == 0) return 0;
  if (kind == SamplerKind::kZSobol) return std::bit_ceil(sample_count);
  return has_grid(kind) ? make_grid(sample_count).size() : sample_count;
}

template <class L>
Random4<L> draw(const SamplerView& sampler, typename L::Uint pixel, typename L::Uint sample, typename L::Uint dimension,
                SampleBlock block, SampleSet set, unsigned requested) noexcept {
  using U = typename L::Uint;
  const U number = sample - U(sampler.first_sample);
  const auto block_of = [&](SampleBlock of) SHEAF_LAMBDA_INLINE {
    return dimension * U(static_cast<std::uint32_t>(SampleBlock::kCount)) + U(static_cast<std::uint32_t>(of));
  };
  const auto four = [&](unsigned of_them) SHEAF_LAMBDA_INLINE {
    return numbers<L>(sampler, pixel, number, block_of(block), set, of_them);
  };
  if (block == SampleBlock::kCamera) return four(requested);
  // x is the third of the four numbers; y and z are the first two.
  const unsigned but_x = (requested & kNumberW) | (requested & (kNumberY | kNumberZ)) >> 1;
  if (block == SampleBlock::kSelect && is_sobol(sampler.kind)) {
    const Float<L> any(0.0f);
    Random4<L> u{any, any, any, any};
    if (but_x != 0) u = four(but_x);
    const Float<L> fifth = (requested & kNumberX) == 0
                               ? any
                               : sobol_random_fifth<L>(sobol_point<L>(sampler, pixel, number, set),
                                                       block_of(SampleBlock::kScatter), block_of(block));
    return {fifth, u.x, u.y, u.w};
  }
  const Random4<L> u = four(but_x | (requested & kNumberX) << 2);
  return {u.z, u.x, u.y, u.w};
}

template Random4<Scalar> draw<Scalar>(const SamplerView&, Uint<Scalar>, Uint<Scalar>, Uint<Scalar>, SampleBlock,
                                      SampleSet, unsigned) noexcept;
template Random4<Wide> draw<Wide>(const SamplerView&, Uint<Wide>, Uint<Wide>, Uint<Wide>, SampleBlock, SampleSet,
                                  unsigned) noexcept;

}  // namespace sheaf
