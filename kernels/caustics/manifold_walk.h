// Manifold walks: from a seed, Newton's method finds the chain of specular vertices that connects a vertex to a point
// on a light (Jakob and Marschner 2012; Hanika, Droske and Fascione 2015; Zeltner, Georgiev and Jakob 2020).
//
// The unknowns are the two coordinates of the chain's first direction. Each iteration traces the chain along that
// direction, so that it satisfies the laws of reflection and refraction, and its first surfaces are visible. The
// residual is the distance between its last ray and the light point, and its Jacobian follows from the ray's
// differentials. At the solution, the determinant of the Jacobian is the generalized geometry term.
#pragma once

#include "kernels/caustics/specular_chain.h"
#include "kernels/media/medium_random.h"
#include "scene/surfaces/shape.h"

#include <optional>

namespace sheaf {

/// The end of a chain: a point on a light, or a direction towards a light at infinity.
struct ChainTarget {
  Vec3f position;  ///< the point, or the unit vector towards the light
  bool is_infinite = false;
};

/// The vertex that a chain starts from.
struct ChainStart {
  Vec3f p, ng;   ///< position and geometric normal
  float offset;  ///< see SurfacePoint::offset

  DifferentialRay ray(Vec3f direction) const {
    return start_ray(offset_origin<Scalar>(p, ng, offset, direction), direction);
  }
};

/// A chain that connects a vertex to its target.
struct ConnectedChain {
  ChainType type;
  Vec3f direction;     ///< from the vertex, unit length
  Vec3f origin, last;  ///< the ray from the last specular vertex; unit length
  /// Solid angle of `direction` per area perpendicular to `last` at the target, sr/m^2; for targets at infinity per
  /// solid angle of `last`.
  float solid_angle_ratio;
};

/// Improves a seed until its chain reaches the target. Empty if the walk does not converge.
std::optional<ConnectedChain> walk_to_target(ChainTracer& tracer, const ChainStart& start, const ChainTarget& target,
                                             const ChainType& type, Vec3f direction);

/// ConnectedChain::solid_angle_ratio of a chain's last ray, for a point at distance `t` along it; 0 if it is not
/// finite.
float solid_angle_ratio_at(const DifferentialRay& last, float t);

/// A random seed: the first direction and the type of a chain.
struct ChainSeed {
  ChainType type;
  Vec3f direction;
};
/// The first direction of a seed, of unit length; may not be finite. Together with sample_seed_type(), each chain of at
/// most `max_length` vertices has a positive density in its neighborhood.
Vec3f sample_seed_direction(const ChainTracer& tracer, const ChainStart& start, const ChainTarget& target,
                            MediumRandom& random);
/// Samples the type of a seed with a finite direction. Empty if no chain begins in that direction.
std::optional<ChainSeed> sample_seed_type(ChainTracer& tracer, const ChainStart& start, const ChainTarget& target,
                                          Vec3f direction, int max_length, MediumRandom& random);

/// Whether two walks have found the same chain.
bool is_same_chain(const ConnectedChain& a, const ConnectedChain& b);

}  // namespace sheaf
