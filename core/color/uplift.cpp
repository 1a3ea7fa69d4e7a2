// Fitting of sigmoid polynomials to colors by Newton's method, and construction of the table (see
// core/color/uplift.h).
#include "core/color/uplift.h"

#include "core/color/color.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace sheaf {

namespace {

/// The integral from reflectance to color, as a sum over the nodes of the CIE tables.
struct Quadrature {
  static constexpr int kNodes = 95;
  float t[kNodes];          ///< polynomial's argument at the node
  float weight[3][kNodes];  ///< the weights of each channel sum to 1
  Quadrature();
};

/// The Lagrange polynomial that is 1 at `own` and 0 at the other integers from 0 to 3, evaluated at `x`.
double lagrange(int own, double x) {
  double product = 1;
  for (int other = 0; other < 4; ++other)
    if (other != own) product *= (x - other) / (own - other);
  return product;
}

/// In each interval of the tables, spectra are approximated by cubics through its ends and the nodes next to them. The
/// tables are linear there. Four-point Gauss quadrature integrates the product exactly.
Quadrature::Quadrature() {
  constexpr double kStep = 5.0;
  constexpr std::pair<double, double> kGauss[] = {{-0.8611363115940526, 0.3478548451374538},
                                                  {-0.3399810435848563, 0.6521451548625461},
                                                  {0.3399810435848563, 0.6521451548625461},
                                                  {0.8611363115940526, 0.3478548451374538}};
  // Integrate the Lagrange polynomials of the nodes
  double sums[3][kNodes] = {}, total[3] = {};
  for (int i = 0; i + 1 < kNodes; ++i)
    for (const auto& [x, gauss] : kGauss) {
      const double position = i + 0.5 + 0.5 * x;
      const float lambda = static_cast<float>(static_cast<double>(kWavelengthMin) + kStep * position);
      const Vec3f rgb = xyz_to_rec709(cie_1931_xyz(lambda)) * cie_d65(lambda);
      const double channels[3] = {static_cast<double>(rgb.x), static_cast<double>(rgb.y), static_cast<double>(rgb.z)};
      const int first = std::clamp(i - 1, 0, kNodes - 4);
      for (int c = 0; c < 3; ++c) {
        total[c] += gauss * channels[c];
        for (int k = 0; k < 4; ++k) sums[c][first + k] += gauss * channels[c] * lagrange(k, position - first);
      }
    }
  for (int i = 0; i < kNodes; ++i) {
    const double lambda = static_cast<double>(kWavelengthMin) + kStep * i;
    t[i] = static_cast<float>((lambda - static_cast<double>(kSigmoidCenter)) / static_cast<double>(kSigmoidHalfRange));
    for (int c = 0; c < 3; ++c) weight[c][i] = static_cast<float>(sums[c][i] / total[c]);
  }
}

const Quadrature& quadrature() {
  static const Quadrature instance;
  return instance;
}

/// An iterate of Newton's method: coefficients, error of the color, and its derivatives.
template <class L> struct NewtonIterate {
  using F = typename L::Float;
  F c[3];     ///< coefficients of 1, t, t^2
  F off[3];   ///< color minus target
  F d[3][3];  ///< d[channel][coefficient]
  F error;    ///< maximum of |off|
};

template <class L> SHEAF_INLINE void measure(const Quadrature& q, Vec3<L> target, NewtonIterate<L>& iterate) {
  using F = typename L::Float;
  // Integrate color and derivatives
  F sum[3], d[3][3];
  for (int channel = 0; channel < 3; ++channel) sum[channel] = d[channel][0] = d[channel][1] = d[channel][2] = F(0.0f);
  for (int i = 0; i < Quadrature::kNodes; ++i) {
    const F t = F(q.t[i]);
    const F x = fma(fma(iterate.c[2], t, iterate.c[1]), t, iterate.c[0]);
    const F inverse_root = F(1.0f) / sqrt(fma(x, x, F(1.0f)));
    const F value = F(0.5f) * fma(x, inverse_root, F(1.0f));
    const F slope = F(0.5f) * inverse_root * inverse_root * inverse_root;
    for (int channel = 0; channel < 3; ++channel) {
      const F w = F(q.weight[channel][i]), g = w * slope, gt = g * t;
      sum[channel] = fma(w, value, sum[channel]);
      d[channel][0] += g;
      d[channel][1] += gt;
      d[channel][2] = fma(gt, t, d[channel][2]);
    }
  }
  // Compare with the target
  const F goal[3] = {target.x, target.y, target.z};
  iterate.error = F(0.0f);
  for (int channel = 0; channel < 3; ++channel) {
    iterate.off[channel] = sum[channel] - goal[channel];
    iterate.error = max(iterate.error, abs(iterate.off[channel]));
    for (int k = 0; k < 3; ++k) iterate.d[channel][k] = d[channel][k];
  }
}

/// Solves d * step = off by Cramer's rule. The step is zero if the matrix is singular.
template <class L> SHEAF_INLINE void newton_step(const NewtonIterate<L>& a, typename L::Float (&step)[3]) {
  using F = typename L::Float;
  const Vec3<L> column[3] = {
      {a.d[0][0], a.d[1][0], a.d[2][0]}, {a.d[0][1], a.d[1][1], a.d[2][1]}, {a.d[0][2], a.d[1][2], a.d[2][2]}};
  const Vec3<L> off{a.off[0], a.off[1], a.off[2]};
  const F determinant = dot(column[0], cross(column[1], column[2]));
  const auto singular = abs(determinant) < F(1e-30f);
  const F inverse = select(singular, F(0.0f), F(1.0f) / select(singular, F(1.0f), determinant));
  step[0] = dot(off, cross(column[1], column[2])) * inverse;
  step[1] = dot(column[0], cross(off, column[2])) * inverse;
  step[2] = dot(column[0], cross(column[1], off)) * inverse;
}

constexpr float kTolerance = 2e-5f;
constexpr float kLargestCoefficient = 1000.0f;

/// Newton's method with damped steps. Starts from best.c and keeps the best iterate.
template <class L> void fit(const Quadrature& q, Vec3<L> target, NewtonIterate<L>& best, int iterations) {
  using F = typename L::Float;
  measure<L>(q, target, best);
  F damping = F(1.0f);
  for (int i = 0; i < iterations; ++i) {
    if (all((best.error < F(kTolerance)) | (damping < F(1e-3f)))) return;
    // Limit the length of the Newton step.
    F step[3];
    newton_step<L>(best, step);
    const F length = max(abs(step[0]), max(abs(step[1]), abs(step[2])));
    const F size = max(abs(best.c[0]), max(abs(best.c[1]), abs(best.c[2])));
    const F longest = F(0.5f) + F(0.5f) * size;
    const F factor = damping * min(F(1.0f), longest / max(length, F(1e-20f)));
    NewtonIterate<L> next;
    for (int k = 0; k < 3; ++k)
      next.c[k] = clamp(best.c[k] - factor * step[k], F(-kLargestCoefficient), F(kLargestCoefficient));
    measure<L>(q, target, next);
    // Keep improvements, and adapt the damping.
    const auto better = next.error < best.error;
    damping = select(better, min(F(1.0f), F(2.0f) * damping), F(0.25f) * damping);
    best.error = select(better, next.error, best.error);
    for (int k = 0; k < 3; ++k) {
      best.c[k] = select(better, next.c[k], best.c[k]);
      best.off[k] = select(better, next.off[k], best.off[k]);
      for (int j = 0; j < 3; ++j) best.d[k][j] = select(better, next.d[k][j], best.d[k][j]);
    }
  }
}

/// Fits without the solution of a neighbor as initial value: moves from gray to the target in steps.
template <class L> void fit_from_gray(const Quadrature& q, Vec3<L> target, NewtonIterate<L>& iterate) {
  using F = typename L::Float;
  const F gray = clamp((target.x + target.y + target.z) * F(1.0f / 3.0f), F(0.02f), F(0.98f));
  iterate.c[0] = inverse_sigmoid(gray);
  iterate.c[1] = iterate.c[2] = F(0.0f);
  for (const float part : {0.25f, 0.5f, 0.75f, 0.9f, 1.0f}) {
    const auto between = [&](F c) { return lerp(F(part), gray, c); };
    fit<L>(q, {between(target.x), between(target.y), between(target.z)}, iterate, part < 1.0f ? 6 : 25);
  }
}

/// The color at a node of the table.
Vec3f node_color(int largest, int z, int second, int first) {
  const float brightness = UpliftTable::brightness_at(static_cast<float>(z));
  float rgb[3];
  rgb[largest] = brightness;
  rgb[(largest + 1) % 3] = brightness * UpliftTable::ratio_at(static_cast<float>(first));
  rgb[(largest + 2) % 3] = brightness * UpliftTable::ratio_at(static_cast<float>(second));
  return {rgb[0], rgb[1], rgb[2]};
}

/// Fits the nodes of one plane (largest, second), one register of `first` at a time. Proceeds up and down from a middle
/// brightness, and starts each fit from the neighboring solution.
void fit_plane(const Quadrature& q, int largest, int second, float* nodes) {
  constexpr int kSize = UpliftTable::kSize, kStart = kSize / 4;
  static_assert(kSize % kWidth == 0);
  const auto fit_node = [&](NewtonIterate<Wide>& iterate, int z, int x, bool cold) {
    LaneRows<Wide, Vec3> colors;
    for (int lane = 0; lane < kWidth; ++lane) colors.set(lane, node_color(largest, z, second, x + lane));
    if (cold)
      fit_from_gray<Wide>(q, colors.load(), iterate);
    else
      fit<Wide>(q, colors.load(), iterate, 25);
    // Store the coefficients
    const LaneArray c0(iterate.c[2]), c1(iterate.c[1]), c2(iterate.c[0]);
    for (int lane = 0; lane < kWidth; ++lane) {
      float* node = nodes + 4 * (((largest * kSize + z) * kSize + second) * kSize + x + lane);
      node[0] = c0[lane], node[1] = c1[lane], node[2] = c2[lane];
    }
  };
  for (int x = 0; x < kSize; x += kWidth) {
    // Fit the middle node from gray, then its neighbors upwards and downwards
    NewtonIterate<Wide> middle;
    fit_node(middle, kStart, x, true);
    NewtonIterate<Wide> iterate = middle;
    for (int z = kStart + 1; z < kSize; ++z) fit_node(iterate, z, x, false);
    iterate = middle;
    for (int z = kStart - 1; z >= 0; --z) fit_node(iterate, z, x, false);
  }
}

bool is_gray(Vec3f rgb) { return rgb.x == rgb.y && rgb.y == rgb.z; }

/// Fits a color with components in [0, 1].
SigmoidPolynomial<Scalar> fit_color(Vec3f rgb) {
  NewtonIterate<Scalar> iterate;
  fit_from_gray<Scalar>(quadrature(), rgb, iterate);
  return {iterate.c[2], iterate.c[1], iterate.c[0]};
}

constexpr ScaledSigmoid<Scalar> flat(float value) { return {{0.0f, 0.0f, kInfinity}, value}; }

}  // namespace

float UpliftTable::ratio_at(float position) {
  // With ratio = sin^2(a), ratio_position is linear in sin(a) - cos(a) = sqrt(2) sin(a - pi/4).
  const float p = clamp(position / float(kSize - 1), 0.0f, 1.0f);
  return sqr(std::sin(0.25f * kPi + std::asin((2.0f * p - 1.0f) * 0.70710678f)));
}

UpliftTable::UpliftTable() : nodes(std::size_t{4} * 3 * kSize * kSize * kSize) {
  const Quadrature& q = quadrature();
  // Isolated: a waiting thread must not run a task of the caller, which might request the table again.
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(0, 3 * kSize, [&](int plane) { fit_plane(q, plane / kSize, plane % kSize, nodes.data()); });
  });
}

const UpliftTable& UpliftTable::get() {
  static const UpliftTable table;
  return table;
}

ScaledSigmoid<Scalar> fit_reflectance(Vec3f rgb) {
  rgb = {clamp(rgb.x, 0.0f, 1.0f), clamp(rgb.y, 0.0f, 1.0f), clamp(rgb.z, 0.0f, 1.0f)};
  if (is_gray(rgb)) return flat(rgb.x);
  const float largest = max_component(rgb), scale = min(1.0f, largest / kUpliftDarkest);
  return {fit_color(rgb / scale), scale};
}

ScaledSigmoid<Scalar> fit_unbounded(Vec3f rgb) {
  rgb = {max(rgb.x, 0.0f), max(rgb.y, 0.0f), max(rgb.z, 0.0f)};
  if (is_gray(rgb)) return flat(rgb.x);
  const float scale = max_component(rgb) / kUpliftUnbounded;
  return {fit_color(rgb / scale), scale};
}

}  // namespace sheaf
