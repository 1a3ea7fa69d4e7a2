// Compiles spectra into rows and tables.
#include "scene/spectra/spectrum_set.h"

#include "core/color/color.h"
#include "core/color/uplift.h"
#include "core/io/error.h"
#include "scene/data/illuminants.h"
#include "scene/description/spectrum_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>

namespace sheaf {

namespace {

constexpr std::uint32_t kNoTable = SpectrumTableView::kNone, kDaylightTable = SpectrumTableView::kDaylight;

SpectrumRow flat(float value, std::uint32_t table = kNoTable) {
  SpectrumRow row;
  row.scale = value;
  row.table = table;
  return row;
}

SpectrumRow colored(const ScaledSigmoid<Scalar>& s, std::uint32_t table = kNoTable) {
  SpectrumRow row = flat(s.scale, table);
  row.c0 = s.shape.c0, row.c1 = s.shape.c1, row.c2 = s.shape.c2;
  return row;
}

float limited(float value, SpectrumUse use) {
  return std::clamp(value, 0.0f, use == SpectrumUse::kReflectance ? 1.0f : std::numeric_limits<float>::max());
}

void check_finite(float value) {
  if (!std::isfinite(value)) throw SceneError(fmt::format("a spectrum contains {} (expected finite numbers)", value));
}

SpectrumRow color_row(Vec3f rgb, SpectrumUse use) {
  for (const float c : {rgb.x, rgb.y, rgb.z}) check_finite(c);
  switch (use) {
    case SpectrumUse::kReflectance:
      return colored(fit_reflectance(rgb));
    case SpectrumUse::kIlluminant:
      return colored(fit_unbounded(rgb), kDaylightTable);
    case SpectrumUse::kUnbounded: {
      // Colors in the range of reflectances get the smoother reflectance spectrum, as in Mitsuba.
      const bool bounded = std::min({rgb.x, rgb.y, rgb.z}) >= 0.0f && std::max({rgb.x, rgb.y, rgb.z}) <= 1.0f;
      return colored(bounded ? fit_reflectance(rgb) : fit_unbounded(rgb));
    }
    case SpectrumUse::kRaw:
      break;
  }
  return flat(luminance(rgb));
}

std::vector<float> sample_blackbody(const SpectrumDescription::Blackbody& body) {
  check_finite(body.scale);
  check_finite(body.temperature);
  std::vector<float> samples(SpectrumTableView::kSamples);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double wavelength = static_cast<double>(kWavelengthMin) + static_cast<double>(i);
    const double radiance = blackbody_radiance(wavelength, static_cast<double>(body.temperature));
    samples[i] = limited(static_cast<float>(radiance * static_cast<double>(body.scale)), SpectrumUse::kIlluminant);
  }
  return samples;
}

/// Integral over [a, b] of table(x) * hat(x), with a hat function that is 1 at `center` and 0 at a distance of 1 nm.
/// [a, b] lies on one side of the center, so the product is quadratic in each segment and Simpson's rule is exact.
double integrate_under_hat(const SpectrumDescription::Table& table, double a, double b, double center) {
  const std::vector<float>& x = table.wavelengths;
  const auto before = [](double v, float entry) { return v < static_cast<double>(entry); };
  const auto above = std::upper_bound(x.begin(), x.end(), a, before);
  double sum = 0;
  for (auto i = static_cast<std::size_t>(std::max(above - x.begin(), std::ptrdiff_t{1}) - 1); i + 1 < x.size(); ++i) {
    const double x0 = static_cast<double>(x[i]), x1 = static_cast<double>(x[i + 1]);
    if (x0 >= b) break;
    const double from = std::max(a, x0), to = std::min(b, x1);
    const auto product = [&](double at) {
      const double t = (at - x0) / (x1 - x0);
      const double y0 = static_cast<double>(table.values[i]), y1 = static_cast<double>(table.values[i + 1]);
      return ((1 - t) * y0 + t * y1) * (1 - std::fabs(at - center));
    };
    if (to > from) sum += (to - from) / 6 * (product(from) + 4 * product(0.5 * (from + to)) + product(to));
  }
  return sum;
}

}  // namespace

std::vector<float> resample(const SpectrumDescription::Table& table) {
  check_table(table, {});
  for (const auto* list : {&table.wavelengths, &table.values}) std::for_each(list->begin(), list->end(), check_finite);
  std::vector<float> samples(SpectrumTableView::kSamples);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double center = static_cast<double>(kWavelengthMin) + static_cast<double>(i);
    double sum = 0, weight = 0;
    if (i > 0) sum += integrate_under_hat(table, center - 1, center, center), weight += 0.5;
    if (i + 1 < samples.size()) sum += integrate_under_hat(table, center, center + 1, center), weight += 0.5;
    samples[i] = static_cast<float>(sum / weight);
  }
  return samples;
}

SpectrumSet::SpectrumSet() : samples_(SpectrumTableView::kStride, 1.0f) { tabulate(find_illuminant("d65")->values); }

SpectrumRow SpectrumSet::tabulate(std::vector<float> samples) {
  samples.resize(SpectrumTableView::kSamples);
  const auto next = static_cast<std::uint32_t>(samples_.size() / SpectrumTableView::kStride);
  const auto [found, inserted] = known_.try_emplace(std::move(samples), next);
  if (inserted) {
    samples_.insert(samples_.end(), found->first.begin(), found->first.end());
    samples_.resize(samples_.size() + SpectrumTableView::kStride - SpectrumTableView::kSamples);
  }
  return flat(1.0f, found->second);
}

SpectrumRow SpectrumSet::row(const SpectrumDescription& spectrum, SpectrumUse use) {
  using S = SpectrumDescription;
  if (const auto* constant = std::get_if<S::Constant>(&spectrum.value)) {
    check_finite(constant->value);
    return flat(limited(constant->value, use), use == SpectrumUse::kIlluminant ? kDaylightTable : kNoTable);
  }
  if (const auto* rgb = std::get_if<S::Rgb>(&spectrum.value)) return color_row(rgb->value, use);
  if (const auto* body = std::get_if<S::Blackbody>(&spectrum.value)) return tabulate(sample_blackbody(*body));
  std::vector<float> samples = resample(std::get<S::Table>(spectrum.value));
  for (float& value : samples) value = limited(value, use);
  const bool constant = std::all_of(samples.begin(), samples.end(), [&](float v) { return v == samples[0]; });
  return constant ? flat(samples[0]) : tabulate(std::move(samples));
}

SpectrumRow dispersion_row(SpectrumSet& set, const Dispersion& dispersion) {
  std::vector<float> samples(SpectrumTableView::kSamples);
  for (std::size_t i = 0; i < samples.size(); ++i)
    samples[i] = ior<Scalar>(dispersion, kWavelengthMin + static_cast<float>(i));
  return set.tabulate(std::move(samples));
}

}  // namespace sheaf
