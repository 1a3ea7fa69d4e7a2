// Quadrature over the facets of a coat, in double precision.
#include "scene/compile/plastic.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sheaf {

namespace {

struct Node {
  double x, weight;
};

/// Gauss-Legendre nodes on [0, 1], by Newton's method on the Legendre polynomials.
template <int n> std::array<Node, n> gauss_legendre() {
  std::array<Node, n> nodes;
  for (int i = 0; i < n; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), derivative = 1;
    for (int step = 0; step < 20; ++step) {
      double p = 1, previous = 0;
      for (int k = 1; k <= n; ++k) {
        const double next = ((2 * k - 1) * x * p - (k - 1) * previous) / k;
        previous = p;
        p = next;
      }
      derivative = n * (x * p - previous) / (x * x - 1);
      x -= p / derivative;
    }
    nodes[static_cast<std::size_t>(i)] = {0.5 * (1 + x), 1 / ((1 - x * x) * derivative * derivative)};
  }
  return nodes;
}

double fresnel_reflectance(double cosine, double eta) {
  const double cos2 = 1 - (1 - cosine * cosine) / (eta * eta);
  if (cos2 <= 0) return 1;
  const double cos_t = std::sqrt(cos2);
  const double parallel = (eta * cosine - cos_t) / (eta * cosine + cos_t);
  const double perpendicular = (cosine - eta * cos_t) / (cosine + eta * cos_t);
  return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

/// Light from one direction, shared out by single scattering at the coat.
struct Shares {
  double reflected = 0, transmitted = 0;
};

class Coat {
 public:
  Coat(RoughnessDescription::Distribution distribution, double alpha, double eta)
      : beckmann_(distribution == RoughnessDescription::Distribution::kBeckmann), alpha_(alpha), eta_(eta) {}

  /// For light whose direction has cosine `cosine` > 0 and which meets the relative index `eta`.
  Shares shares(double cosine, double eta) const {
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    return beckmann_ ? beckmann_shares(cosine, sine, eta) : ggx_shares(cosine, sine, eta);
  }

  /// The average of shares().reflected over diffuse light from within. The integral is cut at the critical angle, where
  /// the reflectance of a nearly smooth coat has a kink.
  double internal_reflectance() const {
    const double critical = eta_ > 1 ? std::sqrt(1 - 1 / (eta_ * eta_)) : 0.5;
    double sum = 0;
    for (const Node& n : gauss_legendre<kDirections>()) {
      const double low = critical * n.x, high = critical + (1 - critical) * n.x;
      sum += 2 * n.weight * (critical * low * shares(low, 1 / eta_).reflected +
                             (1 - critical) * high * shares(high, 1 / eta_).reflected);
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

  /// What a facet with normal (x, y, z) adds to the shares.
  void add(Shares& shares, double weight, double x, double y, double z, double cosine, double sine, double eta) const {
    const double length = std::sqrt(x * x + y * y + z * z), c = (x * sine + z * cosine) / length, mz = z / length;
    if (!(c > 0)) return;
    const double fresnel = fresnel_reflectance(c, eta), reflected = 2 * c * mz - cosine;
    if (reflected > 0) shares.reflected += weight * fresnel * shadowing(reflected);
    if (fresnel >= 1) return;
    const double refracted = cosine / eta - mz * (c / eta - std::sqrt(1 - (1 - c * c) / (eta * eta)));
    if (refracted > 0) shares.transmitted += weight * (1 - fresnel) * shadowing(std::min(refracted, 1.0));
  }

  /// Facets by the mapping of Dupuy and Benyoub 2023, over half of the azimuths.
  Shares ggx_shares(double cosine, double sine, double eta) const {
    static const auto depths = gauss_legendre<kAlong>();
    static const auto azimuths = gauss_legendre<kAcross>();
    const double stretched = std::hypot(alpha_ * sine, cosine), wx = alpha_ * sine / stretched, wz = cosine / stretched;
    Shares shares;
    for (const Node& v : depths) {
      const double depth = v.x * (1 + wz), r = std::sqrt(depth * (2 - depth));
      for (const Node& u : azimuths) {
        const double angle = std::numbers::pi * u.x;
        add(shares, u.weight * v.weight, alpha_ * (r * std::cos(angle) + wx), alpha_ * r * std::sin(angle),
            1 - depth + wz, cosine, sine, eta);
      }
    }
    return shares;
  }

  /// Facets by their slopes, weighted by their visibility; over half of the slopes across.
  Shares beckmann_shares(double cosine, double sine, double eta) const {
    static const auto along = gauss_legendre<kAlong>();
    static const auto across = gauss_legendre<kAcross>();
    const double end = std::min(cosine / std::max(alpha_ * sine, 1e-30), kMaxSlope);
    Shares shares;
    double total = 0;
    for (const Node& v : along) {
      const double x = -kMaxSlope + (end + kMaxSlope) * v.x;
      for (const Node& u : across) {
        const double y = kMaxSlope * u.x;
        const double weight = u.weight * v.weight * (cosine - alpha_ * x * sine) * std::exp(-x * x - y * y);
        total += weight;
        add(shares, weight, -alpha_ * x, -alpha_ * y, 1, cosine, sine, eta);
      }
    }
    return {shares.reflected / total, shares.transmitted / total};
  }

  bool beckmann_;
  double alpha_, eta_;
};

constexpr int kSamples = 28;  // of the transmittance
constexpr int kTransmittanceCoefficients = kTransmittanceTerms - 1;

/// A polynomial through samples in the least-squares sense, and the largest deviation.
struct Fit {
  std::array<double, kTransmittanceCoefficients> coefficients{};
  double error = 0;
};

Fit fit_polynomial(const std::array<double, kSamples>& x, const std::array<double, kSamples>& y) {
  constexpr int n = kTransmittanceCoefficients;
  double matrix[n][n + 1] = {};  // the normal equations
  for (std::size_t s = 0; s < kSamples; ++s)
    for (int i = 0; i < n; ++i) {
      const double power = std::pow(x[s], i);
      for (int j = 0; j < n; ++j) matrix[i][j] += power * std::pow(x[s], j);
      matrix[i][n] += power * y[s];
    }
  for (int k = 0; k < n; ++k)  // positive definite: no pivoting
    for (int i = k + 1; i < n; ++i) {
      const double factor = matrix[i][k] / matrix[k][k];
      for (int j = k; j <= n; ++j) matrix[i][j] -= factor * matrix[k][j];
    }
  Fit fit;
  for (int i = n - 1; i >= 0; --i) {
    double value = matrix[i][n];
    for (int j = i + 1; j < n; ++j) value -= matrix[i][j] * fit.coefficients[static_cast<std::size_t>(j)];
    fit.coefficients[static_cast<std::size_t>(i)] = value / matrix[i][i];
  }
  for (std::size_t s = 0; s < kSamples; ++s) {
    double value = 0;
    for (int i = n - 1; i >= 0; --i) value = value * x[s] + fit.coefficients[static_cast<std::size_t>(i)];
    fit.error = std::max(fit.error, std::fabs(value - y[s]));
  }
  return fit;
}

/// Samples that crowd at grazing directions, and every width of the grazing part that is worth a try; the best wins.
std::array<float, kTransmittanceTerms> fit_transmittance(const Coat& coat, double eta) {
  std::array<double, kSamples> cosines, values, x;
  for (std::size_t s = 0; s < kSamples; ++s) {
    cosines[s] = std::pow(std::sin(0.5 * std::numbers::pi * (static_cast<double>(s) + 0.5) / kSamples), 4);
    values[s] = coat.shares(cosines[s], eta).transmitted;
  }
  std::array<float, kTransmittanceTerms> best{};
  double best_error = std::numeric_limits<double>::infinity();
  for (const double width : {0.04, 0.06, 0.09, 0.13, 0.2, 0.3, 0.5, 1.0, 3.0}) {
    for (std::size_t s = 0; s < kSamples; ++s) x[s] = (1 + width) * cosines[s] / (cosines[s] + width);
    const Fit fit = fit_polynomial(x, values);
    if (!(fit.error < best_error)) continue;
    best_error = fit.error;
    best[0] = static_cast<float>(width);
    std::copy(fit.coefficients.begin(), fit.coefficients.end(), best.begin() + 1);
  }
  return best;
}

}  // namespace

float smooth_coat_internal_reflectance(double eta) {
  // What comes in under a cosine and what gets out are the same up to eta^2, and the former has no kink for eta >= 1.
  double sum = 0;
  const double outside = eta >= 1 ? eta : 1 / eta;
  for (const Node& n : gauss_legendre<64>()) sum += 2 * n.weight * n.x * fresnel_reflectance(n.x, outside);
  return static_cast<float>(eta >= 1 ? 1 - (1 - sum) / (eta * eta) : sum);
}

RoughCoat rough_coat(RoughnessDescription::Distribution distribution, double alpha, double eta) {
  const Coat coat(distribution, std::clamp(alpha, 1e-4, 1e3), eta);
  return {static_cast<float>(coat.internal_reflectance()), fit_transmittance(coat, eta)};
}

}  // namespace sheaf
