// Basis spectra for linear spectral upsampling, after Mallett and Yuksel 2019.
#include "scene/data/rgb_basis.h"

#include <cstddef>
#include <iterator>

namespace sheaf {

namespace {

// At 360, 370, ... 830 nm.
constexpr float kRed[] = {0.0f,      0.024764f, 0.047268f, 0.065261f, 0.07652f, 0.078931f, 0.070846f, 0.052194f,
                          0.0272f,   0.007064f, 0.004222f, 0.000082f, 0.0f,     0.0f,      0.0f,      0.0f,
                          0.0f,      0.0f,      0.0f,      0.0f,      0.0f,     0.0333f,   0.199151f, 0.465271f,
                          0.737882f, 0.927813f, 1.0f,      1.0f,      1.0f,     1.0f,      1.0f,      1.0f,
                          1.0f,      1.0f,      1.0f,      1.0f,      1.0f,     1.0f,      1.0f,      1.0f,
                          1.0f,      1.0f,      1.0f,      1.0f,      1.0f,     1.0f,      1.0f,      1.0f};
constexpr float kBlue[] = {1.0f,      0.975236f, 0.952732f, 0.934739f, 0.92348f,  0.921069f, 0.929154f, 0.947806f,
                           0.9728f,   0.992936f, 0.98543f,  0.896546f, 0.720091f, 0.49435f,  0.272054f, 0.102446f,
                           0.014472f, 0.0f,      0.0f,      0.0f,      0.004213f, 0.037009f, 0.050696f, 0.038774f,
                           0.016321f, 0.001215f, 0.0f,      0.0f,      0.0f,      0.0f,      0.0f,      0.0f,
                           0.0f,      0.0f,      0.0f,      0.0f,      0.0f,      0.0f,      0.0f,      0.0f,
                           0.0f,      0.0f,      0.0f,      0.0f,      0.0f,      0.0f,      0.0f,      0.0f};
constexpr std::size_t kStep = 10, kSamples = (std::size(kRed) - 1) * kStep + 1;
static_assert(std::size(kRed) == std::size(kBlue) && kSamples == 471);

float at(const float* knots, std::size_t i) {
  const std::size_t low = i / kStep, rest = i % kStep;
  if (rest == 0) return knots[low];
  const float t = static_cast<float>(rest) / kStep;
  return (1 - t) * knots[low] + t * knots[low + 1];
}

}  // namespace

std::vector<float> rgb_basis(int channel) {
  std::vector<float> samples(kSamples);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const float red = at(kRed, i), blue = at(kBlue, i);
    samples[i] = channel == 0 ? red : channel == 2 ? blue : 1 - red - blue;
  }
  return samples;
}

}  // namespace sheaf
