// Tables of an analytic BRDF in the format of measured BRDFs: GGX facets, tabulated by the definitions of Dupuy and
// Jakob 2018.
#pragma once

#include "core/math/vec.h"
#include "core/sampling/warp.h"
#include "kernels/bsdf/table_warp.h"
#include "scene/materials/closure_tables.h"
#include "tests/support/temporary_folder.h"

#include <array>
#include <bit>
#include <cmath>
#include <vector>

namespace sheaf {

/// GGX facets with Smith's uncorrelated masking. Each facet is a mirror of reflectance base + slope * cos^2 of the
/// incident angle; the base differs between channels.
struct TabulatedFacets {
  double alpha_u = 0.4, alpha_v = 0.4;
  std::vector<float> phi = {0}, theta = {0.0f, 0.3f, 0.6f, 0.9f, 1.2f, 1.5f};
  std::size_t side = 24, sample_side = 16, channels = 3;
  bool jacobian = true;

  double ndf(Vec3f m) const {
    if (m.z <= 0) return 0;
    const double x = m.x / alpha_u, y = m.y / alpha_v, z = m.z, s = x * x + y * y + z * z;
    return 1 / (3.141592653589793 * alpha_u * alpha_v * s * s);
  }
  double masking(Vec3f w) const {
    const double x = alpha_u * w.x, y = alpha_v * w.y, z = w.z;
    return z <= 0 ? 0 : 2 / (1 + std::sqrt(1 + (x * x + y * y) / (z * z)));
  }
  double sigma(Vec3f w) const { return w.z <= 0 ? 0.5 * alpha_u : w.z / masking(w); }
  double reflectance(std::size_t channel, double cosine) const {
    return 0.2 + 0.6 * double(channel + 1) / double(channels) - 0.15 * cosine * cosine;
  }
  /// BRDF times the cosine of `wi`.
  double f_cos(std::size_t channel, Vec3f wo, Vec3f wi) const {
    if (wo.z <= 0 || wi.z <= 0) return 0;
    const Vec3f m = normalize(wo + wi);
    return ndf(m) * masking(wo) * masking(wi) * reflectance(channel, dot(wo, m)) / (4 * wo.z);
  }

  MeasuredBrdf tabulate() const;
};

inline Vec3f direction_at(double theta, double phi) {
  return {static_cast<float>(std::sin(theta) * std::cos(phi)), static_cast<float>(std::sin(theta) * std::sin(phi)),
          static_cast<float>(std::cos(theta))};
}

namespace detail {

/// Tabulates f(direction) on a grid with elevation pi x^2 / 2 and azimuth (2 y - 1) pi.
template <class F> MeasuredBrdf::Grids directional_grid(std::size_t side, F&& f) {
  MeasuredBrdf::Grids out{side, side, {}};
  for (std::size_t y = 0; y < side; ++y)
    for (std::size_t x = 0; x < side; ++x) {
      const double u = double(x) / double(side - 1), v = double(y) / double(side - 1);
      out.values.push_back(static_cast<float>(f(direction_at(u * u * kPi / 2, (2 * v - 1) * kPi), u)));
    }
  return out;
}

}  // namespace detail

inline MeasuredBrdf TabulatedFacets::tabulate() const {
  MeasuredBrdf out;
  out.phi = phi, out.theta = theta, out.channels = channels, out.jacobian = jacobian;
  out.ndf = detail::directional_grid(side * 2, [&](Vec3f m, double) { return ndf(m); });
  out.sigma = detail::directional_grid(side * 2, [&](Vec3f m, double) { return sigma(m); });
  out.vndf.width = out.vndf.height = side;
  for (auto* grids : {&out.luminance, &out.values}) grids->width = grids->height = sample_side;
  const std::size_t size = sample_side * sample_side;
  for (const float p : phi)
    for (const float t : theta) {
      const Vec3f wo = direction_at(double(t), double(p));
      const auto slice = detail::directional_grid(side, [&](Vec3f m, double u) {
        return ndf(m) * std::max(double(dot(wo, m)), 0.0) * u * std::sqrt(double(m.x * m.x + m.y * m.y));
      });
      out.vndf.values.insert(out.vndf.values.end(), slice.values.begin(), slice.values.end());
      // Sampled directions, by a table of this slice alone.
      MeasuredBrdf alone = out;
      alone.phi = alone.theta = {0}, alone.channels = 1, alone.vndf = slice;
      alone.luminance.values = alone.values.values = std::vector<float>(size, 1.0f);
      ClosureTables tables;
      const std::uint32_t first = static_cast<std::uint32_t>(tables.measured(alone)) * kTableBlock;
      const std::vector<float> floats = tables.take();
      const auto head = load_table_record<Scalar, MeasuredHead>(floats.data(), first + 1);
      const Neighbors<Scalar> only{0, 0, 0};
      const auto n = static_cast<std::uint32_t>(side);
      const TableWarp<Scalar> warp(floats.data(), first + static_cast<std::uint32_t>(head.vndf_block) * kTableBlock, n,
                                   n, {only, only, 1});
      std::vector<float> values(channels * size), luminance(size);
      for (std::size_t i = 0; i < size; ++i) {
        const double last = double(sample_side - 1);
        const std::size_t column = i % sample_side, row = i / sample_side;
        const auto at = warp.sample(static_cast<float>(double(column) / last), static_cast<float>(double(row) / last));
        const Vec3f m = direction_at(double(at.x * at.x) * kPi / 2, (2 * double(at.y) - 1) * kPi);
        const Vec3f wi = m * (2 * dot(wo, m)) - wo;
        const double scale = jacobian ? 1 : ndf(m) / (4 * sigma(wo));
        for (std::size_t c = 0; c < channels; ++c) {
          const double value = masking(wi) * reflectance(c, double(dot(wo, m)));
          values[c * size + i] = static_cast<float>(value * scale);
          luminance[i] += static_cast<float>(value / double(channels));
        }
      }
      out.values.values.insert(out.values.values.end(), values.begin(), values.end());
      out.luminance.values.insert(out.luminance.values.end(), luminance.begin(), luminance.end());
    }
  if (channels != 3)
    for (std::size_t c = 0; c < channels; ++c)
      out.wavelengths.push_back(static_cast<float>(360 + 470 * double(c) / double(channels - 1)));
  return out;
}

/// A field of a tensor file: its name, type number, dimensions and bytes.
struct TensorField {
  std::string name;
  std::uint8_t type = 10;
  std::vector<std::uint64_t> shape;
  std::string bytes;
};

inline TensorField tensor_field(std::string name, std::vector<std::uint64_t> shape, const std::vector<float>& values) {
  std::string bytes(values.size() * sizeof(float), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return {std::move(name), 10, std::move(shape), std::move(bytes)};
}

/// The bytes of a tensor file, on a little-endian machine.
inline std::string tensor_bytes(const std::vector<TensorField>& fields) {
  std::string out("tensor_file\0\1\0", 14);
  const auto put = [&out]<class T>(T number) { out.append(reinterpret_cast<const char*>(&number), sizeof(T)); };
  put(static_cast<std::uint32_t>(fields.size()));
  std::uint64_t offset = out.size();
  for (const TensorField& f : fields) offset += 2 + f.name.size() + 2 + 1 + 8 + 8 * f.shape.size();
  for (const TensorField& f : fields) {
    put(static_cast<std::uint16_t>(f.name.size()));
    out += f.name;
    put(static_cast<std::uint16_t>(f.shape.size()));
    put(f.type);
    put(offset);
    for (const std::uint64_t side : f.shape) put(side);
    offset += f.bytes.size();
  }
  for (const TensorField& f : fields) out += f.bytes;
  return out;
}

/// The fields of a measured BRDF file.
inline std::vector<TensorField> measured_fields(const MeasuredBrdf& b) {
  const std::uint64_t p = b.phi.size(), t = b.theta.size();
  std::vector<TensorField> fields = {
      tensor_field("phi_i", {p}, b.phi),
      tensor_field("theta_i", {t}, b.theta),
      tensor_field("ndf", {b.ndf.height, b.ndf.width}, b.ndf.values),
      tensor_field("sigma", {b.sigma.height, b.sigma.width}, b.sigma.values),
      tensor_field("vndf", {p, t, b.vndf.height, b.vndf.width}, b.vndf.values),
      tensor_field("luminance", {p, t, b.luminance.height, b.luminance.width}, b.luminance.values),
      tensor_field(b.wavelengths.empty() ? "rgb" : "spectra", {p, t, b.channels, b.values.height, b.values.width},
                   b.values.values)};
  if (!b.wavelengths.empty()) fields.push_back(tensor_field("wavelengths", {b.channels}, b.wavelengths));
  fields.push_back({"jacobian", 1, {1}, std::string(1, b.jacobian ? '\1' : '\0')});
  fields.push_back({"description", 1, {6}, "facets"});
  return fields;
}

/// The unpolarized part of a polarimetric BRDF: a function of phi_d, theta_d, theta_h and the channel.
template <class F>
PolarizedBrdf tabulate_polarized(std::size_t phis, std::size_t thetas, std::vector<float> wavelengths, F&& f) {
  PolarizedBrdf out;
  const auto angles = [](std::size_t count, double first, double last) {
    std::vector<float> list;
    for (std::size_t i = 0; i < count; ++i)
      list.push_back(static_cast<float>(first + (last - first) * double(i) / double(count - 1)));
    return list;
  };
  out.phi_d = angles(phis, -kPi, kPi);
  out.theta_d = out.theta_h = angles(thetas, 0, kPi / 2);
  out.wavelengths = std::move(wavelengths);
  out.channels = out.wavelengths.empty() ? 3 : out.wavelengths.size();
  for (const float phi_d : out.phi_d)
    for (std::size_t channel = 0; channel < out.channels; ++channel)
      for (const float theta_d : out.theta_d)
        for (const float theta_h : out.theta_h)
          out.values.push_back(static_cast<float>(f(double(phi_d), double(theta_d), double(theta_h), channel)));
  return out;
}

/// The fields of its file. All other elements of the Mueller matrices are `rest`.
inline std::vector<TensorField> polarized_fields(const PolarizedBrdf& b, float rest = 7) {
  const std::uint64_t p = b.phi_d.size(), d = b.theta_d.size(), h = b.theta_h.size(), n = b.channels;
  std::vector<float> matrices(p * d * h * n * 16, rest);
  for (std::uint64_t i = 0; i < p * d * h * n; ++i)
    matrices[16 * i] = b.values[(i / (d * h * n) * n + i % n) * d * h + i / n % (d * h)];
  std::string nm;
  for (const float wavelength : b.wavelengths) {
    const auto number = static_cast<std::uint16_t>(wavelength);
    nm.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
  return {tensor_field("phi_d", {1, p}, b.phi_d), tensor_field("theta_d", {1, d}, b.theta_d),
          tensor_field("theta_h", {1, h}, b.theta_h), TensorField{"wvls", 3, {n}, nm},
          tensor_field("M", {p, d, h, n, 4, 4}, matrices)};
}

/// Azimuths over the whole circle, a half or a quarter of it, as in measured BRDF files.
inline std::vector<float> azimuths(int count, int reduction) {
  std::vector<float> out;
  for (int i = 0; i < count; ++i) out.push_back(static_cast<float>(-kPi + 2 * kPi / reduction * i / (count - 1)));
  return out;
}

/// Tables for any closure that needs some, and the words that refer to them.
struct AnyTables {
  std::vector<float> floats;
  std::array<float, 4> measured;
  std::array<float, 2> phase;
};
inline const AnyTables& any_tables() {
  static const AnyTables instance = [] {
    AnyTables out;
    ClosureTables tables;
    // Few and wide cells, because pdfs with many edges take long to integrate.
    const std::vector<float> few = {0.0f, 0.75f, 1.5f};
    const auto facets = [&](double alpha_v, const std::vector<float>& phi) {
      return TabulatedFacets{.alpha_u = 0.7, .alpha_v = alpha_v, .phi = phi, .theta = few, .side = 6, .sample_side = 3}
          .tabulate();
    };
    out.measured = {tables.measured(facets(0.7, {0})), tables.measured(facets(0.5, azimuths(3, 4))),
                    tables.measured(facets(0.5, azimuths(4, 2))),
                    tables.polarized(tabulate_polarized(3, 3, {},
                                                        [](double phi, double d, double h, std::size_t channel) {
                                                          return 0.1 + 0.02 * std::cos(phi) * h + 0.05 * d +
                                                                 0.03 * double(channel);
                                                        }),
                                     0.4f)};
    out.phase = {tables.phase(std::vector<float>{1.0f, 0.5f, 0.0f, 2.0f, 8.0f}),
                 tables.phase(std::vector<float>{0.3f, 0.7f})};
    out.floats = tables.take();
    return out;
  }();
  return instance;
}

}  // namespace sheaf
