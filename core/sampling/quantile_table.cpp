// Construction of tables of quantiles.
#include "core/sampling/quantile_table.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// A run of entries of one quantile, or one entry with its quantiles.
struct Span {
  std::uint32_t first, run, quantiles;
  double weight;
};

/// The variance that a run costs because its entries have equal probabilities, in units of weight: n sum w^2 / sum w,
/// the second moment of weight over probability, minus that of proportional sampling.
double cost_of_run(double n, double sum, double squares) { return n * squares / sum - sum; }

/// The longest run of low cost that begins at `first`, whose weight is positive. It ends at a positive weight.
Span run_from(std::span<const double> weights, std::size_t first, double fraction) {
  // Maximum cost of a run, as a fraction of the weight of a quantile.
  constexpr double kCost = 0.25;
  double sum = weights[first], squares = sum * sum;
  Span run{static_cast<std::uint32_t>(first), 1, 1, sum};
  for (std::uint32_t n = 2; n <= kMaxQuantileRun && first + n <= weights.size(); ++n) {
    const double w = weights[first + n - 1];
    sum += w;
    squares += w * w;
    if (sum > fraction || cost_of_run(n, sum, squares) > kCost * fraction) break;
    if (w > 0) run.run = n, run.weight = sum;
  }
  if (run.run == 1)
    run.quantiles = static_cast<std::uint32_t>(std::clamp(std::round(run.weight / fraction), 1.0, double(kQuantiles)));
  return run;
}

/// Cuts the weights into spans, with a weight of about `fraction` per quantile. Returns the number of quantiles.
std::size_t cut(std::span<const double> weights, double fraction, std::vector<Span>& spans) {
  spans.clear();
  std::size_t quantiles = 0;
  for (std::size_t i = 0; i < weights.size();) {
    if (!(weights[i] > 0)) {
      ++i;
      continue;
    }
    spans.push_back(run_from(weights, i, fraction));
    quantiles += spans.back().quantiles;
    i += spans.back().run;
  }
  return quantiles;
}

/// Finds the spans for the smallest weight per quantile that fits into kQuantiles, by bisection.
std::vector<Span> cut_to_fit(std::span<const double> weights, double total) {
  std::vector<Span> spans, best;
  // For any weights, runs above some share end only at their maximum length, so doubling ends.
  double fits = total / kQuantiles, too_small = 0;
  std::size_t quantiles = cut(weights, fits, spans);
  while (quantiles > kQuantiles) {
    too_small = fits;
    fits *= 2;
    quantiles = cut(weights, fits, spans);
  }
  best = spans;
  for (int step = 0; step < 12 && quantiles < kQuantiles; ++step) {
    const double middle = 0.5 * (too_small + fits);
    const std::size_t found = cut(weights, middle, spans);
    (found <= kQuantiles ? fits : too_small) = middle;
    if (found <= kQuantiles) best = spans, quantiles = found;
  }
  return best;
}

/// Distributes the remaining quantiles to the spans with the most weight per quantile: an entry gets one more, and a
/// run is split in two.
void give_rest(std::span<const double> weights, std::vector<Span>& spans) {
  std::size_t taken = 0;
  const auto less = [](const Span& a, const Span& b) { return a.weight * b.quantiles < b.weight * a.quantiles; };
  for (const Span& span : spans) taken += span.quantiles;
  std::make_heap(spans.begin(), spans.end(), less);
  while (taken < kQuantiles) {
    std::pop_heap(spans.begin(), spans.end(), less);
    Span& largest = spans.back();
    ++taken;
    if (largest.run == 1) {
      ++largest.quantiles;
    } else {
      // Runs begin and end at positive weights, so both halves have a positive weight.
      const std::uint32_t half = largest.run / 2, middle = largest.first + half;
      Span rest{middle, largest.run - half, 1, 0};
      for (std::uint32_t i = middle; i < middle + rest.run; ++i) rest.weight += weights[i];
      largest.run = half;
      largest.weight = std::max(largest.weight - rest.weight, 0.0);
      spans.push_back(rest);
      std::push_heap(spans.begin(), spans.end() - 1, less);
    }
    std::push_heap(spans.begin(), spans.end(), less);
  }
  std::sort(spans.begin(), spans.end(), [](const Span& a, const Span& b) { return a.first < b.first; });
}

/// Writes the quantiles of a span. Returns the position of the next ones.
Quantile* write(const Span& span, Quantile* table) {
  if (span.run > 1) {
    *table = Quantile::of_run(span.first, span.run);
    return table + 1;
  }
  for (std::uint32_t i = 0; i < span.quantiles; ++i) *table++ = Quantile::of_part(span.first, i);
  return table;
}

}  // namespace

bool build_quantiles(std::span<double> weights, Quantile* table) {
  double total = 0;
  for (const double w : weights) total += w;
  if (!(total > 0)) return false;
  std::vector<Span> spans = cut_to_fit(weights, total);
  give_rest(weights, spans);
  std::fill(weights.begin(), weights.end(), 0.0);
  for (const Span& span : spans) {
    const double probability = static_cast<double>(span.quantiles) / (double(kQuantiles) * span.run);
    std::fill_n(weights.begin() + span.first, span.run, probability);
    table = write(span, table);
  }
  return true;
}

}  // namespace sheaf
