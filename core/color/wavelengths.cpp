// Tabulation of the quantiles of the pdf of wavelengths.
#include "core/color/wavelengths.h"

#include "core/color/color.h"

#include <array>

namespace sheaf {

namespace {

/// The pdf at 360, 370, ... 830 nm, linear in between, not normalized; computed by tools/color/fit_wavelengths.py.
constexpr int kKnots = 48;
constexpr std::array<float, kKnots> kDensity{
    0.0144f, 0.0147f, 0.0259f, 0.0565f, 0.2019f, 0.4095f, 0.7560f, 0.9349f, 1.0000f, 0.9842f, 0.8598f, 0.7469f,
    0.6570f, 0.5504f, 0.5698f, 0.6546f, 0.7124f, 0.7392f, 0.7317f, 0.7153f, 0.6955f, 0.6948f, 0.7320f, 0.7679f,
    0.8217f, 0.8674f, 0.7808f, 0.7539f, 0.7746f, 0.7679f, 0.7344f, 0.6220f, 0.4628f, 0.2879f, 0.2114f, 0.1346f,
    0.0850f, 0.0505f, 0.0262f, 0.0161f, 0.0128f, 0.0070f, 0.0053f, 0.0044f, 0.0032f, 0.0023f, 0.0017f, 0.0012f};
constexpr double kKnotStep = (static_cast<double>(kWavelengthMax) - static_cast<double>(kWavelengthMin)) / (kKnots - 1);

double density(double lambda) {
  const double position = (lambda - static_cast<double>(kWavelengthMin)) / kKnotStep;
  const std::size_t i = std::min(static_cast<std::size_t>(position), kDensity.size() - 2);
  const double t = position - static_cast<double>(i);
  return (1 - t) * static_cast<double>(kDensity[i]) + t * static_cast<double>(kDensity[i + 1]);
}

}  // namespace

WavelengthQuantiles::WavelengthQuantiles() : nodes{} {
  constexpr int kSteps = 4700;  // of 0.1 nm
  constexpr double kLow = kWavelengthMin, kStep = 0.1;
  std::array<double, kSteps + 1> cumulative{};
  for (std::size_t i = 0; i < kSteps; ++i)
    cumulative[i + 1] = cumulative[i] + kStep * density(kLow + kStep * (static_cast<double>(i) + 0.5));
  std::size_t i = 0;
  for (int node = 0; node < 4 * kCells; ++node) {
    const double goal = cumulative.back() * node / (4 * kCells);
    while (cumulative[i + 1] <= goal) ++i;
    const double part = (goal - cumulative[i]) / (cumulative[i + 1] - cumulative[i]);
    nodes[node % kCells][node / kCells] = static_cast<float>(kLow + kStep * (static_cast<double>(i) + part));
  }
  for (int k = 0; k < 3; ++k) nodes[kCells][k] = nodes[0][k + 1];
  nodes[kCells][3] = kWavelengthMax;
}

const WavelengthQuantiles kWavelengthQuantiles;

}  // namespace sheaf
