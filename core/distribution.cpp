// Construction of alias tables and CDFs.
#include "core/distribution.h"

#include "core/error.h"

#include <numeric>

namespace sheaf {

namespace {

/// The sum of the weights; throws if one is negative or not finite, or if the sum is not positive.
double checked_sum(std::span<const float> weights) {
  double sum = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (!(weights[i] >= 0.0f) || !std::isfinite(weights[i]))
      throw SceneError("weight " + std::to_string(i) + " of a distribution is " + std::to_string(weights[i]) +
                       ", expected a finite value of at least 0");
    sum += weights[i];
  }
  if (!(sum > 0.0)) throw SceneError("all " + std::to_string(weights.size()) + " weights of a distribution are 0");
  return sum;
}

void check_cdf_size(std::size_t entries) {
  if (entries == 0 || entries > kMaxCdfEntries)
    throw SceneError("a distribution over " + std::to_string(entries) + " values, expected 1 to " +
                     std::to_string(kMaxCdfEntries));
}

/// Writes the CDF of the values to cdf[0 .. values.size()], in multiples of 2^-24. Every positive value gets one step;
/// the other steps are distributed in proportion to the values. If all values are 0, they count as equal.
template <class T> void fill_cdf(std::span<const T> values, float* cdf) {
  constexpr double kSteps = 0x1p24;
  const double sum = std::accumulate(values.begin(), values.end(), 0.0);
  double positive = 0;
  for (const T value : values) positive += value > T(0) || !(sum > 0.0) ? 1.0 : 0.0;
  const double per_value = sum > 0.0 ? (kSteps - positive) / sum : 0.0;
  const double per_positive = sum > 0.0 ? 1.0 : kSteps / positive;

  cdf[0] = 0.0f;
  double so_far = 0, seen = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    so_far += values[i];
    seen += values[i] > T(0) || !(sum > 0.0) ? 1.0 : 0.0;
    cdf[i + 1] =
        seen == positive ? 1.0f : static_cast<float>(std::floor(so_far * per_value + seen * per_positive) / kSteps);
  }
}

}  // namespace

std::vector<AliasEntry> build_alias_table(std::span<const float> weights) {
  const double sum = checked_sum(weights);
  if (weights.size() > 0x7fffffffu) throw SceneError("an alias table of more than 2^31 - 1 weights");
  const auto count = static_cast<std::uint32_t>(weights.size());
  std::vector<double> share(count);  // of each row; 1 is the mean
  std::vector<std::uint32_t> small, large;
  for (std::uint32_t i = 0; i < count; ++i) {
    share[i] = weights[i] / sum * count;
    (share[i] < 1.0 ? small : large).push_back(i);
  }
  std::vector<AliasEntry> table(count);
  const auto probability = [&](std::uint32_t i) { return static_cast<float>(weights[i] / sum); };
  const auto set = [&](std::uint32_t i, double threshold, std::uint32_t alias) {
    table[i] = {static_cast<float>(threshold), alias, probability(i), probability(alias)};
  };
  // Fill each row below the mean with an alias from a row above it.
  while (!small.empty() && !large.empty()) {
    const std::uint32_t low = small.back(), high = large.back();
    small.pop_back();
    set(low, share[low], high);
    share[high] -= 1.0 - share[low];
    if (share[high] < 1.0) {
      large.pop_back();
      small.push_back(high);
    }
  }
  // Rows that rounding leaves over have a share of 1, unless their weight is 0.
  const auto heaviest = static_cast<std::uint32_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
  for (const std::uint32_t i : large) set(i, 1.0, i);
  for (const std::uint32_t i : small) set(i, weights[i] > 0.0f ? 1.0 : 0.0, weights[i] > 0.0f ? i : heaviest);
  return table;
}

Distribution1D::Distribution1D(std::span<const float> values) {
  check_cdf_size(values.size());
  integral_ = checked_sum(values) / static_cast<double>(values.size());
  cdf_.resize(values.size() + 1);
  fill_cdf(values, cdf_.data());
}

Distribution2D::Distribution2D(std::span<const float> values, std::size_t width, std::size_t height)
    : width_(static_cast<std::uint32_t>(width)) {
  check_cdf_size(width);
  check_cdf_size(height);
  if (width * height != values.size())
    throw SceneError("a distribution over " + std::to_string(width) + " x " + std::to_string(height) + " cells has " +
                     std::to_string(values.size()) + " values");
  if ((width + 1) * height > 0x7fffffffu) throw SceneError("a distribution of more than 2^31 - 1 cells");
  integral_ = checked_sum(values) / static_cast<double>(values.size());

  conditional_.resize((width + 1) * height);
  marginal_.resize(height + 1);
  std::vector<double> row_sums(height);
  for (std::size_t y = 0; y < height; ++y) {
    const std::span<const float> row = values.subspan(y * width, width);
    row_sums[y] = std::accumulate(row.begin(), row.end(), 0.0);
    fill_cdf(row, conditional_.data() + y * (width + 1));
  }
  fill_cdf(std::span<const double>(row_sums), marginal_.data());
}

}  // namespace sheaf
