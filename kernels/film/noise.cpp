#include "kernels/film/noise.h"

#include <algorithm>
#include <numeric>

namespace sheaf {

double mean_but_worst(std::vector<double>& values) {
  constexpr double kWorst = 1e-3;
  const auto kept = static_cast<std::ptrdiff_t>(static_cast<double>(values.size()) * (1 - kWorst));
  if (kept == 0) return 0.0;
  std::nth_element(values.begin(), values.begin() + kept, values.end());
  return std::accumulate(values.begin(), values.begin() + kept, 0.0) / static_cast<double>(kept);
}

}  // namespace sheaf
