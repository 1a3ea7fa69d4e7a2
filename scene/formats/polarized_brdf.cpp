#include "scene/formats/polarized_brdf.h"

#include "scene/formats/tensor_file.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

constexpr std::uint64_t kMaxPolarizedSide = 1u << 16;

/// Checks that a field has one list of increasing numbers, from 1 or 2 to kMaxPolarizedSide of them.
std::vector<float> checked_list(const TensorFile& file, const char* name, std::vector<float> numbers,
                                std::size_t min_count) {
  if (numbers.size() < min_count || numbers.size() > kMaxPolarizedSide)
    file.fail(fmt::format("field '{}' has {} numbers, expected {} to {}", name, numbers.size(), min_count,
                          kMaxPolarizedSide));
  if (std::adjacent_find(numbers.begin(), numbers.end(), std::greater_equal<>()) != numbers.end())
    file.fail(fmt::format("field '{}': its numbers do not increase", name));
  return numbers;
}

}  // namespace

PolarizedBrdf read_polarized_brdf(const std::filesystem::path& path) {
  constexpr std::uint64_t kMatrix = 16;
  const TensorFile file(path);
  // Read the axes
  PolarizedBrdf out;
  out.phi_d = checked_list(file, "phi_d", file.floats("phi_d"), 2);
  out.theta_d = checked_list(file, "theta_d", file.floats("theta_d"), 2);
  out.theta_h = checked_list(file, "theta_h", file.floats("theta_h"), 2);
  const std::vector<std::uint16_t> wavelengths = file.shorts("wvls");
  out.wavelengths = checked_list(file, "wvls", {wavelengths.begin(), wavelengths.end()}, 1);
  out.channels = wavelengths.size();
  // Read the first elements of the matrices
  const TensorFile::Shape expected = {out.phi_d.size(), out.theta_d.size(), out.theta_h.size(), out.channels, 4, 4};
  if (const TensorFile::Shape& shape = file.shape("M", expected.size()); shape != expected)
    file.fail(fmt::format("field 'M' has {} numbers, expected {}", to_string(shape), to_string(expected)));
  const std::vector<float> stored = file.every_nth_float("M", kMatrix);
  out.values.resize(stored.size());
  const std::size_t slice = out.theta_d.size() * out.theta_h.size();
  for (std::size_t i = 0; i < stored.size(); ++i) {
    const std::size_t phi = i / (slice * out.channels), at = i / out.channels % slice, channel = i % out.channels;
    if (std::isinf(stored[i])) file.fail("field 'M' has an infinite value");
    out.values[(phi * out.channels + channel) * slice + at] = std::isnan(stored[i]) ? 0.0f : std::max(stored[i], 0.0f);
  }
  return out;
}

}  // namespace sheaf
