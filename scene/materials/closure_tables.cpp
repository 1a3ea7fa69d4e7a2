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

/// Makes a measured BRDF's table, including the tag.
std::vector<float> make_measured_table(const MeasuredBrdf& brdf) {
  MeasuredHead<Scalar> head;
  std::vector<float> table(1 + std::size_t{kLeafCount<MeasuredHead>});
  const auto append = [&table](const std::vector<float>& part) {
    table.resize((table.size() + kTableBlock - 1) / kTableBlock * kTableBlock);
    const std::size_t block = table.size() / kTableBlock;
    if (block >= kMaxTableBlocks) throw SceneError("the tables of the BRDF are too large");
    table.insert(table.end(), part.begin(), part.end());
    return static_cast<float>(block);
  };
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
  head.phi_block = append(brdf.phi);
  head.theta_block = append(brdf.theta);
  head.ndf_block = append(brdf.ndf.values);
  head.sigma_block = append(brdf.sigma.values);
  head.vndf_block = append(make_warps(brdf.vndf));
  head.luminance_block = append(make_warps(brdf.luminance));
  head.value_block = append(brdf.values.values);
  // Write the head
  table[0] = bits(TableTag::kMeasured);
  std::size_t k = 1;
  std::apply([&](const auto&... leaf) { ((table[k++] = leaf), ...); }, leaves(head));
  return table;
}

}  // namespace

void make_rgb(MeasuredBrdf& brdf) {
  // Weight of each channel in red, green and blue: the integral of the hat function around its wavelength.
  const std::vector<float> positions = wavelength_positions(brdf.wavelengths);
  std::vector<double> fraction[3], total(3, 0.0);
  for (auto& list : fraction) list.resize(brdf.channels);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vec3f rgb = daylight_rgb(kWavelengthMin + static_cast<float>(i));
    const auto low = static_cast<std::size_t>(positions[i]), high = std::min(low + 1, brdf.channels - 1);
    const double t = double(positions[i]) - double(low), c[3] = {double(rgb.x), double(rgb.y), double(rgb.z)};
    for (std::size_t k = 0; k < 3; ++k) {
      fraction[k][low] += (1 - t) * c[k], fraction[k][high] += t * c[k];
      total[k] += c[k];
    }
  }
  const std::size_t size = brdf.values.width * brdf.values.height, in = brdf.channels * size;
  std::vector<float> values(brdf.phi.size() * brdf.theta.size() * 3 * size);
  for (std::size_t slice = 0; slice < brdf.phi.size() * brdf.theta.size(); ++slice)
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t i = 0; i < size; ++i) {
        double sum = 0;
        for (std::size_t c = 0; c < brdf.channels; ++c)
          sum += fraction[k][c] * double(brdf.values.values[slice * in + c * size + i]);
        values[(slice * 3 + k) * size + i] = static_cast<float>(std::max(sum / total[k], 0.0));
      }
  brdf.values.values = std::move(values);
  brdf.channels = 3;
  brdf.wavelengths.clear();
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
