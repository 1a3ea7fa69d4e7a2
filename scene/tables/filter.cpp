#include "scene/tables/filter.h"

#include <cmath>
#include <cstdio>
#include <vector>

namespace sheaf {

namespace {

constexpr double kPiD = 3.14159265358979323846;

/// Cubic filters (Mitchell and Netravali, "Reconstruction Filters in Computer Graphics", 1988, equation 8).
double cubic(double x, double b, double c) {
  const double x2 = x * x, x3 = x2 * x;
  if (x < 1) return ((12 - 9 * b - 6 * c) * x3 + (-18 + 12 * b + 6 * c) * x2 + (6 - 2 * b)) / 6;
  if (x < 2) return ((-b - 6 * c) * x3 + (6 * b + 30 * c) * x2 + (-12 * b - 48 * c) * x + (8 * b + 24 * c)) / 6;
  return 0;
}

double checked_radius(const PixelFilter& filter) {
  const double radius = filter_radius(filter);
  check_filter_radius(radius, {});
  return radius;
}

double sinc(double x) { return x < 1e-5 ? 1.0 : std::sin(kPiD * x) / (kPiD * x); }

}  // namespace

void check_filter_radius(double radius, const SourceLocation& where) {
  if (radius > 0 && radius <= kMaxFilterRadius) return;
  char message[160];
  std::snprintf(message, sizeof(message),
                "the reconstruction filter has a radius of %g pixels, expected one above 0 and at most %g", radius,
                kMaxFilterRadius);
  throw SceneError(where, message);
}

double filter_radius(const PixelFilter& f) {
  using Kind = PixelFilter::Kind;
  switch (f.kind) {
    case Kind::kBox:
    case Kind::kTent:
      return f.radius;
    case Kind::kGaussian:
      return 4.0 * f.stddev;
    case Kind::kMitchell:
    case Kind::kCatmullRom:
      return 2.0;
    case Kind::kLanczos:
      return f.lobes;
  }
  return f.radius;
}

double evaluate_filter(const PixelFilter& f, double x) {
  x = std::fabs(x);
  const double radius = filter_radius(f);
  if (x > radius) return 0;
  using Kind = PixelFilter::Kind;
  switch (f.kind) {
    case Kind::kBox:
      return 1;
    case Kind::kTent:
      return 1 - x / radius;
    case Kind::kGaussian: {
      const double alpha = -0.5 / (double(f.stddev) * f.stddev);
      return std::max(0.0, std::exp(alpha * x * x) - std::exp(alpha * radius * radius));
    }
    case Kind::kMitchell:
      return cubic(x, f.b, f.c);
    case Kind::kCatmullRom:
      return cubic(x, 0, 0.5);
    case Kind::kLanczos:
      return sinc(x) * sinc(x / radius);
  }
  return 0;
}

FilterTable make_filter_table(const PixelFilter& filter) {
  const double radius = checked_radius(filter);
  FilterTable table;
  if (filter.kind == PixelFilter::Kind::kBox) {
    table.box_radius = static_cast<float>(radius);
    return table;
  }
  constexpr int kSteps = FilterTable::kBins * 64;
  const auto position = [radius](double i) { return radius * (2.0 * i / kSteps - 1.0); };
  std::vector<double> cumulative(kSteps + 1, 0.0), signed_cumulative(kSteps + 1, 0.0);
  for (int i = 0; i < kSteps; ++i) {
    const double f = evaluate_filter(filter, position(i + 0.5));
    cumulative[i + 1] = cumulative[i] + std::fabs(f);
    signed_cumulative[i + 1] = signed_cumulative[i] + f;
  }
  const double total = cumulative[kSteps], integral = signed_cumulative[kSteps];
  int step = 0;
  double previous = 0;  // signed integral up to the last edge
  for (int bin = 0; bin <= FilterTable::kBins; ++bin) {
    const double target = total * bin / FilterTable::kBins;
    while (step < kSteps - 1 && cumulative[step + 1] < target) ++step;
    const double width = cumulative[step + 1] - cumulative[step];
    const double t = width > 0 ? std::clamp((target - cumulative[step]) / width, 0.0, 1.0) : 0.0;
    table.edges[bin] = static_cast<float>(position(step + t));
    const double up_to = signed_cumulative[step] + t * (signed_cumulative[step + 1] - signed_cumulative[step]);
    // If f changes sign inside a bin, the weight is the mean of both signs.
    if (bin > 0) table.weight[bin - 1] = static_cast<float>((up_to - previous) * FilterTable::kBins / integral);
    previous = up_to;
  }
  return table;
}

FilterTable make_placement_table(const PixelFilter& filter) {
  PixelFilter box;
  box.radius = static_cast<float>(std::min(checked_radius(filter), 0.5));
  return make_filter_table(box);
}

int filter_reach(const PixelFilter& filter) {
  return std::max(0, static_cast<int>(std::ceil(checked_radius(filter) - 0.5)));
}

FilterWeights::FilterWeights(const PixelFilter& filter) {
  const double radius = checked_radius(filter), middle = evaluate_filter(filter, 0);
  radius_ = static_cast<float>(radius);
  reach_ = filter_reach(filter);
  length_ = (2 * reach_ + kRegister) / kRegister * kRegister;
  for (int step = 0; step <= kSteps; ++step)
    for (int k = 0; k < length_; ++k) {
      // Clamp to the radius: values just before a jump to zero must not be interpolated with zero.
      const double x = std::fabs(k - reach_ + 0.5 - static_cast<double>(step) / kSteps);
      values_.push_back(static_cast<float>(evaluate_filter(filter, std::min(x, radius)) / middle));
    }
}

}  // namespace sheaf
