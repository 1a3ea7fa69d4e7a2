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

/// Any camera, prepared for rays: origins and directions are affine in the positions on film and lens. What a kind of
/// camera has no use for is zero. World space; film positions are in pixels, y downwards, (0, 0) the upper left corner
/// of the frame.
struct Camera {
  Vec3f origin{};                         ///< where rays through the film's corner and the lens's centre pass z = 0
  Vec3f origin_dx{}, origin_dy{};         ///< its change with the film position: orthographic cameras
  Vec3f corner{};                         ///< step from z = 0 to z = 1 on the ray through the film's corner
  Vec3f dx{}, dy{};                       ///< its change with the film position: perspective cameras
  Vec3f lens_x{}, lens_y{};               ///< the lens's radii
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
};

/// Prepares a camera for a frame of width x height pixels. Throws SceneError for a field of view outside (0, 180), clip
/// distances out of order, a negative aperture or a focus distance that is not positive.
Camera make_camera(const CameraDescription& description, int width, int height);

/// tan of half the horizontal field of view, for `fov` degrees along the axis. Throws SceneError at `where` outside of
/// (0, 180).
double half_width_of(float fov, CameraDescription::FovAxis axis, double width, double height,
                     const SourceLocation& where);

}  // namespace sheaf
