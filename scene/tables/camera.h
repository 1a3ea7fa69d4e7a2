// Cameras: from a position on the film and one on the lens to a ray.
#pragma once

#include "core/vec.h"
#include "core/warp.h"
#include "scene/description/description.h"

namespace sheaf {

/// A ray of a camera.
template <class L> struct CameraRay {
  Vec3<L> origin;             ///< world space, on the near plane
  Vec3<L> direction;          ///< normalised
  typename L::Float t_max;    ///< distance to the far plane
};

/// Where a point is seen, and how much a camera makes of the light that it sends there.
template <class L> struct CameraView {
  typename L::Float film_x, film_y;  ///< film position, pixels
  Vec3<L> target;                    ///< where the ray from the camera to the point starts: on the near plane
  /// Film area, square pixels, per area at the point across the ray: a surface that sends the radiance L adds
  /// L |cos| dA times this to the integral of radiance over the film.
  typename L::Float importance;
  typename L::Mask valid;  ///< false: the point lies behind the camera or not between the clip planes
};

/// Any camera, prepared for rays: origins and directions are affine in the positions on film and lens. What a kind of
/// camera has no use for is zero. World space; film positions are in pixels, y downwards, (0, 0) the upper left corner
/// of the frame.
struct Camera {
  Vec3f origin{};                         ///< where rays through the film's corner and the lens's centre pass z = 0
  Vec3f origin_dx{}, origin_dy{};         ///< its change with the film position: orthographic cameras
  Vec3f corner{};                         ///< step from z = 0 to z = 1 on the ray through the film's corner
  Vec3f dx{}, dy{};                       ///< its change with the film position: perspective cameras
  Vec3f lens_x{}, lens_y{};               ///< the lens's radii
  Vec3f z_axis{};                         ///< z of a point is its product with what lies between `origin` and the point
  float inverse_focus_distance = 0;       ///< of the plane, across z, in which the picture is sharp
  float near_clip = 0, clip_range = kInfinity;  ///< z of the near plane, and from there to the far plane

  /// Whether rays depend on the lens position.
  bool has_lens() const { return !(lens_x == Vec3f{0, 0, 0} && lens_y == Vec3f{0, 0, 0}); }

  /// The ray through the film position (x, y) and the position (u, v) on the lens, a point of the unit disk.
  template <class L>
  SHEAF_INLINE CameraRay<L> ray(typename L::Float x, typename L::Float y, typename L::Float u,
                                typename L::Float v) const {
    using F = typename L::Float;
    const Vec3<L> lens = broadcast<L>(lens_x) * u + broadcast<L>(lens_y) * v;
    const Vec3<L> start = broadcast<L>(origin) + broadcast<L>(origin_dx) * x + broadcast<L>(origin_dy) * y + lens;
    const Vec3<L> step =
        broadcast<L>(corner) + broadcast<L>(dx) * x + broadcast<L>(dy) * y - lens * F(inverse_focus_distance);
    const F length = sheaf::length(step);
    return {start + step * F(near_clip), step * (F(1.0f) / length), length * F(clip_range)};
  }

  /// Which ray through the position (u, v) on the lens, as in ray(), meets the point `p`. At the depth z, the film is
  /// spread over a parallelogram whose sides grow with z, one for each pixel's step in x and in y: p's place on it is
  /// the film position, and its area per pixel what the importance is made of.
  template <class L> SHEAF_INLINE CameraView<L> view(Vec3<L> p, typename L::Float u, typename L::Float v) const {
    using F = typename L::Float;
    const Vec3<L> lens = broadcast<L>(lens_x) * u + broadcast<L>(lens_y) * v;
    const Vec3<L> from = p - broadcast<L>(origin);
    const F z = dot(from, broadcast<L>(z_axis));
    const Vec3<L> side_x = broadcast<L>(origin_dx) + broadcast<L>(dx) * z;
    const Vec3<L> side_y = broadcast<L>(origin_dy) + broadcast<L>(dy) * z;
    const Vec3<L> axis = broadcast<L>(corner) - lens * F(inverse_focus_distance);
    const Vec3<L> across = cross(side_x, side_y), place = from - lens - axis * z;
    const F area = length(across);
    CameraView<L> out;
    out.valid = (z > F(near_clip)) & (z - F(near_clip) < F(clip_range)) & (area > F(0.0f)) & is_finite(area);
    const F scale = F(1.0f) / select(out.valid, area * area, F(1.0f));
    out.film_x = dot(cross(place, side_y), across) * scale;
    out.film_y = dot(cross(side_x, place), across) * scale;
    const Vec3<L> start =
        broadcast<L>(origin) + broadcast<L>(origin_dx) * out.film_x + broadcast<L>(origin_dy) * out.film_y + lens;
    const Vec3<L> step = axis + broadcast<L>(dx) * out.film_x + broadcast<L>(dy) * out.film_y;
    out.target = start + step * F(near_clip);
    // One over the cosine between the ray and the film's normal is the step's length, in units of its length along it.
    out.importance = length(step) * length(broadcast<L>(z_axis)) / select(out.valid, area, F(1.0f));
    return out;
  }
};

/// Prepares a camera for a frame of width x height pixels. Throws SceneError for a field of view outside (0, 180), clip
/// distances out of order, a negative aperture or a focus distance that is not positive.
Camera make_camera(const CameraDescription& description, int width, int height);

/// tan of half the horizontal field of view, for `fov` degrees along the axis. Throws SceneError at `where` outside of
/// (0, 180).
double half_width_of(float fov, CameraDescription::FovAxis axis, double width, double height,
                     const SourceLocation& where);

}  // namespace sheaf
