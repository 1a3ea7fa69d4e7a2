// Numerical integration over the microfacets of a coat, in double precision.
#include "scene/materials/rough_coat.h"

#include "core/math/fresnel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sheaf {

namespace {

struct Node {
  double x, weight;
};

/// Gauss-Legendre nodes on [0, 1], by Newton's method on the Legendre polynomials.
template <int kNodes> std::array<Node, kNodes> gauss_legendre() {
  std::array<Node, kNodes> nodes;
  for (int i = 0; i < kNodes; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (kNodes + 0.5)), derivative = 1;
    for (int step = 0; step < 20; ++step) {
      double p = 1, previous = 0;
      for (int k = 1; k <= kNodes; ++k) {
        const double next = ((2 * k - 1) * x * p - (k - 1) * previous) / k;
        previous = p;
        p = next;
      }
      derivative = kNodes * (x * p - previous) / (x * x - 1);
      x -= p / derivative;
    }
    nodes[static_cast<std::size_t>(i)] = {0.5 * (1 + x), 1 / ((1 - x * x) * derivative * derivative)};
  }
  return nodes;
}

/// Fractions of the light from one direction that the coat's single scattering reflects and transmits.
struct CoatAlbedos {
  double reflected = 0, transmitted = 0;
};

class Coat {
 public:
  Coat(RoughnessDescription::Distribution distribution, double alpha, double eta)
      : beckmann_(distribution == RoughnessDescription::Distribution::kBeckmann), alpha_(alpha), eta_(eta) {}

  /// For light with cosine `cosine` > 0 at an interface of relative index `eta`.
  CoatAlbedos albedos(double cosine, double eta) const {
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    return beckmann_ ? beckmann_albedos(cosine, sine, eta) : ggx_albedos(cosine, sine, eta);
  }

  /// Average of albedos().reflected over diffuse light from inside. The integral is split at the critical angle, where
  /// the reflectance of a nearly smooth coat has a kink.
  double internal_reflectance() const {
    const double critical = eta_ > 1 ? std::sqrt(1 - 1 / (eta_ * eta_)) : 0.5;
    double sum = 0;
    static const auto directions = gauss_legendre<kDirections>();
    for (const Node& n : directions) {
      const double low = critical * n.x, high = critical + (1 - critical) * n.x;
      sum += 2 * n.weight *
             (critical * low * albedos(low, 1 / eta_).reflected +
              (1 - critical) * high * albedos(high, 1 / eta_).reflected);
    }
    return sum;
  }

 private:
  static constexpr int kDirections = 20, kAlong = 32, kAcross = 16;
  static constexpr double kMaxSlope = 4.5;

  double shadowing(double cosine) const {
    const double a2 = alpha_ * alpha_ * std::max(0.0, 1 - cosine * cosine), c2 = cosine * cosine;
    if (!beckmann_) return 2 * cosine / (cosine + std::sqrt(c2 + a2));
    const double a = cosine / std::sqrt(std::max(a2, 1e-30));
    if (a > 5) return 1;
    return 2 * a / (a * (1 + std::erf(a)) + std::exp(-a * a) / std::sqrt(std::numbers::pi));
  }

  /// Adds the contribution of a facet with normal (x, y, z).
  void add(CoatAlbedos& albedos, double weight, double x, double y, double z, double cosine, double sine,
           double eta) const {
    const double length = std::sqrt(x * x + y * y + z * z), c = (x * sine + z * cosine) / length, mz = z / length;
    if (!(c > 0)) return;
    const double fresnel = fresnel_reflectance(c, eta), reflected = 2 * c * mz - cosine;
    if (reflected > 0) albedos.reflected += weight * fresnel * shadowing(reflected);
    if (fresnel >= 1) return;
    const double refracted = cosine / eta - mz * (c / eta - std::sqrt(1 - (1 - c * c) / (eta * eta)));
    if (refracted > 0) albedos.transmitted += weight * (1 - fresnel) * shadowing(std::min(refracted, 1.0));
  }

  /// Samples visible facets with the mapping of Dupuy and Benyoub 2023, over half of the azimuths.
  CoatAlbedos ggx_albedos(double cosine, double sine, double eta) const {
    struct Azimuth {
      double cosine, sine, weight;
    };
    static const auto depths = gauss_legendre<kAlong>();
    static const auto azimuths = [] {
      std::array<Azimuth, kAcross> all;
      const auto nodes = gauss_legendre<kAcross>();
      for (std::size_t i = 0; i < nodes.size(); ++i)
        all[i] = {std::cos(std::numbers::pi * nodes[i].x), std::sin(std::numbers::pi * nodes[i].x), nodes[i].weight};
      return all;
    }();
    const double stretched = std::hypot(alpha_ * sine, cosine), wx = alpha_ * sine / stretched, wz = cosine / stretched;
    CoatAlbedos albedos;
    for (const Node& v : depths) {
      const double depth = v.x * (1 + wz), r = std::sqrt(depth * (2 - depth));
      for (const Azimuth& u : azimuths)
        add(albedos, u.weight * v.weight, alpha_ * (r * u.cosine + wx), alpha_ * r * u.sine, 1 - depth + wz, cosine,
            sine, eta);
    }
    return albedos;
  }

  /// Integrates over slopes, weighted by their visibility, over half of the slopes across.
  CoatAlbedos beckmann_albedos(double cosine, double sine, double eta) const {
    static const auto along = gauss_legendre<kAlong>();
    static const auto across = [] {  // slopes with their Gaussian weight
      auto nodes = gauss_legendre<kAcross>();
      for (Node& u : nodes) u = {kMaxSlope * u.x, u.weight * std::exp(-kMaxSlope * u.x * kMaxSlope * u.x)};
      return nodes;
    }();
    const double end = std::min(cosine / std::max(alpha_ * sine, 1e-30), kMaxSlope);
    CoatAlbedos albedos;
    double total = 0;
    for (const Node& v : along) {
      const double x = -kMaxSlope + (end + kMaxSlope) * v.x;
      const double line_weight = v.weight * (cosine - alpha_ * x * sine) * std::exp(-x * x);
      for (const Node& u : across) {
        const double weight = u.weight * line_weight;
        total += weight;
        add(albedos, weight, -alpha_ * x, -alpha_ * u.x, 1, cosine, sine, eta);
      }
    }
    return {albedos.reflected / total, albedos.transmitted / total};
  }

  bool beckmann_;
  double alpha_, eta_;
};

constexpr std::size_t kSamples = RoughCoatSamples::kCosines;
constexpr std::size_t kTransmittanceCoefficients = kTransmittanceTerms - 1;

/// Cosines of the samples, denser at grazing directions.
const std::array<double, kSamples>& sample_cosines() {
  static const auto cosines = [] {
    std::array<double, kSamples> all;
    for (std::size_t s = 0; s < kSamples; ++s)
      all[s] = std::pow(std::sin(0.5 * std::numbers::pi * (static_cast<double>(s) + 0.5) / kSamples), 4);
    return all;
  }();
  return cosines;
}

/// Least-squares fit of polynomials in (1 + width) cosine / (cosine + width) to the samples. The cosines are always the
/// same, so the coefficients are a constant matrix times the values.
class PolynomialFit {
 public:
  explicit PolynomialFit(double width) : width_(width) {
    constexpr std::size_t n = kTransmittanceCoefficients;
    double matrix[n][n + kSamples] = {};  // normal equations, with the right-hand side of each sample
    for (std::size_t s = 0; s < kSamples; ++s) {
      x_[s] = (1 + width) * sample_cosines()[s] / (sample_cosines()[s] + width);
      for (std::size_t i = 0; i < n; ++i) {
        const double power = std::pow(x_[s], i);
        for (std::size_t j = 0; j < n; ++j) matrix[i][j] += power * std::pow(x_[s], j);
        matrix[i][n + s] = power;
      }
    }
    for (std::size_t k = 0; k < n; ++k)  // positive definite: no pivoting
      for (std::size_t i = 0; i < n; ++i) {
        if (i == k) continue;
        const double factor = matrix[i][k] / matrix[k][k];
        for (std::size_t j = k; j < n + kSamples; ++j) matrix[i][j] -= factor * matrix[k][j];
      }
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t s = 0; s < kSamples; ++s) solution_[i][s] = matrix[i][n + s] / matrix[i][i];
  }

  double width() const { return width_; }
  using Coefficients = std::array<double, kTransmittanceCoefficients>;
  Coefficients coefficients(const std::array<double, kSamples>& values) const {
    Coefficients out{};
    for (std::size_t i = 0; i < out.size(); ++i)
      for (std::size_t s = 0; s < kSamples; ++s) out[i] += solution_[i][s] * values[s];
    return out;
  }
  /// Maximum deviation from the samples.
  double error(const Coefficients& coefficients, const std::array<double, kSamples>& values) const {
    double error = 0;
    for (std::size_t s = 0; s < kSamples; ++s) {
      double value = 0;
      for (std::size_t i = coefficients.size(); i-- > 0;) value = value * x_[s] + coefficients[i];
      error = std::max(error, std::fabs(value - values[s]));
    }
    return error;
  }

 private:
  double width_;
  std::array<double, kSamples> x_;
  double solution_[kTransmittanceCoefficients][kSamples];
};

/// Tries several widths of the grazing part and keeps the best fit.
std::array<float, kTransmittanceTerms> fit_transmittance(const std::array<double, kSamples>& values) {
  static const std::array fits{PolynomialFit(0.04), PolynomialFit(0.06), PolynomialFit(0.09),
                               PolynomialFit(0.13), PolynomialFit(0.2),  PolynomialFit(0.3),
                               PolynomialFit(0.5),  PolynomialFit(1.0),  PolynomialFit(3.0)};
  std::array<float, kTransmittanceTerms> best{};
  double best_error = std::numeric_limits<double>::infinity();
  for (const PolynomialFit& fit : fits) {
    const PolynomialFit::Coefficients coefficients = fit.coefficients(values);
    const double error = fit.error(coefficients, values);
    if (!(error < best_error)) continue;
    best_error = error;
    best[0] = static_cast<float>(fit.width());
    std::copy(coefficients.begin(), coefficients.end(), best.begin() + 1);
  }
  return best;
}

RoughCoat fit_coat(const RoughCoatSamples& samples) {
  return {static_cast<float>(samples.internal_reflectance), fit_transmittance(samples.transmitted)};
}

RoughCoatSamples sample_coat(RoughnessDescription::Distribution distribution, double alpha, double eta) {
  const Coat coat(distribution, alpha, eta);
  RoughCoatSamples samples;
  samples.internal_reflectance = coat.internal_reflectance();
  for (std::size_t s = 0; s < kSamples; ++s)
    samples.transmitted[s] = coat.albedos(sample_cosines()[s], eta).transmitted;
  return samples;
}

double clamped_alpha(double alpha) { return std::clamp(alpha, 1e-4, 1e3); }

}  // namespace

float smooth_coat_internal_reflectance(double eta) {
  // The transmittance from outside and from inside agree up to eta^2, and the former has no kink for eta >= 1.
  double sum = 0;
  const double outside = eta >= 1 ? eta : 1 / eta;
  static const auto nodes = gauss_legendre<64>();
  for (const Node& n : nodes) sum += 2 * n.weight * n.x * fresnel_reflectance(n.x, outside);
  return static_cast<float>(eta >= 1 ? 1 - (1 - sum) / (eta * eta) : sum);
}

RoughCoat rough_coat(RoughnessDescription::Distribution distribution, double alpha, double eta) {
  return fit_coat(sample_coat(distribution, clamped_alpha(alpha), eta));
}

RoughCoat RoughCoats::coat(RoughnessDescription::Distribution distribution, double alpha, double eta) {
  alpha = clamped_alpha(alpha);
  Family& family = families_[{distribution, eta}];
  const auto known = family.exact.find(alpha);
  if (known != family.exact.end()) return known->second;
  if (family.exact.size() < kMaxExact)
    return family.exact.emplace(alpha, rough_coat(distribution, alpha, eta)).first->second;

  // Lagrange interpolation of the samples over log alpha
  constexpr int kNodes = 6;
  constexpr double kNodesPerOctave = 4;
  const double position = kNodesPerOctave * std::log2(alpha);
  const int first = static_cast<int>(std::floor(position)) - kNodes / 2 + 1;
  RoughCoatSamples samples;
  for (int i = first; i < first + kNodes; ++i) {
    auto node = family.nodes.find(i);
    if (node == family.nodes.end())
      node = family.nodes.emplace(i, sample_coat(distribution, std::exp2(i / kNodesPerOctave), eta)).first;
    double weight = 1;
    for (int j = first; j < first + kNodes; ++j)
      if (j != i) weight *= (position - j) / (i - j);
    samples.internal_reflectance += weight * node->second.internal_reflectance;
    for (std::size_t s = 0; s < kSamples; ++s) samples.transmitted[s] += weight * node->second.transmitted[s];
  }
  return fit_coat(samples);
}

}  // namespace sheaf
