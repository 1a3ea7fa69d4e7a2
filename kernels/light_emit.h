// Photons from lights of every kind: where they start, where they go and the power that each carries. For the photon
// pass; estimators that gather at points sample lights by kernels/light_sample.h instead.
#pragma once

#include "kernels/light_sample.h"

namespace sheaf {

/// A photon as it leaves a light. The mean of `flux` over all of them is the power of all lights, and the flux of those
/// that cross a surface the power that arrives there.
template <class L> struct PhotonEmission {
  Vec3<L> origin;     ///< world space; off the surface of an area light, and outside of the scene for infinite lights
  Vec3<L> direction;  ///< in which the photon travels, unit length
  Spectrum<L> flux;   ///< W; divided by both densities and by the probability of the light
  /// Per area: on the light's surface, or on the disk that infinite lights shine through. Lights at a point: 1.
  typename L::Float pdf_position;
  typename L::Float pdf_direction;  ///< per solid angle; for a single direction 1
  typename L::Mask valid;           ///< false: there is no photon
};

namespace light_emit_detail {

using light_detail::FrameLanes;
using light_detail::LightPoint;

/// The part of an environment map's photons that take any direction alike: the map's own density vanishes where
/// EnvmapDescription::mis_compensation takes it off.
inline constexpr float kUniformShare = 0.125f;

/// Where infinite lights' photons start, in radii of the bounding sphere from its centre.
inline constexpr float kDiskDistance = 1.05f;

/// Along the cosine from a point on an area light (Jensen, "Realistic Image Synthesis Using Photon Mapping", 2001,
/// section 5.2), so that all photons of a light without texture and stretching carry the same flux.
template <class L>
SHEAF_INLINE PhotonEmission<L> from_surface(const LightPoint<L>& at, const LightLanes<L>& light, const Random4<L>& b) {
  using F = Float<L>;
  const Vec3<L> local = square_to_cosine_hemisphere<L>(b.x, b.y);
  PhotonEmission<L> e;
  e.origin = at.y.p + at.y.ng * at.y.offset;
  e.direction = Frame<L>::from_normal(at.y.ng).to_world(local);
  e.pdf_position = at.pdf_area;
  e.pdf_direction = cosine_hemisphere_pdf_solid_angle(local.z);
  e.flux = light.radiance * (F(kPi) / at.pdf_area);
  e.valid = local.z > F(0.0f);
  return e;
}

template <class L>
SHEAF_INLINE PhotonEmission<L> from_point(const LightLanes<L>& light, Vec3<L> direction, Float<L> pdf_direction) {
  using F = Float<L>;
  PhotonEmission<L> e;
  e.origin = light.position;
  e.direction = direction;
  e.pdf_position = F(1.0f);
  e.pdf_direction = pdf_direction;
  e.valid = pdf_direction > F(0.0f);
  e.flux = light.radiance * (F(1.0f) / select(e.valid, pdf_direction, F(1.0f)));
  return e;
}

/// Through the disk across `direction` that covers the bounding sphere (Pharr et al., 4th ed., section 12.5.2).
/// `radiance` comes along it, or irradiance if the direction is the only one.
template <class L>
SHEAF_INLINE PhotonEmission<L> from_infinity(const SceneView& scene, Vec3<L> direction, const Spectrum<L>& radiance,
                                             Float<L> pdf_direction, const Random4<L>& a) {
  using F = Float<L>;
  const Vec2<L> on_disk = square_to_disk<L>(a.y, a.z);
  const F radius(scene.radius), area(kPi * scene.radius * scene.radius);
  PhotonEmission<L> e;
  e.direction = direction;
  e.origin = broadcast<L>(scene.center) +
             Frame<L>::from_normal(direction).to_world({on_disk.x, on_disk.y, F(-kDiskDistance)}) * radius;
  e.pdf_position = F(1.0f) / area;
  e.pdf_direction = pdf_direction;
  e.valid = pdf_direction > F(0.0f);
  e.flux = radiance * (area / select(e.valid, pdf_direction, F(1.0f)));
  return e;
}

/// From the light's space to world space.
template <class L> SHEAF_INLINE Vec3<L> world_vector(const FrameLanes<L>& frame, Vec3<L> v) {
  const auto* m = frame.to_light;
  const Vec3<L> rows[3] = {{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}};
  const Vec3<L> across = cross(rows[1], rows[2]);
  const Vec3<L> adjugate = across * v.x + cross(rows[2], rows[0]) * v.y + cross(rows[0], rows[1]) * v.z;
  return adjugate / dot(rows[0], across);
}

/// A density per solid angle in world space from `pdf`, per solid angle in the light's space, at the unit vector that
/// world_vector() made `along`: a linear map of determinant D multiplies solid angles by |D| / |along|^3.
template <class L> SHEAF_INLINE Float<L> world_pdf(const FrameLanes<L>& frame, Vec3<L> along, Float<L> pdf) {
  const auto* m = frame.to_light;
  const Float<L> determinant =
      dot(Vec3<L>{m[0], m[1], m[2]}, cross(Vec3<L>{m[4], m[5], m[6]}, Vec3<L>{m[8], m[9], m[10]}));
  const Float<L> l = length(along);
  return pdf * abs(determinant) * l * l * l;
}

/// Uniformly into the cone of a spot, weighed by its falloff.
template <class L>
SHEAF_INLINE PhotonEmission<L> from_spot(const SceneView& scene, const LightLanes<L>& light, Mask<L> active,
                                         const Random4<L>& b, TextureQuery<L>& query) {
  using F = Float<L>;
  const auto frame = light_detail::load_frames<L>(scene, select(active, light.detail, Uint<L>(0u)));
  // 1 - cos of the cutoff angle c is 2 sin^2(c / 2).
  const F half = sincos_2pi<L>(clamp(frame.words[0] * F(0.25f * kInvPi), F(0.0f), F(0.25f))).sin;
  const F one_minus_cos = select(light.is(LightKind::kSpot), F(2.0f) * half * half, F(1.0f) - frame.words[0]);
  const Vec3<L> local = square_to_cone<L>(b.x, b.y, one_minus_cos);
  const Vec3<L> along = world_vector<L>(frame, local);
  const F falloff = light_detail::spot_falloff<L>(light, frame, local, active, query);
  const F pdf = world_pdf<L>(frame, along, F(0.5f * kInvPi) / max(one_minus_cos, F(1e-37f)));
  auto e = from_point<L>(light, normalize_any(along), pdf);
  e.flux = e.flux * falloff;
  e.valid = e.valid & (falloff > F(0.0f));
  return e;
}

/// Uniformly over the picture of a projector. Its intensity goes with 1 / cos^3, and so does the density of directions.
template <class L>
SHEAF_INLINE PhotonEmission<L> from_projector(const SceneView& scene, const LightLanes<L>& light, Mask<L> active,
                                              const Random4<L>& b, TextureQuery<L>& query) {
  using F = Float<L>;
  const auto frame = light_detail::load_frames<L>(scene, select(active, light.detail, Uint<L>(0u)));
  const Vec3<L> local{(F(0.5f) - b.x) / frame.words[0], (F(0.5f) - b.y) / frame.words[1], F(1.0f)};
  const F distance = length(local), inverse_area = frame.words[0] * frame.words[1];
  const F inverse_cosines = distance * distance * distance;
  auto e = from_point<L>(light, normalize_any(world_vector<L>(frame, local)), inverse_area * inverse_cosines);
  e.flux = light.radiance * (F(1.0f) / inverse_area);
  light_detail::set_query<L>(active, {{b.x, b.y}, Uint<L>(0u), Uint<L>(0u), F(0.0f), F(0.0f)}, query);
  return e;
}

/// By the map's brightness, and for a part of the photons uniformly (balance heuristic).
template <class L>
SHEAF_INLINE PhotonEmission<L> from_map(const SceneView& scene, const Random4<L>& a, const Random4<L>& b) {
  using F = Float<L>;
  const Vec3<L> to_light = select<L>(b.z < F(kUniformShare), square_to_sphere<L>(b.x, b.y),
                                     sample_envmap<L>(scene.envmap, b.x, b.y).direction);
  const EnvmapValue<L> value = lookup_envmap<L>(scene.envmap, to_light);
  const F pdf = fma(F(1.0f - kUniformShare), value.pdf_solid_angle, F(kUniformShare * kUniformSpherePdf));
  return from_infinity<L>(scene, -to_light, value.radiance, pdf, a);
}

template <class L> SHEAF_INLINE void merge(Mask<L> m, const PhotonEmission<L>& from, PhotonEmission<L>& into) {
  into.origin = select<L>(m, from.origin, into.origin);
  into.direction = select<L>(m, from.direction, into.direction);
  into.flux = select<L>(m, from.flux, into.flux);
  into.pdf_position = select(m, from.pdf_position, into.pdf_position);
  into.pdf_direction = select(m, from.pdf_direction, into.pdf_direction);
  into.valid = select(m, from.valid, into.valid);
}

}  // namespace light_emit_detail

/// Emits a photon from each of the lights that choose_light_by_power() chose, with a position by a.y, a.z and a.w and a
/// direction by b.x, b.y and b.z.
template <class L>
PhotonEmission<L> emit_photon(const SceneView& scene, const LightChoice<L>& choice, const Random4<L>& a,
                              const Random4<L>& b) {
  using namespace light_emit_detail;
  using F = Float<L>;
  const LightLanes<L> light = load_lights<L>(scene, choice.light);
  const auto is = [&](LightKind kind) SHEAF_LAMBDA_INLINE { return light.is(kind); };
  const auto mesh = is(LightKind::kMesh), quadric = is(LightKind::kSphere) | is(LightKind::kQuadric);
  const auto point = is(LightKind::kPoint), spot = is(LightKind::kSpot) | is(LightKind::kSmoothSpot);
  const auto projector = is(LightKind::kProjector), directional = is(LightKind::kDirectional);
  const auto constant = is(LightKind::kConstant), map = is(LightKind::kEnvmap);
  PhotonEmission<L> e{};
  TextureQuery<L> query{};
  const auto add = [&](Mask<L> m, auto&& emit) SHEAF_LAMBDA_INLINE {
    if (any(m)) merge<L>(m, emit(), e);
  };
  using light_detail::point_on_mesh, light_detail::point_on_quadric;
  const F sphere_pdf(kUniformSpherePdf);
  add(mesh, [&] { return from_surface<L>(point_on_mesh<L>(scene, light, mesh, a, query), light, b); });
  add(quadric, [&] { return from_surface<L>(point_on_quadric<L>(scene, light, quadric, a, query), light, b); });
  add(point, [&] { return from_point<L>(light, square_to_sphere<L>(b.x, b.y), sphere_pdf); });
  add(spot, [&] { return from_spot<L>(scene, light, spot, b, query); });
  add(projector, [&] { return from_projector<L>(scene, light, projector, b, query); });
  add(directional, [&] { return from_infinity<L>(scene, -light.position, light.radiance, F(1.0f), a); });
  add(constant, [&] { return from_infinity<L>(scene, square_to_sphere<L>(b.x, b.y), light.radiance, sphere_pdf, a); });
  add(map, [&] { return from_map<L>(scene, a, b); });
  const auto textured = e.valid & (light.texture != Uint<L>(kNone));
  if (any(textured)) e.flux = e.flux * light_textures<L>(scene, light.texture, textured, query);
  const auto chosen = choice.probability > F(0.0f);
  e.flux = e.flux * (F(1.0f) / select(chosen, choice.probability, F(1.0f)));
  e.valid = e.valid & chosen & is_finite(e.direction) & is_finite(max_component(e.flux));
  return e;
}

}  // namespace sheaf
