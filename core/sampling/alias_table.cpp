// Construction of alias tables.
#include "core/sampling/alias_table.h"

#include "core/io/error.h"

#include <fmt/format.h>

namespace sheaf {

namespace {

/// The sum of the weights; throws if one is negative or not finite, or if the sum is not positive.
double checked_sum(std::span<const float> weights) {
  double sum = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (!(weights[i] >= 0.0f) || !std::isfinite(weights[i]))
      throw SceneError(
          fmt::format("weight {} of a distribution is {}, expected a finite value of at least 0", i, weights[i]));
    sum += weights[i];
  }
  if (!(sum > 0.0)) throw SceneError(fmt::format("all {} weights of a distribution are 0", weights.size()));
  return sum;
}

}  // namespace

std::vector<AliasEntry> build_alias_table(std::span<const float> weights) {
  const double sum = checked_sum(weights);
  if (weights.size() > 0x7fffffffu) throw SceneError("an alias table is limited to 2^31 - 1 weights");
  const auto count = static_cast<std::uint32_t>(weights.size());
  std::vector<double> fraction(count);  // of each row; 1 is the mean
  std::vector<std::uint32_t> small, large;
  for (std::uint32_t i = 0; i < count; ++i) {
    fraction[i] = weights[i] / sum * count;
    (fraction[i] < 1.0 ? small : large).push_back(i);
  }
  std::vector<AliasEntry> table(count);
  const auto probability = [&](std::uint32_t i) { return static_cast<float>(weights[i] / sum); };
  const auto set = [&](std::uint32_t i, double threshold, std::uint32_t alias) {
    table[i] = {static_cast<float>(threshold), alias, probability(i), probability(alias)};
  };
  // Fill each row below the mean with an alias from a row above it
  while (!small.empty() && !large.empty()) {
    const std::uint32_t low = small.back(), high = large.back();
    small.pop_back();
    set(low, fraction[low], high);
    fraction[high] -= 1.0 - fraction[low];
    if (fraction[high] < 1.0) {
      large.pop_back();
      small.push_back(high);
    }
  }
  // Rows left over due to rounding have a fraction of 1, unless their weight is 0.
  const auto heaviest = static_cast<std::uint32_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
  for (const std::uint32_t i : large) set(i, 1.0, i);
  for (const std::uint32_t i : small) set(i, weights[i] > 0.0f ? 1.0 : 0.0, weights[i] > 0.0f ? i : heaviest);
  return table;
}

}  // namespace sheaf
