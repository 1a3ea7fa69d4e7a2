// Cameras and sensors of a scene.
#pragma once

#include "core/io/error.h"
#include "core/math/transform.h"
#include "scene/description/inputs.h"
#include "scene/description/motion.h"

#include <array>
#include <optional>
#include <variant>

namespace sheaf {

/// A camera with a pinhole or a thin lens, an orthographic or spherical camera, or a sensor that forms no image.
struct CameraDescription {
  enum class Projection {
    kPerspective,
    kOrthographic,     ///< with a lens, the rays through the lens center are parallel
    kSpherical,        ///< all directions by longitude and latitude, in the layout of EnvmapDescription
    kRadianceMeter,    ///< a ray along +z
    kDistant,          ///< rays along +z from outside the scene, to `target` or across the scene's bounding sphere
    kIrradianceMeter,  ///< mean irradiance over [-1, 1]^2 of the xy plane, on the side of +z
  } projection = Projection::kPerspective;
  /// Camera space looks along +z; +y is up, +x points left in the image. Orthographic: the width of the image spans x
  /// in [-1, 1].
  Transform to_world;
  /// Field of view along fov_axis, degrees. The default is that of a 50 mm lens on 35 mm film.
  float fov = 39.3077f;
  enum class FovAxis { kX, kY, kDiagonal, kSmaller, kLarger } fov_axis = FovAxis::kX;
  float aperture_radius = 0;         ///< radius of the lens in camera space; 0: pinhole
  float focus_distance = kInfinity;  ///< z of the focal plane in camera space
  /// Film position of the direction (0, 0, 1): offset from the center to the left and upwards, in fractions of the
  /// film's size.
  float principal_point_x = 0, principal_point_y = 0;
  float near_clip = 0, far_clip = kInfinity;  ///< visible range of z in camera space
  /// Radial distortion, perspective cameras without a lens (Bouguet's kc). A point at tangent r of the angle to the
  /// axis appears at tangent r (1 + distortion[0] r^2 + distortion[1] r^4).
  std::array<float, 2> distortion{0, 0};
  bool equal_area = false;  ///< kSpherical: use the layout EnvmapDescription::Layout::kOctahedral instead
  /// kDistant: a point, or the area [-1, 1]^2 or the unit disk of the xy plane of a local space.
  struct TargetArea {
    Transform to_world;
    bool round = false;
  };
  std::variant<std::monostate, Vec3d, TargetArea> target = {};
  std::optional<MediumId> medium;  ///< medium that contains the camera; empty: found from the surrounding shapes
  std::optional<MotionId> motion;
  SourceLocation where;
};

}  // namespace sheaf
