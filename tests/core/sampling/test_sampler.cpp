// Samplers: uniformity, independence where it is required, and unbiased estimates of integrals with the expected
// convergence.
#include "core/sampling/sampler.h"

#include "tests/support/chi_square.h"
#include "tests/support/lanes_testing.h"

#include <doctest/doctest.h>

#include <array>
#include <functional>
#include <unordered_set>
#include <vector>

namespace sheaf::test_sampler {

namespace {

using U = std::uint32_t;
using Numbers = std::array<float, 4>;

constexpr SamplerKind kKinds[] = {SamplerKind::kIndependent, SamplerKind::kStratified, SamplerKind::kMultijitter,
                                  SamplerKind::kSobol, SamplerKind::kZSobol};
constexpr int kKindCount = static_cast<int>(std::size(kKinds));
/// Frame width that makes pixels fill a square as well as possible, because kZSobol guarantees nothing for lines of
/// pixels.
constexpr U kFrameWidth = 128;

SamplerView sampler_of(SamplerKind kind, U seed, U sample_count) {
  return make_sampler(kind, seed, sample_count, kFrameWidth);
}
constexpr SampleBlock kBlocks[] = {SampleBlock::kCamera, SampleBlock::kLight, SampleBlock::kScatter,
                                   SampleBlock::kSelect};

Numbers numbers(const SamplerView& sampler, U pixel, U sample, U dimension = 0,
                SampleBlock block = SampleBlock::kCamera, SampleSet set = {}) {
  const Random4<Scalar> r = draw<Scalar>(sampler, pixel, sample, dimension, block, set);
  return {r.x, r.y, r.z, r.w};
}

/// p-value of a chi-square test for one pair of numbers per pixel on cells x cells cells.
double p_value_of_pairs(int cells, U pixels, const std::function<std::array<float, 2>(U)>& pair) {
  std::vector<double> counts(static_cast<std::size_t>(cells * cells));
  for (U pixel = 0; pixel < pixels; ++pixel) {
    const auto [a, b] = pair(pixel);
    const auto n = static_cast<float>(cells);
    counts[static_cast<std::size_t>(a * n) * static_cast<std::size_t>(cells) + static_cast<std::size_t>(b * n)] += 1.0;
  }
  return chi_square_uniform(counts).p_value;
}

/// Estimates of an integral over a block, one for each pixel, from `samples` samples each.
MeanVariance estimates(const SamplerView& sampler, U samples, U pixels, SampleBlock block,
                       const std::function<double(const Numbers&)>& f) {
  MeanVariance result;
  for (U pixel = 0; pixel < pixels; ++pixel) {
    double sum = 0;
    for (U i = 0; i < samples; ++i) sum += f(numbers(sampler, pixel, i, 2, block));
    result.add(sum / samples);
  }
  return result;
}

struct Integrand {
  const char* name;
  std::function<double(const Numbers&)> f;
  double integral;
};

const std::vector<Integrand>& integrands() {
  static const std::vector<Integrand> all = {
      {"edge", [](const Numbers& u) { return u[1] + 0.7 * u[2] < 0.6 ? 1.0 : 0.0; }, 0.18 / 0.7},
      {"disk", [](const Numbers& u) { return u[1] * u[1] + u[2] * u[2] < 1 ? 1.0 : 0.0; }, 0.785398163397448},
      {"ramp", [](const Numbers& u) { return double(u[0]); }, 0.5},
      {"bump", [](const Numbers& u) { return std::exp(-(u[1] - 0.4) * (u[1] - 0.4) * 8) * u[2]; },
       0.5 * 0.5 * std::sqrt(3.14159265358979 / 8) * (std::erf(0.6 * std::sqrt(8.0)) + std::erf(0.4 * std::sqrt(8.0)))},
      {"all four", [](const Numbers& u) { return 16.0 * u[0] * u[1] * u[2] * u[3]; }, 1.0},
  };
  return all;
}

}  // namespace

TEST_CASE("sampler: each number is uniform over pixels for every sample") {
  constexpr U kSamples[] = {0, 1, 2, 5, 15, 16, 1000};
  constexpr int kTests = kKindCount * 7 * 4;
  for (const SamplerKind kind : kKinds)
    for (const U sample : kSamples) {
      const SamplerView sampler = sampler_of(kind, 3, 16);
      std::vector<double> counts[4] = {std::vector<double>(256), std::vector<double>(256), std::vector<double>(256),
                                       std::vector<double>(256)};
      for (U pixel = 0; pixel < 20'000; ++pixel) {
        const Numbers u = numbers(sampler, pixel, sample, 1, SampleBlock::kLight);
        for (std::size_t d = 0; d < 4; ++d) counts[d].at(static_cast<std::size_t>(u[d] * 256.0f)) += 1.0;
      }
      CAPTURE(static_cast<int>(kind));
      CAPTURE(sample);
      for (const auto& dimension : counts) CHECK(chi_square_uniform(dimension).p_value > significance_of_each(kTests));
    }
}

TEST_CASE("sampler: the four numbers of a sample are independent over pixels") {
  constexpr int kTests = kKindCount * 3 * 6;
  for (const SamplerKind kind : kKinds)
    for (const U sample : {0u, 1u, 11u})
      for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = a + 1; b < 4; ++b) {
          const SamplerView sampler = sampler_of(kind, 5, 16);
          const double p = p_value_of_pairs(16, 20'000, [&](U pixel) {
            const Numbers u = numbers(sampler, pixel, sample);
            return std::array<float, 2>{u[a], u[b]};
          });
          CHECK(p > significance_of_each(kTests));
        }
}

TEST_CASE("sampler: the position of a sample in its sequence is independent of the scrambling") {
  // Pairs and triples of numbers of one sample, with 8 cells per dimension, over pixels.
  constexpr U kSamples = 16, kPixels = 30'000;
  const SamplerView sampler = make_sampler(SamplerKind::kSobol, 1, kSamples);
  for (U sample = 0; sample < kSamples; ++sample) {
    std::vector<std::vector<double>> pairs(6, std::vector<double>(64)), triples(4, std::vector<double>(512));
    for (U pixel = 0; pixel < kPixels; ++pixel) {
      const Numbers u = numbers(sampler, pixel, sample);
      std::size_t cell[4], pair = 0;
      for (std::size_t d = 0; d < 4; ++d) cell[d] = to_uint(u[d] * 8.0f);
      for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = a + 1; b < 4; ++b) pairs[pair++][cell[a] * 8 + cell[b]] += 1.0;
      for (std::size_t out = 0; out < 4; ++out)
        triples[out][(cell[out == 0 ? 1 : 0] * 8 + cell[out < 2 ? 2 : 1]) * 8 + cell[out < 3 ? 3 : 2]] += 1.0;
    }
    CAPTURE(sample);
    for (const auto& counts : pairs) CHECK(chi_square_uniform(counts).p_value > significance_of_each(10 * kSamples));
    for (const auto& counts : triples) CHECK(chi_square_uniform(counts).p_value > significance_of_each(10 * kSamples));
  }
}

TEST_CASE("sampler: blocks and dimensions and pixels and seeds and sets are independent of each other") {
  constexpr int kTests = kKindCount * 2 * 5 * 4;
  for (const SamplerKind kind : kKinds)
    for (const U sample : {0u, 7u})
      for (std::size_t d = 0; d < 4; ++d) {
        const SamplerView sampler = sampler_of(kind, 5, 16), other = sampler_of(kind, 6, 16);
        const auto p_value = [&](const std::function<Numbers(U)>& second) {
          return p_value_of_pairs(16, 20'000, [&](U pixel) {
            return std::array<float, 2>{numbers(sampler, 2 * pixel, sample, 3, SampleBlock::kLight)[d],
                                        second(2 * pixel)[d]};
          });
        };
        const double level = significance_of_each(kTests);
        CAPTURE(static_cast<int>(kind));
        CAPTURE(sample);
        CAPTURE(d);
        CHECK(p_value([&](U p) { return numbers(sampler, p, sample, 3, SampleBlock::kScatter); }) > level);
        CHECK(p_value([&](U p) { return numbers(sampler, p, sample, 4, SampleBlock::kLight); }) > level);
        if (kind != SamplerKind::kZSobol)
          CHECK(p_value([&](U p) { return numbers(sampler, p + 1, sample, 3, SampleBlock::kLight); }) > level);
        CHECK(p_value([&](U p) { return numbers(other, p, sample, 3, SampleBlock::kLight); }) > level);
        if (kind != SamplerKind::kSobol && kind != SamplerKind::kZSobol)
          CHECK(p_value([&](U p) { return numbers(sampler, p, sample, 3, SampleBlock::kLight, {1, 2}); }) > level);
      }
}

TEST_CASE("sampler: samples of two blocks are paired at random within a pixel") {
  // The mean of (a - 1/2)(b - 1/2) over the samples of a pixel, with a and b from different blocks, has mean 0 and a
  // variance of 1/144 per sample. Consecutive Sobol samples lie on opposite sides of the center in every dimension,
  // which increases the variance up to a factor of 2. Without shuffling the factor would be 64 or almost 0.
  constexpr U kPixels = 3000, kSamples = 64;
  for (const SamplerKind kind : kKinds)
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < 4; ++b) {
        const SamplerView sampler = sampler_of(kind, 9, kSamples);
        MeanVariance products;
        for (U pixel = 0; pixel < kPixels; ++pixel) {
          double sum = 0;
          for (U i = 0; i < kSamples; ++i)
            sum += (numbers(sampler, pixel, i, 1, SampleBlock::kLight)[a] - 0.5) *
                   (numbers(sampler, pixel, i, 2, SampleBlock::kScatter)[b] - 0.5);
          products.add(sum / kSamples);
        }
        CHECK(products.p_value(0) > significance_of_each(kKindCount * 16));
        const double variance = products.variance() * kSamples * 144;
        CHECK(variance > 0.8);
        CHECK(variance < 2.2);
      }
}

TEST_CASE("sampler: estimates of integrals are unbiased") {
  constexpr int kTests = kKindCount * 5 * 3;
  for (const SamplerKind kind : kKinds)
    for (const Integrand& integrand : integrands())
      for (const U samples : {1u, 7u, 16u}) {
        CAPTURE(static_cast<int>(kind));
        CAPTURE(integrand.name);
        CAPTURE(samples);
        const auto found = estimates(sampler_of(kind, 1, 16), samples, 4000, SampleBlock::kScatter, integrand.f);
        CHECK(found.p_value(integrand.integral) > significance_of_each(kTests));
      }
}

TEST_CASE("sampler: better stratified samples reduce the error") {
  const auto variance = [](SamplerKind kind, const Integrand& integrand) {
    return estimates(sampler_of(kind, 1, 64), 64, 400, SampleBlock::kScatter, integrand.f).variance();
  };
  for (const Integrand& integrand : integrands()) {
    CAPTURE(integrand.name);
    const double independent = variance(SamplerKind::kIndependent, integrand);
    CHECK(variance(SamplerKind::kStratified, integrand) < 0.6 * independent);
    CHECK(variance(SamplerKind::kMultijitter, integrand) < 0.6 * independent);
    CHECK(variance(SamplerKind::kSobol, integrand) < 0.25 * independent);
    CHECK(variance(SamplerKind::kZSobol, integrand) < 0.25 * independent);
  }
}

TEST_CASE("sampler: samples that choose the same lobe are well stratified over directions") {
  // Only the component that is chosen with this probability scatters, as a smooth function of the direction.
  constexpr float kFraction = 0.3f;
  const auto variance = [&](SamplerKind kind, SampleBlock choice) {
    const SamplerView sampler = sampler_of(kind, 1, 64);
    MeanVariance result;
    for (U pixel = 0; pixel < 2000; ++pixel) {
      double sum = 0;
      for (U i = 0; i < 64; ++i) {
        const Numbers u = numbers(sampler, pixel, i, 2, SampleBlock::kScatter);
        if (numbers(sampler, pixel, i, 2, choice)[0] < kFraction) sum += double{u[1]} + double{u[2]};
      }
      result.add(sum / 64);
    }
    CHECK(result.p_value(0.3) > significance_of_each(4));
    return result.variance();
  };
  for (const SamplerKind kind : {SamplerKind::kSobol, SamplerKind::kZSobol})
    CHECK(variance(kind, SampleBlock::kSelect) < 0.35 * variance(kind, SampleBlock::kResample));
}

TEST_CASE("sampler: Sobol points fill the best plane of each block at every power of two") {
  const SamplerView sampler = make_sampler(SamplerKind::kSobol, 1, 4);
  for (const SampleBlock block : kBlocks)
    for (const int k : {2, 4, 6, 8}) {
      const std::size_t first = block == SampleBlock::kCamera ? 0 : 1;
      const U side = 1u << (k / 2);
      std::vector<int> hits(side * side);
      for (U i = 0; i < side * side; ++i) {
        const Numbers u = numbers(sampler, 12, i, 5, block);
        ++hits[to_uint(u[first] * static_cast<float>(side)) * side + to_uint(u[first + 1] * static_cast<float>(side))];
      }
      CHECK(std::all_of(hits.begin(), hits.end(), [](int n) { return n == 1; }));
    }
}

TEST_CASE("sampler: neighboring pixels share a Sobol sequence and each square of pixels gets a range of it") {
  const SamplerView sampler = make_sampler(SamplerKind::kZSobol, 1, 4, 100);
  for (const SampleBlock block : kBlocks)
    for (const U side : {1u, 2u, 4u, 8u})
      for (const U first : {0u, 4u, 12u}) {  // sample 4 and later ones exceed the sample count
        const std::size_t d = block == SampleBlock::kCamera ? 0 : 1;
        const U cells = 2 * side;
        std::vector<int> hits(cells * cells);
        for (U y = 0; y < side; ++y)
          for (U x = 0; x < side; ++x)
            for (U i = 0; i < 4; ++i) {
              const Numbers u = numbers(sampler, (16 + y) * 100 + 72 + x, first + i, 5, block);
              const auto at = [&](std::size_t k) { return to_uint(u[k] * static_cast<float>(cells)); };
              ++hits[at(d) * cells + at(d + 1)];
            }
        CHECK(std::all_of(hits.begin(), hits.end(), [](int n) { return n == 1; }));
      }
}

TEST_CASE("sampler: one sequence for all pixels reduces the error of means over squares of pixels") {
  const auto variance = [](SamplerKind kind) {
    const auto& f = integrands()[0].f;
    MeanVariance means;
    for (U seed = 0; seed < 300; ++seed) {
      const SamplerView sampler = make_sampler(kind, seed, 4, 50);
      double sum = 0;
      for (U pixel = 0; pixel < 16; ++pixel)
        for (U i = 0; i < 4; ++i)
          sum += f(numbers(sampler, (8 + pixel / 4) * 50 + 12 + pixel % 4, i, 2, SampleBlock::kScatter));
      means.add(sum / 64);
    }
    CHECK(means.p_value(integrands()[0].integral) > significance_of_each(2));
    return means.variance();
  };
  CHECK(variance(SamplerKind::kZSobol) < 0.35 * variance(SamplerKind::kSobol));
}

TEST_CASE("sampler: numbers of a shared sequence are uniform over seeds at each pixel and differ between pixels") {
  // With 2^20 samples per pixel a sequence suffices for 64 x 64 pixels.
  for (const U sample_count : {4u, 1u << 20})
    for (const U other : {1u, 64u, 64u * 1000u}) {
      const auto at = [&](U seed, U pixel) {
        return numbers(make_sampler(SamplerKind::kZSobol, seed, sample_count, 1000), pixel, 1, 3, SampleBlock::kLight);
      };
      const double level = significance_of_each(2 * 3 * 3);
      CHECK(p_value_of_pairs(16, 20'000, [&](U s) { return std::array{at(s, 63'063)[0], at(s, 63'063)[1]}; }) > level);
      CHECK(p_value_of_pairs(16, 20'000, [&](U s) { return std::array{at(s, 63'063)[2], at(s, 63'063)[3]}; }) > level);
      int same = 0;
      for (U seed = 0; seed < 500; ++seed) same += at(seed, 63'063) == at(seed, 63'063 + other);
      CHECK(same == 0);
    }
}

TEST_CASE("sampler: the sets of one Sobol sample continue the sequence") {
  const SamplerView sampler = make_sampler(SamplerKind::kSobol, 1, 4);
  for (U sample = 0; sample < 4; ++sample)
    for (U m = 0; m < 8; ++m)
      CHECK(numbers(sampler, 3, sample, 1, SampleBlock::kLight, {m, 8}) ==
            numbers(sampler, 3, sample * 8 + m, 1, SampleBlock::kLight));
}

TEST_CASE("sampler: each replicate of a Sobol sequence is a Sobol sequence and replicates are independent") {
  const SamplerView sampler = make_sampler(SamplerKind::kSobol, 1, 8);
  const auto& integrand = integrands()[0].f;
  // Means of a pixel over several replicates. Their variance must be that of one replicate over the number of
  // replicates.
  MeanVariance of_one, of_all;
  constexpr U kReplicates = 4, kSamples = 8;
  for (U pixel = 0; pixel < 4000; ++pixel) {
    double sum = 0;
    for (U replicate = 0; replicate < kReplicates; ++replicate) {
      const SamplerView own = sampler_of_replicate(sampler, replicate, kSamples);
      double mean = 0;
      int hits[8] = {};
      for (U i = 0; i < kSamples; ++i) {
        const Numbers u = numbers(own, pixel, replicate * kSamples + i);
        ++hits[to_uint(u[0] * 8.0f)];
        mean += integrand(u) / kSamples;
      }
      CHECK(std::all_of(std::begin(hits), std::end(hits), [](int n) { return n == 1; }));
      if (replicate == 0) of_one.add(mean);
      sum += mean / kReplicates;
    }
    of_all.add(sum);
  }
  CHECK(of_all.variance() * kReplicates > 0.85 * of_one.variance());  // the standard deviation of the ratio is 0.03
  CHECK(of_all.variance() * kReplicates < 1.15 * of_one.variance());
}

TEST_CASE("sampler: numbers depend on the sample index and not on the sample count") {
  for (U sample = 0; sample < 300; ++sample) {
    const auto few = make_sampler(SamplerKind::kSobol, 1, 4), many = make_sampler(SamplerKind::kSobol, 1, 1u << 24);
    CHECK(numbers(few, 8, sample) == numbers(many, 8, sample));
  }
}

TEST_CASE("sampler: samples beyond the grid fill it again in another order") {
  for (const SamplerKind kind : {SamplerKind::kStratified, SamplerKind::kMultijitter}) {
    const SamplerView sampler = make_sampler(kind, 1, 12);
    REQUIRE(sampler.grid.size() == 12);
    int same_cell = 0;
    for (U pixel = 0; pixel < 100; ++pixel)
      for (U i = 0; i < 12; ++i) {
        const Numbers a = numbers(sampler, pixel, i), b = numbers(sampler, pixel, i + 12);
        same_cell += to_uint(a[0] * 4.0f) == to_uint(b[0] * 4.0f) && to_uint(a[1] * 3.0f) == to_uint(b[1] * 3.0f);
      }
    CHECK(same_cell > 60);  // 100 expected, standard deviation 9.6
    CHECK(same_cell < 140);
  }
}

TEST_CASE("sampler: samples beyond the shared sequence use another sequence") {
  const double level = significance_of_each(4);
  for (std::size_t d = 0; d < 4; ++d)
    CHECK(p_value_of_pairs(16, 20'000, [&](U seed) {
            const SamplerView sampler = make_sampler(SamplerKind::kZSobol, seed, 4, 100);
            return std::array{numbers(sampler, 777, 1)[d], numbers(sampler, 777, 5)[d]};
          }) > level);
}

TEST_CASE("sampler: sample counts are rounded up to nearly square grids") {
  for (const SamplerKind kind : {SamplerKind::kStratified, SamplerKind::kMultijitter}) {
    for (U n = 1; n < 3000; ++n) {
      const U rounded = rounded_sample_count(kind, n);
      const SampleGrid grid = make_sampler(kind, 0, n).grid;
      CHECK(grid.size() == rounded);
      CHECK(rounded >= n);
      CHECK(grid.rows <= grid.columns);
      CHECK(grid.columns <= 2 * grid.rows);
      CHECK(rounded_sample_count(kind, rounded) == rounded);
    }
    CHECK(rounded_sample_count(kind, 10) == 12);
    CHECK(rounded_sample_count(kind, 64) == 64);
    CHECK(rounded_sample_count(kind, 1u << 24) == 1u << 24);
    CHECK(rounded_sample_count(kind, 0) == 0);
  }
  CHECK(rounded_sample_count(SamplerKind::kSobol, 10) == 10);
  CHECK(rounded_sample_count(SamplerKind::kZSobol, 10) == 16);
  CHECK(rounded_sample_count(SamplerKind::kZSobol, 1u << 24) == 1u << 24);
  CHECK(rounded_sample_count(SamplerKind::kZSobol, 0) == 0);
  CHECK(rounded_sample_count(SamplerKind::kIndependent, 11) == 11);
}

TEST_CASE("sampler: SIMD numbers equal scalar ones to the bit and are at least 0 and less than 1") {
  int wrong = 0;
  for (const SamplerKind kind : kKinds)
    for (const SampleBlock block : kBlocks)
      for (U i = 0; i < 500; ++i) {
        SamplerView sampler = sampler_of(kind, i, 1 + i % 40);
        sampler = sampler_of_replicate(sampler, i % 3, 7);
        const auto pixel = [i](int lane) { return i * 977u + static_cast<U>(lane); };
        const auto sample = [i](int lane) { return 14 + ((i * i) ^ static_cast<U>(lane * 5)); };
        const auto dimension = [i](int lane) { return i % 7u + static_cast<U>(lane % 3); };
        const SampleSet set{i % 5, 1 + i % 5};
        const auto wide = draw<Wide>(sampler, wide_uints(pixel), wide_uints(sample), wide_uints(dimension), block, set);
        for (int lane = 0; lane < kWidth; ++lane) {
          const Numbers one = numbers(sampler, pixel(lane), sample(lane), dimension(lane), block, set);
          const Numbers found = {wide.x[lane], wide.y[lane], wide.z[lane], wide.w[lane]};
          wrong += found != one;
          for (const float x : found) wrong += !(x >= 0.0f && x < 1.0f);
        }
      }
  CHECK(wrong == 0);
}

TEST_CASE("sampler: each number is independent of which others are requested") {
  int wrong = 0;
  for (const SamplerKind kind : kKinds)
    for (const SampleBlock block : kBlocks)
      for (unsigned requested = 1; requested < kAllNumbers; ++requested)
        for (U i = 0; i < 50; ++i) {
          const SamplerView sampler = sampler_of(kind, i, 16);
          // Sample indices above 65536 use the whole sequence.
          const U pixel = 977 * i, sample = i * i * 131, dimension = i % 5;
          const SampleSet set{i % 3, 3};
          const auto one = draw<Scalar>(sampler, pixel, sample, dimension, block, set, requested);
          const auto wide =
              draw<Wide>(sampler, WideUint(pixel), WideUint(sample), WideUint(dimension), block, set, requested);
          const Numbers all = numbers(sampler, pixel, sample, dimension, block, set);
          const Numbers found = {one.x, one.y, one.z, one.w}, in_lane = {wide.x[3], wide.y[3], wide.z[3], wide.w[3]};
          for (unsigned k = 0; k < 4; ++k)
            if ((requested >> k & 1) != 0) wrong += found[k] != all[k] || in_lane[k] != all[k];
        }
  CHECK(wrong == 0);
}

TEST_CASE("sampler: blocks and dimensions never share numbers") {
  for (const SamplerKind kind : kKinds) {
    std::unordered_set<std::uint64_t> seen;
    for (U dimension = 0; dimension < 100; ++dimension)
      for (const SampleBlock block : kBlocks) {
        const Numbers u = numbers(sampler_of(kind, 7, 16), 11, 13, dimension, block);
        seen.insert(static_cast<std::uint64_t>(float_bits(u[1])) << 32 | float_bits(u[2]));
      }
    CHECK(seen.size() == 400);
  }
}

}  // namespace sheaf::test_sampler
