// Common code of lights at a point with an orientation: spot lights, projectors and goniometric lights.
#pragma once

#include "core/math/transform.h"
#include "scene/lights/light.h"

#include <array>

namespace sheaf {

/// The data of such a light begin with these.
template <class L> struct FramedLightData {
  Vec3<L> position;        ///< world space
  typename L::Uint frame;  ///< into LightView::frames

  static constexpr auto fields(auto& s) { return std::tie(s.position, s.frame); }
};

/// Base of the kinds of such lights.
struct FramedLightKind {
  static constexpr LightDomain kDomain = LightDomain::kBounded;

  static Vec3f power(const SceneView&, const LightRow& light) { return emitted_rgb(light); }
  static Vec3f position(const LightRow& light) { return light.data<FramedLightData>().position; }
};

/// The rotation of a transform with uniform scale, from world to local space, row by row. Throws SceneError at `where`,
/// naming `what`, if the transform distorts.
std::array<double, 9> rotation_of(const Transform& to_world, const char* what, const SourceLocation& where);

/// The data of a light that must not distort, with its frame added to the context. Throws SceneError as rotation_of().
FramedLightData<Scalar> rotated_frame(const Transform& to_world, const char* what, const SourceLocation& where,
                                      LightContext& context);

}  // namespace sheaf
