// Camera models: map positions on film and lens to rays, and points to film positions.
#pragma once

#include "core/math/vec.h"
#include "core/sampling/octahedral.h"
#include "core/sampling/warp.h"

namespace sheaf {

/// A camera ray.
template <class L> struct CameraRay {
  Vec3<L> origin;           ///< world space, on the near plane
  Vec3<L> direction;        ///< normalized
  typename L::Float t_max;  ///< distance to the far plane
};

/// The projection of a point to the film, with the camera's importance.
template <class L> struct CameraView {
  typename L::Float film_x, film_y;  ///< film position, pixels
  Vec3<L> target;                    ///< start of the ray from the camera to the point, on the near plane
  /// Film area in square pixels per surface area perpendicular to the ray. A surface element dA with radiance L adds L
  /// |cos| dA times this to the integral of radiance over the film.
  typename L::Float importance;
  typename L::Mask valid;  ///< false: the point lies behind the camera or outside the clip planes
};

/// Dependence of directions on the film and lens positions.
enum class CameraRays {
  kAffine,      ///< affine in both
  kDistorted,   ///< affine in the film position after Camera::undistorted()
  kSpherical,   ///< latitude-longitude panorama
  kEqualArea,   ///< equal-area octahedral panorama (Clarberg 2008)
  kHemisphere,  ///< cosine-distributed around `corner`, from the lens position
};

/// A camera of any kind, prepared for rays. Origins are affine in the film and lens positions; directions are too,
/// except as CameraRays says. Members that a kind does not use are zero. World space; film positions are in pixels, y
/// downwards, with (0, 0) at the upper left corner of the frame.
struct Camera {
  Vec3f origin{};                    ///< point at z = 0 of the ray through the film's corner and the lens center
  Vec3f origin_dx{}, origin_dy{};    ///< derivative by film position; orthographic cameras
  Vec3f corner{};                    ///< vector from z = 0 to z = 1 on the ray through the film's corner
  Vec3f dx{}, dy{};                  ///< derivative by film position; perspective cameras
  Vec3f lens_x{}, lens_y{};          ///< semi-axes of the lens
  Vec3f z_axis{};                    ///< dot product with a point relative to `origin` gives its z
  float inverse_focus_distance = 0;  ///< reciprocal z of the focal plane
  float near_clip = 0, clip_range = kInfinity;  ///< z of the near plane, and distance in z to the far plane
  CameraRays rays = CameraRays::kAffine;
  /// kDistorted: vector from z = 0 to z = 1 along the axis. kSpherical: unit direction at the middle of the film;
  /// lens_x is the unit direction a quarter turn from it, lens_y points up. kEqualArea: forward, lens_x and lens_y are
  /// the map's +z, +x and +y.
  Vec3f forward{};
  /// kDistorted: a point at tangent r of the angle to the axis appears at r (1 + distortion[0] r^2 + distortion[1]
  /// r^4).
  float distortion[2] = {};
  /// kDistorted: x and y at z = 1 of the film's corner, and their change per pixel. kSpherical: full turns and half
  /// turns per pixel. kEqualArea: fractions of the square per pixel.
  Vec2f film_corner{}, film_step{};
  float weight = 1;         ///< factor from radiance to the measured quantity
  bool sees_points = true;  ///< whether view() works: points project to film positions

  bool is_panorama() const { return rays == CameraRays::kSpherical || rays == CameraRays::kEqualArea; }
  /// Whether rays depend on the lens position.
  bool has_lens() const { return !is_panorama() && !(lens_x == Vec3f{0, 0, 0} && lens_y == Vec3f{0, 0, 0}); }

  /// The ray through the film position (x, y) and the lens position (u, v), a point of the unit disk.
  template <class L>
  SHEAF_INLINE CameraRay<L> ray(typename L::Float x, typename L::Float y, typename L::Float u,
                                typename L::Float v) const {
    using F = typename L::Float;
    if (is_panorama() || rays == CameraRays::kHemisphere) return rotated_ray<L>(x, y, u, v);
    const Vec3<L> lens = broadcast<L>(lens_x) * u + broadcast<L>(lens_y) * v;
    const Vec3<L> start = broadcast<L>(origin) + broadcast<L>(origin_dx) * x + broadcast<L>(origin_dy) * y + lens;
    Vec3<L> step =
        broadcast<L>(corner) + broadcast<L>(dx) * x + broadcast<L>(dy) * y - lens * F(inverse_focus_distance);
    if (rays == CameraRays::kDistorted)
      step = broadcast<L>(forward) + (step - broadcast<L>(forward)) * undistorted<L>(x, y);
    const F length = sheaf::length(step);
    return {start + step * F(near_clip), step * (F(1.0f) / length), length * F(clip_range)};
  }

  /// Projects the point `p` through the lens position (u, v), as in ray(). At depth z, the film projects to a
  /// parallelogram whose sides grow with z, one for each pixel step in x and y. The position of p on it gives the film
  /// position; its area per pixel gives the importance.
  template <class L> SHEAF_INLINE CameraView<L> view(Vec3<L> p, typename L::Float u, typename L::Float v) const {
    using F = typename L::Float;
    if (is_panorama()) return rotated_view<L>(p);
    const Vec3<L> lens = broadcast<L>(lens_x) * u + broadcast<L>(lens_y) * v;
    const Vec3<L> from = p - broadcast<L>(origin);
    const F z = dot(from, broadcast<L>(z_axis));
    const Vec3<L> side_x = broadcast<L>(origin_dx) + broadcast<L>(dx) * z;
    const Vec3<L> side_y = broadcast<L>(origin_dy) + broadcast<L>(dy) * z;
    const Vec3<L> axis = broadcast<L>(corner) - lens * F(inverse_focus_distance);
    const Vec3<L> across = cross(side_x, side_y), position = from - lens - axis * z;
    const F area = length(across);
    CameraView<L> out;
    out.valid = (z > F(near_clip)) & (z - F(near_clip) < F(clip_range)) & (area > F(0.0f)) & is_finite(area);
    const F scale = F(1.0f) / select(out.valid, area * area, F(1.0f));
    out.film_x = dot(cross(position, side_y), across) * scale;
    out.film_y = dot(cross(side_x, position), across) * scale;
    const Vec3<L> start =
        broadcast<L>(origin) + broadcast<L>(origin_dx) * out.film_x + broadcast<L>(origin_dy) * out.film_y + lens;
    const Vec3<L> step = axis + broadcast<L>(dx) * out.film_x + broadcast<L>(dy) * out.film_y;
    out.target = start + step * F(near_clip);
    // One over the cosine between the ray and the film's normal is the step's length over its component along the
    // normal.
    out.importance = length(step) * length(broadcast<L>(z_axis)) / select(out.valid, area, F(1.0f));
    if (rays == CameraRays::kDistorted) distort<L>(out);
    return out;
  }

 private:
  /// Ratio of the undistorted to the distorted tangent at a film position: inverts `distortion` by Newton's method.
  template <class L> SHEAF_INLINE Float<L> undistorted(Float<L> x, Float<L> y) const {
    using F = Float<L>;
    const F px = fma(F(film_step.x), x, F(film_corner.x)), py = fma(F(film_step.y), y, F(film_corner.y));
    const F displayed = max(sqrt(px * px + py * py), F(1e-20f));
    F r = displayed;
    for (int i = 0; i < 8; ++i) {
      const F r2 = r * r;
      const F error = r * fma(fma(r2, F(distortion[1]), F(distortion[0])), r2, F(1.0f)) - displayed;
      r = r - error / fma(fma(r2, F(5.0f * distortion[1]), F(3.0f * distortion[0])), r2, F(1.0f));
    }
    return r / displayed;
  }

  /// Applies the distortion to a view. The film area scales by the radial and the tangential factor.
  template <class L> SHEAF_INLINE void distort(CameraView<L>& view) const {
    using F = Float<L>;
    const F px = fma(F(film_step.x), view.film_x, F(film_corner.x));
    const F py = fma(F(film_step.y), view.film_y, F(film_corner.y));
    const F r2 = px * px + py * py;
    const F tangential = fma(fma(r2, F(distortion[1]), F(distortion[0])), r2, F(1.0f));
    const F radial = fma(fma(r2, F(5.0f * distortion[1]), F(3.0f * distortion[0])), r2, F(1.0f));
    view.film_x = (px * tangential - F(film_corner.x)) * F(1.0f / film_step.x);
    view.film_y = (py * tangential - F(film_corner.y)) * F(1.0f / film_step.y);
    view.importance = view.importance * tangential * radial;
    view.valid = view.valid & (tangential > F(0.0f)) & (radial > F(0.0f));
  }

  template <class L> SHEAF_INLINE CameraRay<L> rotated_ray(Float<L> x, Float<L> y, Float<L> u, Float<L> v) const {
    using F = Float<L>;
    const Vec3<L> start = broadcast<L>(origin) + broadcast<L>(origin_dx) * x + broadcast<L>(origin_dy) * y;
    Vec3<L> direction;
    if (rays == CameraRays::kSpherical) {
      const F across = x * F(film_step.x), down = clamp(y * F(film_step.y), F(0.0f), F(1.0f));
      const auto longitude = sincos_2pi<L>(across - floor(across)), polar = sincos_2pi<L>(down * F(0.5f));
      direction = (broadcast<L>(lens_x) * longitude.sin + broadcast<L>(forward) * -longitude.cos) * polar.sin +
                  broadcast<L>(lens_y) * polar.cos;
    } else if (rays == CameraRays::kEqualArea) {
      const auto inside = [](F position) SHEAF_LAMBDA_INLINE { return clamp(position, F(0.0f), F(1.0f)); };
      const Vec3<L> local = equal_area_direction<L>(inside(x * F(film_step.x)), inside(y * F(film_step.y)));
      direction = broadcast<L>(lens_x) * local.x + broadcast<L>(lens_y) * local.y + broadcast<L>(forward) * local.z;
    } else {
      const F z = safe_sqrt(F(1.0f) - fma(u, u, v * v));
      direction = broadcast<L>(lens_x) * u + broadcast<L>(lens_y) * v + broadcast<L>(corner) * z;
    }
    direction = normalize(direction);
    return {start + direction * F(near_clip), direction, F(clip_range)};
  }

  /// The film area per solid angle is W H / (2 pi^2 sin theta), or W H / (4 pi) for the equal-area map.
  template <class L> SHEAF_INLINE CameraView<L> rotated_view(Vec3<L> p) const {
    using F = Float<L>;
    const Vec3<L> from = p - broadcast<L>(origin);
    const F squared = dot(from, from);
    const F x = dot(from, broadcast<L>(lens_x)), y = dot(from, broadcast<L>(lens_y)),
            z = dot(from, broadcast<L>(forward));
    if (rays == CameraRays::kEqualArea) {
      CameraView<L> out;
      out.valid = (squared > F(0.0f)) & is_finite(squared);
      const F inverse = F(1.0f) / select(out.valid, squared, F(1.0f)), length_inverse = sqrt(inverse);
      const Vec2<L> position = equal_area_octahedral<L>(Vec3<L>{x, y, z} * length_inverse);
      out.film_x = position.x * F(1.0f / film_step.x);
      out.film_y = position.y * F(1.0f / film_step.y);
      out.target = broadcast<L>(origin);
      out.importance = F(0.25f * kInvPi / (film_step.x * film_step.y)) * inverse;
      return out;
    }
    const F sine = sqrt(x * x + z * z);
    const F azimuth = atan2(x, -z) * F(0.5f * kInvPi);
    CameraView<L> out;
    out.film_x = (azimuth - floor(azimuth)) * F(1.0f / film_step.x);
    out.film_y = atan2(sine, y) * F(kInvPi / film_step.y);
    out.target = broadcast<L>(origin);
    out.valid = (sine > F(0.0f)) & is_finite(squared);
    const F scale(0.5f * kInvPi * kInvPi / (film_step.x * film_step.y));
    out.importance = scale / select(out.valid, sine * sqrt(squared), F(1.0f));
    return out;
  }
};

}  // namespace sheaf
