// Samplers: the choice among them, once per register of paths.
#include "core/sampler.h"

#include "core/sobol.h"

namespace sheaf {

namespace {

/// The smallest grid of `count` cells or more whose sides differ by a factor of two at most.
SampleGrid make_grid(std::uint32_t count) {
  for (std::uint32_t size = std::max(count, 1u);; ++size)
    for (auto rows = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(size))); 2 * rows * rows >= size; --rows)
      if (size % rows == 0) return {size / rows, rows};
}

bool has_grid(SamplerKind kind) { return kind == SamplerKind::kStratified || kind == SamplerKind::kMultijitter; }

constexpr std::uint32_t kGoldenRatio = 0x9e3779b9u;

template <class L>
SHEAF_INLINE Random4<L> sobol_numbers(const SamplerView& sampler, Uint<L> pixel, Uint<L> sample, Uint<L> block,
                                      SampleSet set) {
  Uint<L> seed(sampler.seed);
  if (sampler.replicates > 1) {
    const auto [index, replicate] = divide(sample, sampler.replicates);
    sample = index;
    seed = seed + replicate * Uint<L>(kGoldenRatio);
  }
  return sobol_random4<L>(seed, pixel, sample * Uint<L>(set.count) + Uint<L>(set.index), block);
}

template <class L>
SHEAF_INLINE Random4<L> numbers(const SamplerView& sampler, Uint<L> pixel, Uint<L> sample, Uint<L> block,
                                SampleSet set) {
  const std::uint32_t seed = sampler.seed + set.index * kGoldenRatio;
  switch (sampler.kind) {
    case SamplerKind::kStratified: return stratified_random4<L>(seed, sampler.grid, false, pixel, sample, block);
    case SamplerKind::kMultijitter: return stratified_random4<L>(seed, sampler.grid, true, pixel, sample, block);
    case SamplerKind::kSobol:
      return sobol_numbers<L>(sampler, pixel, sample, block, set);
    case SamplerKind::kIndependent: break;
  }
  return random4<L>(seed, pixel, sample, block);
}

}  // namespace

SamplerView make_sampler(SamplerKind kind, std::uint32_t seed, std::uint32_t sample_count) {
  return {kind, seed, has_grid(kind) ? make_grid(sample_count) : SampleGrid{}};
}

std::uint32_t rounded_sample_count(SamplerKind kind, std::uint32_t sample_count) {
  return has_grid(kind) && sample_count > 0 ? make_grid(sample_count).size() : sample_count;
}

template <class L>
Random4<L> draw(const SamplerView& sampler, typename L::Uint pixel, typename L::Uint sample, typename L::Uint event,
                SampleBlock block, SampleSet set) noexcept {
  using U = typename L::Uint;
  const U index = event * U(static_cast<std::uint32_t>(SampleBlock::kCount)) + U(static_cast<std::uint32_t>(block));
  const Random4<L> u = numbers<L>(sampler, pixel, sample, index, set);
  if (block == SampleBlock::kCamera) return u;
  return {u.z, u.x, u.y, u.w};
}

template Random4<Scalar> draw<Scalar>(const SamplerView&, Uint<Scalar>, Uint<Scalar>, Uint<Scalar>, SampleBlock,
                                      SampleSet) noexcept;
template Random4<Wide> draw<Wide>(const SamplerView&, Uint<Wide>, Uint<Wide>, Uint<Wide>, SampleBlock,
                                  SampleSet) noexcept;

}  // namespace sheaf
