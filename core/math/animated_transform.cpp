// Polar decomposition of affine transforms, and their interpolation over time.
#include "core/math/animated_transform.h"

#include "core/io/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

using Linear3 = std::array<std::array<double, 3>, 3>;

double determinant(const Linear3& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/// The inverse transpose times the determinant.
Linear3 cofactors(const Linear3& m) {
  Linear3 c;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      c[i][j] = m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
    }
  return c;
}

double squared_norm(const Linear3& m) {
  double sum = 0;
  for (const auto& row : m)
    for (const double x : row) sum += x * x;
  return sum;
}

/// The orthogonal factor of the polar decomposition, by Newton's method with scaling (Higham 1986, "Computing the Polar
/// Decomposition"). It reflects if `m` does.
Linear3 orthogonal_factor(Linear3 m) {
  constexpr int kMaxIterations = 100;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Linear3 adjugate = cofactors(m);
    const double det = determinant(m);
    const double scale = std::sqrt(std::sqrt(squared_norm(adjugate) / squared_norm(m)) / std::fabs(det));
    Linear3 next;
    double change = 0;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t c = 0; c < 3; ++c) {
        next[r][c] = 0.5 * (scale * m[r][c] + adjugate[r][c] / (scale * det));
        change += std::fabs(next[r][c] - m[r][c]);
      }
    m = next;
    if (!(change > 1e-14)) break;
  }
  return m;
}

/// The quaternion of a rotation (Shepperd 1978).
Quaternion to_quaternion(const Linear3& r) {
  const double trace = r[0][0] + r[1][1] + r[2][2];
  // Compute the largest component first, by which the others are divided
  std::size_t largest = 0;
  double square = 1 - trace + 2 * r[0][0];
  for (std::size_t k = 1; k < 3; ++k)
    if (1 - trace + 2 * r[k][k] > square) largest = k, square = 1 - trace + 2 * r[k][k];
  if (1 + trace > square) {
    const double w = std::sqrt(1 + trace) / 2, scale = 0.25 / w;
    return {(r[2][1] - r[1][2]) * scale, (r[0][2] - r[2][0]) * scale, (r[1][0] - r[0][1]) * scale, w};
  }
  const std::size_t i = largest, j = (i + 1) % 3, k = (i + 2) % 3;
  double v[3];
  v[i] = std::sqrt(std::max(square, 0.0)) / 2;
  const double scale = 0.25 / v[i];
  v[j] = (r[i][j] + r[j][i]) * scale;
  v[k] = (r[i][k] + r[k][i]) * scale;
  return {v[0], v[1], v[2], (r[k][j] - r[j][k]) * scale};
}

Linear3 to_matrix(const Quaternion& q) {
  return {{{1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y - q.z * q.w), 2 * (q.x * q.z + q.y * q.w)},
           {2 * (q.x * q.y + q.z * q.w), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z - q.x * q.w)},
           {2 * (q.x * q.z - q.y * q.w), 2 * (q.y * q.z + q.x * q.w), 1 - 2 * (q.x * q.x + q.y * q.y)}}};
}

/// Spherical linear interpolation along the shorter arc.
Quaternion slerp(const Quaternion& a, Quaternion b, double t) {
  double cosine = a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
  if (cosine < 0) {
    b = {-b.x, -b.y, -b.z, -b.w};
    cosine = -cosine;
  }
  double of_a = 1 - t, of_b = t;
  const double angle = std::acos(std::min(cosine, 1.0)), sine = std::sin(angle);
  if (sine > 1e-6) {
    of_a = std::sin((1 - t) * angle) / sine;
    of_b = std::sin(t * angle) / sine;
  }
  const Quaternion q{of_a * a.x + of_b * b.x, of_a * a.y + of_b * b.y, of_a * a.z + of_b * b.z,
                     of_a * a.w + of_b * b.w};
  const double scale = 1 / std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {q.x * scale, q.y * scale, q.z * scale, q.w * scale};
}

}  // namespace

DecomposedTransform decompose(const Transform& transform) {
  const auto& m = transform.matrix().m;
  DecomposedTransform out;
  Linear3 linear;
  for (std::size_t r = 0; r < 3; ++r) {
    out.translation[r] = m[r][3];
    for (std::size_t c = 0; c < 3; ++c) linear[r][c] = m[r][c];
  }
  // Split off the rotation; a reflection goes into the stretch
  Linear3 rotation = orthogonal_factor(linear);
  if (determinant(rotation) < 0)
    for (auto& row : rotation)
      for (double& x : row) x = -x;
  out.rotation = to_quaternion(rotation);
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 3; ++c) {
      out.stretch[r][c] = 0;
      for (std::size_t k = 0; k < 3; ++k) out.stretch[r][c] += rotation[k][r] * linear[k][c];
    }
  return out;
}

Transform compose(const DecomposedTransform& parts) {
  const Linear3 rotation = to_matrix(parts.rotation);
  Matrix4 m;
  for (std::size_t r = 0; r < 3; ++r) {
    m.m[r][3] = parts.translation[r];
    for (std::size_t c = 0; c < 3; ++c) {
      m.m[r][c] = 0;
      for (std::size_t k = 0; k < 3; ++k) m.m[r][c] += rotation[r][k] * parts.stretch[k][c];
    }
  }
  return Transform(m);
}

DecomposedTransform interpolate(const DecomposedTransform& a, const DecomposedTransform& b, double t) {
  DecomposedTransform out;
  out.rotation = slerp(a.rotation, b.rotation, t);
  for (std::size_t r = 0; r < 3; ++r) {
    out.translation[r] = (1 - t) * a.translation[r] + t * b.translation[r];
    for (std::size_t c = 0; c < 3; ++c) out.stretch[r][c] = (1 - t) * a.stretch[r][c] + t * b.stretch[r][c];
  }
  return out;
}

AnimatedTransform::AnimatedTransform(const Transform& value) { tracks_.push_back({value, {}}); }

AnimatedTransform::AnimatedTransform(std::vector<Key> keys) {
  if (keys.empty()) throw SceneError("an animated transform needs at least one key");
  for (const Key& key : keys)
    if (!std::isfinite(key.time)) throw SceneError("the time of a key must be finite");
  std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) { return a.time < b.time; });
  Track track{keys.front().value, {}};
  for (std::size_t i = 1; i < keys.size(); ++i)
    if (keys[i].time == keys[i - 1].time)
      throw SceneError(fmt::format("two keys of an animated transform have the time {}", keys[i].time));
  if (keys.size() > 1)
    for (const Key& key : keys) track.keys.push_back({key.time, decompose(key.value)});
  tracks_.push_back(std::move(track));
}

AnimatedTransform AnimatedTransform::operator*(const AnimatedTransform& b) const {
  AnimatedTransform out = *this;
  for (const Track& track : b.tracks_) {
    // Two constant tracks become one
    if (track.keys.empty() && !out.tracks_.empty() && out.tracks_.back().keys.empty())
      out.tracks_.back().constant = out.tracks_.back().constant * track.constant;
    else
      out.tracks_.push_back(track);
  }
  return out;
}

Transform AnimatedTransform::Track::at(double time) const {
  if (keys.empty()) return constant;
  const auto after =
      std::upper_bound(keys.begin(), keys.end(), time, [](double t, const TrackKey& key) { return t < key.time; });
  if (after == keys.begin()) return compose(keys.front().value);
  if (after == keys.end()) return compose(keys.back().value);
  const auto before = after - 1;
  const double t = (time - before->time) / (after->time - before->time);
  return compose(interpolate(before->value, after->value, t));
}

Transform AnimatedTransform::at(double time) const {
  Transform out;
  for (const Track& track : tracks_) out = out * track.at(time);
  return out;
}

Transform AnimatedTransform::reference() const {
  const std::vector<double> times = key_times();
  return at(times.empty() ? 0.0 : times.front());
}

bool AnimatedTransform::moves() const {
  return std::any_of(tracks_.begin(), tracks_.end(), [](const Track& track) { return !track.keys.empty(); });
}

std::vector<double> AnimatedTransform::key_times() const {
  std::vector<double> times;
  for (const Track& track : tracks_)
    for (const TrackKey& key : track.keys) times.push_back(key.time);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

}  // namespace sheaf
