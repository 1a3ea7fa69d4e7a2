// The kinds of lights.
#pragma once

#include <cstdint>

namespace sheaf {

/// All kinds of lights: those of descriptions, and those compiled from emitting shapes and media. kernels/lights/all.h
/// checks that its list has the same order.
enum class LightKind : std::uint32_t {
  kMesh,
  kSphere,
  kQuadric,  ///< disks, cylinders, and stretched or flipped spheres
  kPoint,
  kSpot,        ///< falloff linear in the angle
  kSmoothSpot,  ///< falloff as a smooth step in the cosine of the angle
  kGoniometric,
  kProjector,
  kBeam,
  kDirectional,
  kSun,  ///< disk infinitely far away
  kConstant,
  kEnvmap,
  kVolume,  ///< emitting medium; must stay last
};
inline constexpr int kLightKinds = static_cast<int>(LightKind::kVolume) + 1;

}  // namespace sheaf
