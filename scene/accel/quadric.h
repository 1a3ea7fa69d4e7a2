// Spheres, disks and cylinders as affine images of canonical shapes, with ray intersection in double precision.
#pragma once

#include "core/math/bounds.h"
#include "core/math/transform.h"
#include "scene/tables/shape_rows.h"

#include <optional>

namespace sheaf {

/// Makes the row for a canonical shape under `to_world`. Throws SceneError if the transform is not affine.
QuadricRow make_quadric(ShapeKind kind, const Transform& to_world, bool flip_normals);

/// World-space bounds, rounded outwards.
Bounds3f quadric_bounds(const QuadricRow& row);

/// Intersection of a ray with a quadric.
struct QuadricHit {
  float t;
  Vec3f normal;  ///< world space; outwards unless flipped; any length
};

/// Nearest intersection with t in (t_near, t_far).
std::optional<QuadricHit> intersect_quadric(const QuadricRow& row, Vec3f origin, Vec3f direction, float t_near,
                                            float t_far) noexcept;

/// Area of the canonical shape: 4 pi, pi or 2 pi.
float canonical_area(ShapeKind kind);

/// Area in world space, in closed form for any affine transform.
float quadric_area(const QuadricRow& row);

}  // namespace sheaf
