#include "scene/materials/closure_tables.h"

#include "core/color/color.h"
#include "core/color/spectrum_row.h"
#include "core/io/error.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace sheaf {

namespace {

float bits(TableTag tag) { return bits_float(static_cast<std::uint32_t>(tag)); }

/// Normalizes grids to densities. Each slice is divided by its integral and followed by its cumulative integrals along
/// x and over rows. A slice that is all 0 becomes all 1.
std::vector<float> make_warps(const MeasuredBrdf::Grids& grids) {
  const std::size_t w = grids.width, h = grids.height, size = w * h, slices = grids.values.size() / size;
  std::vector<float> out(slices * (2 * size + h));
  std::vector<double> rows(size), sums(h);
  for (std::size_t slice = 0; slice < slices; ++slice) {
    std::vector<float> values(grids.values.begin() + static_cast<std::ptrdiff_t>(slice * size),
                              grids.values.begin() + static_cast<std::ptrdiff_t>((slice + 1) * size));
    if (std::all_of(values.begin(), values.end(), [](float v) { return v == 0.0f; }))
      std::fill(values.begin(), values.end(), 1.0f);
    // Integrate along x, then over rows
    for (std::size_t y = 0; y < h; ++y)
      for (std::size_t x = 0; x < w; ++x) {
        const std::size_t i = y * w + x;
        rows[i] = x == 0 ? 0 : rows[i - 1] + 0.5 * (double(values[i - 1]) + double(values[i]));
      }
    for (std::size_t y = 0; y < h; ++y)
      sums[y] = y == 0 ? 0 : sums[y - 1] + 0.5 * (rows[y * w - 1] + rows[(y + 1) * w - 1]);
    // Divide all by the integral
    const double scale = 1 / sums[h - 1];
    float* to = out.data() + slice * (2 * size + h);
    for (const float value : values) *to++ = static_cast<float>(double(value) * scale);
    for (const double value : rows) *to++ = static_cast<float>(value * scale);
    for (const double value : sums) *to++ = static_cast<float>(value * scale);
  }
  return out;
}

/// Rec.709 color of D65 at a wavelength, up to a factor.
Vec3f daylight_rgb(float lambda) { return xyz_to_rec709(cie_1931_xyz(lambda)) * cie_d65(lambda); }

/// A table under construction: the tag, a header, and blocks of data.
template <template <class> class Head> class TableBuilder {
 public:
  Head<Scalar> head;

  /// Appends data. Returns the number of its first block.
  float append(const std::vector<float>& part) {
    table_.resize((table_.size() + kTableBlock - 1) / kTableBlock * kTableBlock);
    const std::size_t block = table_.size() / kTableBlock;
    if (block >= kMaxTableBlocks) throw SceneError("the tables of the BRDF are too large");
    table_.insert(table_.end(), part.begin(), part.end());
    return static_cast<float>(block);
  }

  std::vector<float> finish(TableTag tag) {
    table_[0] = bits(tag);
    std::size_t k = 1;
    std::apply([&](const auto&... leaf) { ((table_[k++] = leaf), ...); }, leaves(head));
    return std::move(table_);
  }

 private:
  std::vector<float> table_ = std::vector<float>(1 + std::size_t{kLeafCount<Head>});
};

/// Makes a measured BRDF's table, including the tag.
std::vector<float> make_measured_table(const MeasuredBrdf& brdf) {
  TableBuilder<MeasuredHead> table;
  MeasuredHead<Scalar>& head = table.head;
  head.phi_count = static_cast<float>(brdf.phi.size());
  head.theta_count = static_cast<float>(brdf.theta.size());
  head.isotropic = brdf.isotropic() ? 1.0f : 0.0f;
  head.reduction = brdf.isotropic() ? 1.0f : std::rint(2 * kPi / (brdf.phi.back() - brdf.phi.front()));
  head.jacobian = brdf.jacobian ? 1.0f : 0.0f;
  // Set the sizes of the grids
  const auto sides = [](const MeasuredBrdf::Grids& grids, float& width, float& height) {
    width = static_cast<float>(grids.width), height = static_cast<float>(grids.height);
  };
  sides(brdf.ndf, head.ndf_width, head.ndf_height);
  sides(brdf.sigma, head.sigma_width, head.sigma_height);
  sides(brdf.vndf, head.vndf_width, head.vndf_height);
  sides(brdf.luminance, head.sample_width, head.sample_height);
  head.channels = static_cast<float>(brdf.channels);
  // Append the data, with cdfs for sampling
  head.phi_block = table.append(brdf.phi);
  head.theta_block = table.append(brdf.theta);
  head.ndf_block = table.append(brdf.ndf.values);
  head.sigma_block = table.append(brdf.sigma.values);
  head.vndf_block = table.append(make_warps(brdf.vndf));
  head.luminance_block = table.append(make_warps(brdf.luminance));
  head.value_block = table.append(brdf.values.values);
  return table.finish(TableTag::kMeasured);
}

/// Converts the values of slices that hold a grid of `size` values per wavelength to colors.
std::vector<float> values_to_rgb(const std::vector<float>& spectra, const std::vector<float>& wavelengths,
                                 std::size_t size) {
  // Weight of each channel in red, green and blue: the integral of the hat function around its wavelength.
  const std::size_t channels = wavelengths.size();
  const std::vector<float> positions = wavelength_positions(wavelengths);
  std::vector<double> fraction[3], total(3, 0.0);
  for (auto& list : fraction) list.resize(channels);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vec3f rgb = daylight_rgb(kWavelengthMin + static_cast<float>(i));
    const auto low = static_cast<std::size_t>(positions[i]), high = std::min(low + 1, channels - 1);
    const double t = double(positions[i]) - double(low), c[3] = {double(rgb.x), double(rgb.y), double(rgb.z)};
    for (std::size_t k = 0; k < 3; ++k) {
      fraction[k][low] += (1 - t) * c[k], fraction[k][high] += t * c[k];
      total[k] += c[k];
    }
  }
  const std::size_t in = channels * size, slices = spectra.size() / in;
  std::vector<float> values(slices * 3 * size);
  for (std::size_t slice = 0; slice < slices; ++slice)
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t i = 0; i < size; ++i) {
        double sum = 0;
        for (std::size_t c = 0; c < channels; ++c) sum += fraction[k][c] * double(spectra[slice * in + c * size + i]);
        values[(slice * 3 + k) * size + i] = static_cast<float>(std::max(sum / total[k], 0.0));
      }
  return values;
}

}  // namespace

void make_rgb(MeasuredBrdf& brdf) {
  brdf.values.values = values_to_rgb(brdf.values.values, brdf.wavelengths, brdf.values.width * brdf.values.height);
  brdf.channels = 3;
  brdf.wavelengths.clear();
}

void make_rgb(PolarizedBrdf& brdf) {
  brdf.values = values_to_rgb(brdf.values, brdf.wavelengths, brdf.theta_d.size() * brdf.theta_h.size());
  brdf.channels = 3;
  brdf.wavelengths.clear();
}

void select_wavelength(PolarizedBrdf& brdf, float wavelength) {
  const std::vector<float>& nm = brdf.wavelengths;
  const float inside = std::clamp(wavelength, nm.front(), nm.back());
  const auto high = static_cast<std::size_t>(std::lower_bound(nm.begin(), nm.end(), inside) - nm.begin());
  const std::size_t low = high == 0 ? 0 : high - 1, size = brdf.theta_d.size() * brdf.theta_h.size();
  const float t = high == low ? 0 : (inside - nm[low]) / (nm[high] - nm[low]);
  std::vector<float> values(brdf.phi_d.size() * size);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const float* const slice = brdf.values.data() + i / size * brdf.channels * size + i % size;
    values[i] = (1 - t) * slice[low * size] + t * slice[high * size];
  }
  brdf.values = std::move(values);
  brdf.wavelengths = {wavelength};
  brdf.channels = 1;
}

std::vector<float> wavelength_positions(const std::vector<float>& wavelengths) {
  std::vector<float> positions(SpectrumTableView::kSamples);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const float lambda = kWavelengthMin + static_cast<float>(i);
    const auto above = std::upper_bound(wavelengths.begin(), wavelengths.end(), lambda);
    if (above == wavelengths.begin()) continue;
    const auto low = static_cast<std::size_t>(above - wavelengths.begin()) - 1;
    positions[i] = static_cast<float>(low);
    if (above != wavelengths.end()) positions[i] += (lambda - wavelengths[low]) / (*above - wavelengths[low]);
  }
  return positions;
}

const ClosureTables::Measured& ClosureTables::measured(const std::filesystem::path& file, bool spectral) {
  const auto known = known_.find(file.string());
  if (known != known_.end()) return known->second;
  MeasuredBrdf brdf = read_measured(file, spectral);
  if (!spectral && !brdf.wavelengths.empty()) make_rgb(brdf);
  Measured out{measured(brdf), brdf.isotropic(), brdf.wavelengths};
  return known_.emplace(file.string(), std::move(out)).first->second;
}

float ClosureTables::measured(const MeasuredBrdf& brdf) { return add(make_measured_table(brdf)); }

const ClosureTables::Measured& ClosureTables::polarized(const std::filesystem::path& file, float alpha_sample,
                                                        float wavelength, bool spectral) {
  const std::string key = fmt::format("{} {} {}", alpha_sample, wavelength, file.string());
  const auto known = known_.find(key);
  if (known != known_.end()) return known->second;
  PolarizedBrdf brdf = read_polarized_brdf(file);
  if (wavelength >= 0.0f) select_wavelength(brdf, wavelength);
  if (!spectral) make_rgb(brdf);
  Measured out{polarized(brdf, alpha_sample), true, brdf.wavelengths};
  return known_.emplace(key, std::move(out)).first->second;
}

float ClosureTables::polarized(const PolarizedBrdf& brdf, float alpha_sample) {
  TableBuilder<HalfAngleHead> table;
  HalfAngleHead<Scalar>& head = table.head;
  head.alpha = alpha_sample;
  head.phi_count = static_cast<float>(brdf.phi_d.size());
  head.theta_d_count = static_cast<float>(brdf.theta_d.size());
  head.theta_h_count = static_cast<float>(brdf.theta_h.size());
  head.channels = static_cast<float>(brdf.channels);
  head.phi_block = table.append(brdf.phi_d);
  head.theta_d_block = table.append(brdf.theta_d);
  head.theta_h_block = table.append(brdf.theta_h);
  head.value_block = table.append(brdf.values);
  return add(table.finish(TableTag::kHalfAngle));
}

float ClosureTables::phase(std::span<const float> values) {
  const std::size_t n = values.size();
  const double step = 2.0 / static_cast<double>(n - 1);
  std::vector<double> integrals(n);
  for (std::size_t i = 1; i < n; ++i)
    integrals[i] = integrals[i - 1] + 0.5 * step * (double(values[i - 1]) + double(values[i]));
  std::vector<float> table = {bits(TableTag::kPhase), static_cast<float>(n)};
  for (const float value : values) table.push_back(static_cast<float>(double(value) / integrals.back()));
  for (const double integral : integrals) table.push_back(static_cast<float>(integral / integrals.back()));
  return add(table);
}

float ClosureTables::add(const std::vector<float>& table) {
  const auto blocks_of = [](std::size_t size) { return (size + kTableBlock - 1) / kTableBlock; };
  const std::size_t first = std::max(blocks_of(floats_.size()), std::size_t{kFirstTable});
  const std::size_t end = first + blocks_of(table.size());
  if (end > kMaxTableBlocks)
    throw SceneError(fmt::format("all tables of materials and phase functions together take more than {} MiB",
                                 kMaxTableBlocks / 1048576 * kTableBlock * sizeof(float)));
  floats_.resize(first * kTableBlock);
  floats_.insert(floats_.end(), table.begin(), table.end());
  floats_.resize(end * kTableBlock);
  floats_[0] = static_cast<float>(end);
  return static_cast<float>(first);
}

}  // namespace sheaf
