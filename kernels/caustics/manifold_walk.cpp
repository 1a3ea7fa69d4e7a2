// Seeds of chains, and Newton's method on their first direction.
#include "kernels/caustics/manifold_walk.h"

#include "core/sampling/warp.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Iterations of a walk.
constexpr int kMaxIterations = 20;
/// Minimum fraction of a Newton step.
constexpr float kMinStep = 1.0f / 32;
/// Largest change of the first direction in one iteration, as a tangent.
constexpr float kMaxStepAngle = 0.5f;
/// A walk has converged when the step falls below this angle, rad.
constexpr float kConvergedStep = 1e-5f;
/// Error of the last ray, rad, that rounding may prevent from decreasing further.
constexpr float kRoundingError = 1e-5f;
/// Error of the last ray, rad, up to which a small step counts as convergence.
constexpr float kMaxError = 1e-3f;
/// Chains of the same type whose first directions differ by less, rad, are the same.
constexpr float kSameDirection = 3e-4f;
/// Cosine between the last ray of a seed and the direction to the target, below which the seed is rejected.
constexpr float kMinSeedCosine = 0.2f;

/// Deviation of a chain's last ray from the target.
struct Residual {
  float error;        ///< rad; infinite: the target lies behind the ray
  Vec2f step;         ///< Newton step of the first direction
  float determinant;  ///< of the Jacobian
};

Residual residual_of(const DifferentialRay& ray, const ChainTarget& target) {
  const Vec3f d = ray.direction, to = target.is_infinite ? target.position : target.position - ray.origin;
  const float along = dot(to, d);
  if (!(along > 0)) return {kInfinity, {}, 0};
  const Vec3f e = to - d * along;
  const auto frame = Frame<Scalar>::from_normal(d);
  // Columns of the Jacobian: how the point of the ray nearest to the target moves across the ray.
  Vec3f moved[2];
  for (int i = 0; i < 2; ++i)
    moved[i] = target.is_infinite ? ray.d_direction[i] : ray.d_origin[i] + ray.d_direction[i] * along;
  const float a = dot(moved[0], frame.s), b = dot(moved[1], frame.s), c = dot(moved[0], frame.t),
              f = dot(moved[1], frame.t), x = dot(e, frame.s), y = dot(e, frame.t);
  const float determinant = a * f - b * c;
  const float inverse = determinant != 0 ? 1 / determinant : 0.0f;
  return {length(e) / along, {(f * x - b * y) * inverse, (a * y - c * x) * inverse}, determinant};
}

bool has_step(const Residual& r) {
  return std::isfinite(r.error) && std::isfinite(r.step.x) && std::isfinite(r.step.y) && r.determinant != 0;
}

/// A direction near the straight line to the target, for chains through glass.
Vec3f direction_near(const ChainStart& start, const ChainTarget& target, float u, float v, float w) {
  const Vec3f to = normalize(target.is_infinite ? target.position : target.position - start.p);
  const Vec2f disk = square_to_disk<Scalar>(u, v);
  const auto frame = Frame<Scalar>::from_normal(to);
  const float spread = 0.5f * w * w;
  return normalize(to + frame.s * (spread * disk.x) + frame.t * (spread * disk.y));
}

}  // namespace

std::optional<ConnectedChain> walk_to_target(ChainTracer& tracer, const ChainStart& start, const ChainTarget& target,
                                             const ChainType& type, Vec3f direction) {
  DifferentialRay ray = start.ray(direction);
  if (!tracer.follow(type, ray)) return {};
  Residual residual = residual_of(ray, target);
  float step_fraction = 1;
  for (int i = 0; i < kMaxIterations && has_step(residual); ++i) {
    const float size = std::hypot(residual.step.x, residual.step.y);
    const bool converged = size <= kConvergedStep && residual.error <= kMaxError;
    if (converged)
      return ConnectedChain{type, direction, ray.origin, ray.direction, 1 / std::fabs(residual.determinant)};
    // Move the first direction, by half as much until the error decreases
    const auto frame = Frame<Scalar>::from_normal(direction);
    const float limit = std::min(1.0f, kMaxStepAngle / size);
    bool moved = false;
    for (; step_fraction >= kMinStep && !moved; step_fraction *= 0.5f) {
      const float scale = step_fraction * limit;
      const Vec3f next =
          normalize(direction + frame.s * (scale * residual.step.x) + frame.t * (scale * residual.step.y));
      DifferentialRay next_ray = start.ray(next);
      if (!tracer.follow(type, next_ray)) continue;
      const Residual next_residual = residual_of(next_ray, target);
      if (!(next_residual.error < residual.error)) continue;
      direction = next, ray = next_ray, residual = next_residual;
      moved = true;
    }
    if (!moved && residual.error <= kRoundingError)
      return ConnectedChain{type, direction, ray.origin, ray.direction, 1 / std::fabs(residual.determinant)};
    if (!moved) return {};
    step_fraction = std::min(1.0f, 4 * step_fraction);  // the loop has halved it once more
  }
  return {};
}

float solid_angle_ratio_at(const DifferentialRay& last, float t) {
  const float determinant = residual_of(last, {last.origin + last.direction * t, false}).determinant;
  const float ratio = 1 / std::fabs(determinant);
  return std::isfinite(ratio) ? ratio : 0.0f;
}

Vec3f sample_seed_direction(const ChainTracer& tracer, const ChainStart& start, const ChainTarget& target,
                            MediumRandom& random) {
  // Towards a point on a caster, or near the straight line to the target
  const float choice = random.next();
  Random4<Scalar> u{random.next(), random.next(), random.next(), random.next()};
  if (tracer.has_glass() && choice < 0.5f) return direction_near(start, target, u.x, u.y, u.z);
  return normalize(tracer.sample_caster_point(u) - start.p);
}

std::optional<ChainSeed> sample_seed_type(ChainTracer& tracer, const ChainStart& start, const ChainTarget& target,
                                          Vec3f direction, int max_length, MediumRandom& random) {
  ChainSeed seed;
  seed.direction = direction;
  DifferentialRay ray = start.ray(seed.direction);
  SurfaceHit hit = tracer.intersect(ray.origin, ray.direction);
  if (!tracer.is_caster(hit)) return {};
  for (;;) {
    // Choose reflection or refraction as BSDF sampling does
    const CasterHit surface = tracer.surface(ray, hit);
    const float reflection = tracer.reflection_probability(surface, ray.direction);
    const bool refracts = random.next() >= reflection;
    seed.type.add(refracts);
    if (!tracer.scatter(surface, refracts, ray, nullptr)) return {};
    // End in front of other surfaces, and anywhere with a small probability
    if (seed.type.length == max_length || random.next() < 0.1f) break;
    hit = tracer.intersect(ray.origin, ray.direction);
    if (!tracer.is_caster(hit)) break;
  }
  const Vec3f to = target.is_infinite ? target.position : normalize(target.position - ray.origin);
  if (!(dot(ray.direction, to) > kMinSeedCosine)) return {};
  return seed;
}

bool is_same_chain(const ConnectedChain& a, const ConnectedChain& b) {
  return a.type == b.type && length(a.direction - b.direction) < kSameDirection;
}

}  // namespace sheaf
