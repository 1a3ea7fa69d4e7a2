#include "scene/compile/motion_steps.h"

#include "core/io/error.h"
#include "scene/compile/key_times.h"
#include "scene/tables/instance_transform.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Rows of a 3x4 matrix.
using AffineRows = std::array<double, 12>;

AffineRows affine_rows(const Transform& transform) {
  AffineRows out;
  for (std::size_t i = 0; i < 12; ++i) out[i] = transform.matrix().m[i / 4][i % 4];
  return out;
}

Triple image_of(const AffineRows& m, const std::array<double, 4>& p) {
  Triple out{};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t k = 0; k < 4; ++k) out[row] += m[4 * row + k] * p[k];
  return out;
}

double norm(const Triple& v) { return std::hypot(v[0], v[1], v[2]); }

/// The distance between the images of a probe under two matrices.
double distance(const AffineRows& a, const AffineRows& b, const std::array<double, 4>& p) {
  AffineRows difference;
  for (std::size_t k = 0; k < 12; ++k) difference[k] = a[k] - b[k];
  return norm(image_of(difference, p));
}

/// Bound of the rounding error of an image in single precision.
double rounding_error(const AffineRows& m, const std::array<double, 4>& p) {
  constexpr double kUnitRoundoff = 5.9604645e-8;
  AffineRows absolute;
  for (std::size_t k = 0; k < 12; ++k) absolute[k] = std::fabs(m[k]);
  return kUnitRoundoff * norm(image_of(absolute, {std::fabs(p[0]), std::fabs(p[1]), std::fabs(p[2]), p[3]}));
}

MotionStepRow make_step(const AffineRows& matrix) {
  MotionStepRow row{};
  std::array<float, 12> rounded;
  for (std::size_t k = 0; k < 12; ++k) row.matrix[k] = rounded[k] = static_cast<float>(matrix[k]);
  if (!is_usable_instance(rounded)) throw SceneError("the transform of a moving object is singular or too extreme");
  return row;
}

bool is_same(const MotionStepRow& a, const MotionStepRow& b) { return std::equal(a.matrix, a.matrix + 12, b.matrix); }

/// A motion as a function of the time from 0 to 1 over the shutter, with the bounds of its errors.
class ShutterMotion {
 public:
  ShutterMotion(const Motion& motion, const MotionProbes& probes, const ShutterDescription& shutter)
      : motion_(motion), probes_(probes), shutter_(shutter) {
    // Divide the interval at the keys, between which the motion is smooth, and find the lengths of the motion
    std::vector<double> times{0};
    for (const double key : motion.transform.key_times())
      if (key > shutter.open && key < shutter.close)
        times.push_back((key - shutter.open) / (shutter.close - shutter.open));
    times.push_back(1);
    for (std::size_t i = 0; i + 1 < times.size(); ++i)
      for (const double t : {0.0, 0.21, 0.5, 0.83}) add_sample(times[i] + t * (times[i + 1] - times[i]));
    add_sample(1);
    for (const MotionProbes::Probe& probe : probes.probes()) {
      double longest = 0;
      for (const Sample& sample : samples_)
        longest = std::max(longest, distance(sample.matrix, samples_[0].matrix, probe.p));
      lengths_.push_back(longest);
    }
  }

  AffineRows at(double t) const {
    const double time = shutter_.open + t * (shutter_.close - shutter_.open);
    return affine_rows(motion_.transform.at(time) * motion_.before);
  }
  /// The matrices at the ends of `segments` equal parts.
  std::vector<AffineRows> steps(int segments) const {
    std::vector<AffineRows> out;
    for (int i = 0; i <= segments; ++i) out.push_back(at(double(i) / segments));
    return out;
  }
  /// The largest error of linear interpolation between these steps, over its bound. Returns early if it exceeds `stop`.
  double error_ratio(const std::vector<AffineRows>& steps, double stop) const {
    double worst = 0;
    for (std::size_t i = 0; i < samples_.size() && worst <= stop; ++i)
      worst = std::max(worst, error_ratio_at(steps, samples_[i]));
    const auto segments = static_cast<double>(steps.size() - 1);
    for (std::size_t i = 0; i + 1 < steps.size() && worst <= stop; ++i)
      for (const double t : {0.21, 0.5, 0.83}) {
        const double time = (static_cast<double>(i) + t) / segments;
        worst = std::max(worst, error_ratio_at(steps, {time, at(time)}));
      }
    return worst;
  }

 private:
  /// The exact matrix at a time.
  struct Sample {
    double time;
    AffineRows matrix;
  };

  void add_sample(double time) { samples_.push_back({time, at(time)}); }

  double error_ratio_at(const std::vector<AffineRows>& steps, const Sample& exact) const {
    const double scaled = exact.time * static_cast<double>(steps.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(scaled), steps.size() - 2);
    const double t = scaled - static_cast<double>(i);
    AffineRows between;
    for (std::size_t k = 0; k < 12; ++k) between[k] = (1 - t) * steps[i][k] + t * steps[i + 1][k];
    const double size = probes_.size_under(exact.matrix);
    double worst = 0;
    for (std::size_t k = 0; k < lengths_.size(); ++k) {
      const MotionProbes::Probe& probe = probes_.probes()[k];
      const bool is_point = probe.p[3] == 1;
      const double other =
          is_point ? MotionProbes::kMaxError * size : probe.max_relative_error * norm(image_of(exact.matrix, probe.p));
      const double allowed =
          std::max(std::min(MotionProbes::kMaxError * lengths_[k], other), rounding_error(exact.matrix, probe.p));
      const double error = distance(between, exact.matrix, probe.p);
      if (error > 0) worst = std::max(worst, error / allowed);
    }
    return worst;
  }

  const Motion& motion_;
  const MotionProbes& probes_;
  const ShutterDescription& shutter_;
  std::vector<Sample> samples_;
  std::vector<double> lengths_;  ///< how far each probe moves
};

/// The steps of a motion, as few as are accurate: their number of segments is a power of two, or a multiple of
/// `with_keys` by one.
std::vector<AffineRows> fewest_steps(const ShutterMotion& motion, int with_keys) {
  std::vector<int> counts;
  for (int n = 1; n <= kMaxMotionSegments; n *= 2) counts.push_back(n);
  int last = kMaxMotionSegments;
  for (int n = with_keys; n <= kMaxMotionSegments; n *= 2) counts.push_back(last = n);
  std::sort(counts.begin(), counts.end());
  for (const int segments : counts) {
    std::vector<AffineRows> steps = motion.steps(segments);
    if (motion.error_ratio(steps, 1) <= 1) return steps;
  }
  // None is accurate: choose between the largest numbers
  std::vector<AffineRows> steps = motion.steps(kMaxMotionSegments);
  std::vector<AffineRows> at_keys = motion.steps(last);
  const double error = motion.error_ratio(steps, kInfinity);
  return motion.error_ratio(at_keys, error) < error ? at_keys : steps;
}

}  // namespace

MotionProbes MotionProbes::of_box(const Bounds3f& box) {
  MotionProbes out;
  const Vec3f size = box.max - box.min;
  for (int i = 0; i < 8; ++i) out.add_point(box.corner(i));
  out.add_point(box.min + size * 0.5f);
  for (int i = 0; i < 4; ++i)
    out.diagonals_.push_back({(i & 1) != 0 ? -size.x : size.x, (i & 2) != 0 ? -size.y : size.y, size.z, 0});
  return out;
}

MotionProbes MotionProbes::of_directions(double max_relative_error) {
  MotionProbes out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Probe probe{{}, max_relative_error};
    probe.p[axis] = 1;
    out.probes_.push_back(probe);
  }
  return out;
}

void MotionProbes::add_point(Vec3f p) { probes_.push_back({{p.x, p.y, p.z, 1}}); }

double MotionProbes::size_under(const std::array<double, 12>& matrix) const {
  double largest = diagonals_.empty() ? double(kInfinity) : 0;
  for (const std::array<double, 4>& diagonal : diagonals_)
    largest = std::max(largest, norm(image_of(matrix, diagonal)));
  return largest;
}

std::vector<MotionStepRow> tabulate_motion(const Motion& motion, const MotionProbes& probes,
                                           const ShutterDescription& shutter) {
  const std::vector<AffineRows> steps =
      shutter.close > shutter.open
          ? fewest_steps(ShutterMotion(motion, probes, shutter),
                         segments_of_keys(motion.transform.key_times(), shutter))
          : std::vector<AffineRows>{affine_rows(motion.transform.at(shutter.open) * motion.before)};
  std::vector<MotionStepRow> out;
  for (const AffineRows& step : steps) out.push_back(make_step(step));
  const auto is_first = [&](const MotionStepRow& step) { return is_same(step, out[0]); };
  if (std::all_of(out.begin(), out.end(), is_first)) out.resize(1);
  return out;
}

std::vector<MotionStepRow> steps_from_rest(const std::vector<MotionStepRow>& steps, const std::array<float, 12>& rest) {
  Matrix4 placed;
  for (std::size_t i = 0; i < 12; ++i) placed.m[i / 4][i % 4] = rest[i];
  const Transform to_rest = Transform(placed).inverse();
  std::vector<MotionStepRow> out;
  for (const MotionStepRow& step : steps) {
    Matrix4 matrix;
    for (std::size_t i = 0; i < 12; ++i) matrix.m[i / 4][i % 4] = step.matrix[i];
    out.push_back(make_step(affine_rows(Transform(matrix) * to_rest)));
  }
  return out;
}

}  // namespace sheaf
