// Light sampling: a point on a light, the radiance it sends to a reference point, and with which density it was chosen;
// and the same density for a point that BSDF sampling found.
#pragma once

#include "core/sampler.h"
#include "core/uplift.h"
#include "kernels/envmap.h"
#include "kernels/light_select.h"
#include "kernels/volume_light.h"
#include "scene/shape.h"
#include "scene/texture_lookup.h"

namespace sheaf {

/// LightRow, a lane each.
template <class L> struct LightLanes {
  typename L::Uint kind, shape, first_triangle, triangle_count;
  Spectrum<L> radiance;
  Vec3<L> position;
  typename L::Float area, radius;
  typename L::Uint texture, detail;

  SHEAF_INLINE typename L::Mask is(LightKind k) const { return kind == typename L::Uint(static_cast<std::uint32_t>(k)); }
};

template <class L> SHEAF_INLINE LightLanes<L> load_lights(const SceneView& scene, typename L::Uint light) {
  typename L::Float w[16];
  const auto* base = reinterpret_cast<const float*>(scene.lights);
  for (int k = 0; k < 16; k += 4) gather_row4<L>(base + k, light * typename L::Uint(16u), w + k);
  return {float_bits(w[0]), float_bits(w[1]),       float_bits(w[2]),    float_bits(w[3]), {w[4], w[5], w[6], w[7]},
          {w[8], w[9], w[10]}, w[11], w[12], float_bits(w[14]), float_bits(w[15])};
}

/// What lights' rows say, at the wavelengths `lambda`: spectral mode.
template <class L>
SHEAF_INLINE Spectrum<L> light_spectra(const SceneView& scene, typename L::Uint light, const Spectrum<L>& lambda) {
  return evaluate<L>(scene.spectral.lights, light, scene.spectral.tables, lambda);
}

/// Colours of textures, as factors on light_spectra().
template <class L>
SHEAF_INLINE Spectrum<L> uplifted_light(const SceneView& scene, const Spectrum<L>& rgb, const Spectrum<L>& lambda) {
  return evaluate(uplift_unbounded<L>(*scene.spectral.uplift, {rgb.c0, rgb.c1, rgb.c2}), lambda);
}

/// Light that arrives at a reference point from a sampled direction.
template <class L> struct LightSample {
  Vec3<L> direction;            ///< from the reference point, unit length
  Vec3<L> target;               ///< where the shadow ray ends: on the light, moved off its surface
  Spectrum<L> radiance;         ///< incident radiance; point lights: intensity over squared distance
  /// Where the light is a single direction, the probability: 1; in a volume, solid angle times length.
  typename L::Float pdf_solid_angle;
  typename L::Mask delta;       ///< BSDF sampling cannot find this light
  typename L::Mask valid;       ///< false: nothing arrives
  typename L::Uint end;         ///< see TransmittanceItem::end
};

/// 1 - cos of the half angle under which a sphere is seen, stable for small ones; 0 from inside.
template <class F> SHEAF_INLINE F sphere_one_minus_cos(F radius, F distance_squared) {
  const F sin2 = min(radius * radius / max(distance_squared, F(1e-37f)), F(1.0f));
  return select(sin2 < F(1.0f), sin2 / (F(1.0f) + safe_sqrt(F(1.0f) - sin2)), F(0.0f));
}

namespace light_detail {

/// A point on an area light.
template <class L> struct LightPoint {
  SurfacePoint<L> y;           ///< p, ng and offset only
  typename L::Float pdf_area;  ///< per area in world space
};

/// Turns a point on an area light into a sample: density from area to solid angle, and one-sidedness.
template <class L>
SHEAF_INLINE LightSample<L> from_area(Vec3<L> from, const LightPoint<L>& point, const LightLanes<L>& light) {
  using F = Float<L>;
  const SurfacePoint<L>& y = point.y;
  LightSample<L> s;
  const Vec3<L> d = y.p - from;
  const F squared = dot(d, d);
  s.direction = d * (F(1.0f) / sqrt(max(squared, F(1e-37f))));
  const F cos_light = -dot(s.direction, y.ng);
  s.valid = (cos_light > F(1e-6f)) & (squared > F(0.0f));
  s.pdf_solid_angle = point.pdf_area * squared / select(s.valid, cos_light, F(1.0f));
  s.target = y.p + y.ng * y.offset;
  s.radiance = light.radiance;
  s.delta = Mask<L>(false);
  return s;
}

template <class L> SHEAF_INLINE void set_query(Mask<L> m, const TextureQuery<L>& a, TextureQuery<L>& into) {
  into.uv = {select(m, a.uv.x, into.uv.x), select(m, a.uv.y, into.uv.y)};
  into.shape = select(m, a.shape, into.shape);
  into.primitive = select(m, a.primitive, into.primitive);
  into.b1 = select(m, a.b1, into.b1);
  into.b2 = select(m, a.b2, into.b2);
}

/// The distance from the surface that a light of an instance asks for.
template <class L> SHEAF_INLINE Float<L> least_offset(const LightLanes<L>& light) { return bits_float(light.detail); }

/// Uniform over a mesh by u.y, u.z and u.w.
template <class L>
SHEAF_INLINE LightPoint<L> point_on_mesh(const SceneView& scene, const LightLanes<L>& light, Mask<L> active,
                                         const Random4<L>& u, TextureQuery<L>& query) {
  using F = Float<L>;
  using U = Uint<L>;
  const U first = select(active, light.first_triangle, U(0u));
  const auto triangle =
      sample_alias<L>(scene.triangle_alias, first, select(active, light.triangle_count, U(1u)), u.w);
  F w[16];
  const auto* base = reinterpret_cast<const float*>(scene.light_triangles);
  for (int k = 0; k < 16; k += 4) gather_row4<L>(base + k, (first + triangle.index) * U(16u), w + k);
  const Vec2<L> b = square_to_triangle<L>(u.y, u.z);
  LightPoint<L> out;
  SurfacePoint<L>& y = out.y;
  y.p = Vec3<L>{w[0], w[1], w[2]} + Vec3<L>{w[4], w[5], w[6]} * b.x + Vec3<L>{w[8], w[9], w[10]} * b.y;
  y.ng = {w[12], w[13], w[14]};
  y.offset = w[3];
  const auto textured = active & (light.texture != U(kNone));
  if (any(textured)) {
    F uv[8];
    const U row = select(textured, light.detail + triangle.index, U(0u)) * U(8u);
    gather_row4<L>(reinterpret_cast<const float*>(scene.light_uvs), row, uv);
    gather_row4<L>(reinterpret_cast<const float*>(scene.light_uvs) + 4, row, uv + 4);
    const F b0 = F(1.0f) - b.x - b.y;
    set_query<L>(textured, {{b0 * uv[0] + b.x * uv[2] + b.y * uv[4], b0 * uv[1] + b.x * uv[3] + b.y * uv[5]},
                            light.shape, triangle.index, b.x, b.y}, query);
  }
  out.pdf_area = F(1.0f) / light.area;
  return out;
}

/// For the canonical shape's point `x`. Not inlined: textured quadrics are rare.
template <class L>
void set_quadric_query(Mask<L> m, const QuadricLanes<L>& q, const LightLanes<L>& light, Vec3<L> x,
                       TextureQuery<L>& query) {
  using F = Float<L>;
  const auto y = quadric_surface<L, true>(q, float_bits(q.kind), x);
  set_query<L>(m, {y.uv, light.shape, Uint<L>(0u), F(0.0f), F(0.0f)}, query);
}

/// Uniform over the canonical shape of a quadric, spheres included, by u.y and u.z.
template <class L>
SHEAF_INLINE LightPoint<L> point_on_quadric(const SceneView& scene, const LightLanes<L>& light, Mask<L> active,
                                            const Random4<L>& u, TextureQuery<L>& query) {
  using F = Float<L>;
  using U = Uint<L>;
  const auto q = load_quadrics<L>(scene, select(active, light.first_triangle, U(0u)));
  const U kind = float_bits(q.kind);
  const Vec3<L> on_sphere = square_to_sphere<L>(u.y, u.z);
  const Vec2<L> on_disk = square_to_disk<L>(u.y, u.z);
  const auto angle = sincos_2pi<L>(u.y);
  const auto disk = kind == U(static_cast<std::uint32_t>(ShapeKind::kDisk));
  const auto cylinder = kind == U(static_cast<std::uint32_t>(ShapeKind::kCylinder));
  Vec3<L> x = select<L>(disk, {on_disk.x, on_disk.y, F(0.0f)}, on_sphere);
  x = select<L>(cylinder, {angle.cos, angle.sin, u.z}, x);
  LightPoint<L> out;
  out.y = quadric_surface<L, false>(q, kind, x);
  out.y.offset = max(out.y.offset, select(active, least_offset<L>(light), F(0.0f)));
  const auto textured = active & (light.texture != U(kNone));
  if (any(textured)) set_quadric_query<L>(textured, q, light, x, query);
  // The area element grows by |det| |M^-T n|.
  const Vec3<L> n = {select(disk, F(0.0f), x.x), select(disk, F(0.0f), x.y),
                     select(disk, F(1.0f), select(cylinder, F(0.0f), x.z))};
  out.pdf_area = F(1.0f) / max(light.area * q.determinant * length(q.world_normal(n)), F(1e-37f));
  return out;
}

/// Directions inside the cone under which the sphere is seen (Pharr et al. 2023, section 6.2.4).
template <class L>
SHEAF_INLINE LightSample<L> sample_sphere(const SceneView& scene, Vec3<L> from, const LightLanes<L>& light,
                                          Mask<L> active, const Random4<L>& u, TextureQuery<L>& query) {
  using F = Float<L>;
  using U = Uint<L>;
  const Vec3<L> to_center = light.position - from;
  const F squared = dot(to_center, to_center);
  const F one_minus_cos_max = sphere_one_minus_cos(light.radius, squared);
  LightSample<L> s;
  s.valid = one_minus_cos_max > F(0.0f);
  const F distance = sqrt(max(squared, F(1e-37f)));
  const auto frame = Frame<L>::from_normal(to_center * (F(1.0f) / distance));
  const Vec3<L> local = square_to_cone<L>(u.y, u.z, one_minus_cos_max);
  s.direction = frame.to_world(local);
  // Normal of the sphere where the direction meets it first.
  const F sin2 = max(F(0.0f), F(1.0f) - local.z * local.z);
  const F along = distance * local.z - safe_sqrt(light.radius * light.radius - squared * sin2);
  const Vec3<L> normal = (s.direction * along - to_center) * (F(1.0f) / light.radius);
  const F extent = max_component(abs(light.position)) + light.radius;
  const F n_length = sqrt(max(dot(normal, normal), F(1e-12f)));
  const F offset = max(F(2.0f * kOffsetUlps) * extent, select(active, least_offset<L>(light), F(0.0f)));
  s.target = light.position + normal * ((light.radius + offset) / n_length);
  const auto textured = active & (light.texture != U(kNone));
  if (any(textured)) {
    const auto q = load_quadrics<L>(scene, select(textured, light.first_triangle, U(0u)));
    const Vec3<L> x = q.object_point(light.position + normal * (light.radius / n_length));
    set_quadric_query<L>(textured, q, light, normalize_any(x), query);
  }
  s.pdf_solid_angle = F(0.5f * kInvPi) / select(s.valid, one_minus_cos_max, F(1.0f));
  s.radiance = light.radiance;
  s.delta = Mask<L>(false);
  return s;
}

template <class L> SHEAF_INLINE LightSample<L> sample_point(Vec3<L> from, const LightLanes<L>& light) {
  using F = Float<L>;
  const Vec3<L> d = light.position - from;
  const F squared = dot(d, d);
  LightSample<L> s;
  s.valid = squared > F(1e-37f);
  const F inverse = F(1.0f) / select(s.valid, squared, F(1.0f));
  s.direction = d * sqrt(inverse);
  s.target = light.position;
  s.radiance = light.radiance * inverse;
  s.pdf_solid_angle = F(1.0f);
  s.delta = Mask<L>(true);
  return s;
}

/// LightFrameRow, a lane each.
template <class L> struct FrameLanes {
  typename L::Float to_light[12], words[4];

  SHEAF_INLINE Vec3<L> point(Vec3<L> p) const {
    const auto* m = to_light;
    return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
            m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
  }
};

template <class L> SHEAF_INLINE FrameLanes<L> load_frames(const SceneView& scene, Uint<L> index) {
  FrameLanes<L> out;
  const auto* base = reinterpret_cast<const float*>(scene.light_frames);
  const auto row = index * Uint<L>(16u);
  for (int k = 0; k < 12; k += 4) gather_row4<L>(base + k, row, out.to_light + k);
  gather_row4<L>(base + 12, row, out.words);
  return out;
}

/// The part of its intensity, in [0, 1] and without its texture, that a spot of either kind sends along `local`, a
/// vector in its space; see SpotLightDescription.
template <class L>
SHEAF_INLINE Float<L> spot_falloff(const LightLanes<L>& light, const FrameLanes<L>& frame, Vec3<L> local,
                                   Mask<L> active, TextureQuery<L>& query) {
  using F = Float<L>;
  using U = Uint<L>;
  const F across = sqrt(local.x * local.x + local.y * local.y);
  const F distance = sqrt(dot(local, local));
  const auto linear = light.is(LightKind::kSpot);
  const F cosine = local.z / max(distance, F(1e-37f));
  // The angle by its tangent, which is exact also near the axis.
  const F x = select(linear, frame.words[0] - atan2(across, local.z), cosine - frame.words[0]);
  const F step = clamp(x * frame.words[1], F(0.0f), F(1.0f));
  const auto textured = active & (step > F(0.0f)) & (light.texture != U(kNone));
  if (any(textured)) {
    const F scale = F(0.5f) * frame.words[2] / max(local.z, F(1e-37f));
    const Vec2<L> uv{F(0.5f) + local.x * scale, F(0.5f) + local.y * scale};
    set_query<L>(textured, {uv, U(0u), U(0u), F(0.0f), F(0.0f)}, query);
  }
  return select(linear, step, step * step * (F(3.0f) - F(2.0f) * step));
}

template <class L>
SHEAF_INLINE LightSample<L> sample_spot(const SceneView& scene, Vec3<L> from, const LightLanes<L>& light, Mask<L> active,
                                        TextureQuery<L>& query) {
  const auto frame = load_frames<L>(scene, select(active, light.detail, Uint<L>(0u)));
  const Float<L> falloff = spot_falloff<L>(light, frame, frame.point(from), active, query);
  LightSample<L> s = sample_point<L>(from, light);
  s.radiance = s.radiance * falloff;
  s.valid = s.valid & (falloff > Float<L>(0.0f));
  return s;
}

/// See ProjectorDescription.
template <class L>
SHEAF_INLINE LightSample<L> sample_projector(const SceneView& scene, Vec3<L> from, const LightLanes<L>& light,
                                             Mask<L> active, TextureQuery<L>& query) {
  using F = Float<L>;
  using U = Uint<L>;
  const auto frame = load_frames<L>(scene, select(active, light.detail, U(0u)));
  const Vec3<L> local = frame.point(from);
  const auto ahead = local.z > F(0.0f);
  const F depth = select(ahead, local.z, F(1.0f));
  const F u = F(0.5f) - local.x / depth * frame.words[0], v = F(0.5f) - local.y / depth * frame.words[1];
  LightSample<L> s = sample_point<L>(from, light);
  s.valid = s.valid & ahead & (min(u, v) >= F(0.0f)) & (max(u, v) <= F(1.0f));
  const F inverse_cosine = sqrt(dot(local, local)) / depth;
  s.radiance = s.radiance * (inverse_cosine * inverse_cosine * inverse_cosine);
  set_query<L>(active & s.valid, {{u, v}, U(0u), U(0u), F(0.0f), F(0.0f)}, query);
  return s;
}

/// Where a shadow ray to the environment ends.
template <class L> SHEAF_INLINE Vec3<L> beyond_scene(const SceneView& scene, Vec3<L> from, Vec3<L> direction) {
  return from + direction * Float<L>(2.1f * scene.radius);
}

template <class L>
SHEAF_INLINE LightSample<L> sample_directional(const SceneView& scene, Vec3<L> from, const LightLanes<L>& light) {
  LightSample<L> s;
  s.direction = light.position;
  s.target = beyond_scene<L>(scene, from, s.direction);
  s.radiance = light.radiance;
  s.pdf_solid_angle = Float<L>(1.0f);
  s.delta = s.valid = Mask<L>(true);
  return s;
}

template <class L>
SHEAF_INLINE LightSample<L> sample_constant(const SceneView& scene, Vec3<L> from, const LightLanes<L>& light, const Random4<L>& u) {
  using F = Float<L>;
  LightSample<L> s;
  s.direction = square_to_sphere<L>(u.y, u.z);
  s.target = beyond_scene<L>(scene, from, s.direction);
  s.radiance = light.radiance;
  s.pdf_solid_angle = F(kUniformSpherePdf);
  s.delta = Mask<L>(false);
  s.valid = Mask<L>(true);
  return s;
}

template <class L, ColorMode Mode>
SHEAF_INLINE LightSample<L> sample_map(const SceneView& scene, Vec3<L> from, const LightLanes<L>& light,
                                       const Random4<L>& u, const Spectrum<L>& lambda) {
  const auto found = sample_envmap<L, Mode>(scene.envmap, u.y, u.z, lambda);
  LightSample<L> s;
  s.direction = found.direction;
  s.target = beyond_scene<L>(scene, from, s.direction);
  s.radiance = found.radiance;
  if constexpr (Mode == ColorMode::kSpectral) s.radiance = s.radiance * light.radiance;
  s.pdf_solid_angle = found.pdf_solid_angle;
  s.delta = Mask<L>(false);
  s.valid = found.pdf_solid_angle > Float<L>(0.0f);
  return s;
}

template <class L> SHEAF_INLINE void merge(Mask<L> m, const LightSample<L>& a, LightSample<L>& into) {
  into.direction = select<L>(m, a.direction, into.direction);
  into.target = select<L>(m, a.target, into.target);
  into.radiance = select<L>(m, a.radiance, into.radiance);
  into.pdf_solid_angle = select(m, a.pdf_solid_angle, into.pdf_solid_angle);
  into.delta = select(m, a.delta, into.delta);
  into.valid = select(m, a.valid, into.valid);
}

/// Points in media, one lane after the other. `radiance`: per metre.
template <class L, ColorMode Mode>
void sample_volume(const SceneView& scene, Vec3<L> from, const LightLanes<L>& light, Mask<L> active,
                   const Random4<L>& u, const Spectrum<L>& lambda, LightSample<L>& into) {
  using F = Float<L>;
  alignas(kSimdAlignment) float number[3][L::width], wavelength[4][L::width], point[4][L::width], emitted[4][L::width];
  alignas(kSimdAlignment) std::uint32_t media[L::width];
  store(media, light.shape);
  store(number[0], u.y), store(number[1], u.z), store(number[2], u.w);
  store(wavelength[0], lambda.c0), store(wavelength[1], lambda.c1);
  store(wavelength[2], lambda.c2), store(wavelength[3], lambda.c3);
  for (auto* column : {&point[0], &emitted[0]})
    for (int k = 0; k < 4; ++k) store(column[k], F(0.0f));
  for (std::uint32_t left = mask_bits(active); left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    const VolumePoint found =
        sample_volume_light(scene, scene.media[media[i]].light, {0.0f, number[0][i], number[1][i], number[2][i]},
                            {wavelength[0][i], wavelength[1][i], wavelength[2][i], wavelength[3][i]});
    point[0][i] = found.p.x, point[1][i] = found.p.y, point[2][i] = found.p.z, point[3][i] = found.pdf_volume;
    const Spectrum4& e = found.emitted;
    emitted[0][i] = e.c0, emitted[1][i] = e.c1, emitted[2][i] = e.c2, emitted[3][i] = e.c3;
  }
  LightSample<L> s;
  load(point[0], s.target.x), load(point[1], s.target.y), load(point[2], s.target.z), load(point[3], s.pdf_solid_angle);
  load(emitted[0], s.radiance.c0), load(emitted[1], s.radiance.c1);
  load(emitted[2], s.radiance.c2), load(emitted[3], s.radiance.c3);
  const Vec3<L> d = s.target - from;
  const F squared = dot(d, d);
  s.direction = d * (F(1.0f) / sqrt(max(squared, F(1e-37f))));
  s.pdf_solid_angle = s.pdf_solid_angle * squared;
  s.valid = s.pdf_solid_angle > F(0.0f);
  s.delta = Mask<L>(false);
  merge<L>(active, s, into);
}

}  // namespace light_detail

/// What the lights' textures say, one after the other; 1 for lights without, and nothing below 0. Lanes of one register
/// may hold lights of different textures. `lambda`: spectral mode.
template <class L, ColorMode Mode = ColorMode::kRgb>
Spectrum<L> light_textures(const SceneView& scene, Uint<L> texture, Mask<L> active, const TextureQuery<L>& query,
                           const Spectrum<L>& lambda = {}) {
  using F = Float<L>;
  using U = Uint<L>;
  Spectrum<L> out(F(1.0f));
  alignas(kSimdAlignment) std::uint32_t lanes[L::width];
  store(lanes, texture);
  for (std::uint32_t left = mask_bits(active & (texture != U(kNone))); left != 0;) {
    const std::uint32_t row = lanes[std::countr_zero(left)];
    const auto same = texture == U(row);
    Spectrum<L> value = lookup_texture<L>(scene.textures, row, query);
    if constexpr (Mode == ColorMode::kSpectral) value = uplifted_light<L>(scene, value, lambda);
    const F zero(0.0f);
    out = select<L>(same, {max(value.c0, zero), max(value.c1, zero), max(value.c2, zero), max(value.c3, zero)}, out);
    left &= ~mask_bits(same);
  }
  return out;
}

/// Samples a direction towards given lights by u.y, u.z and u.w. Densities don't know how the lights were selected. In
/// spectral mode light.radiance is light_spectra() at `lambda`.
template <class L, ColorMode Mode = ColorMode::kRgb>
SHEAF_INLINE LightSample<L> sample_given_light(const SceneView& scene, Vec3<L> from, const LightLanes<L>& light,
                                               const Random4<L>& u, const Spectrum<L>& lambda = {}) {
  using namespace light_detail;
  const auto is = [&](LightKind kind) SHEAF_LAMBDA_INLINE { return light.is(kind); };
  const auto mesh = is(LightKind::kMesh), sphere = is(LightKind::kSphere), quadric = is(LightKind::kQuadric);
  LightSample<L> s{};
  TextureQuery<L> query{};
  if (all(mesh)) {
    s = from_area<L>(from, point_on_mesh<L>(scene, light, mesh, u, query), light);
  } else {
    const auto point = is(LightKind::kPoint), constant = is(LightKind::kConstant), map = is(LightKind::kEnvmap);
    const auto spot = is(LightKind::kSpot) | is(LightKind::kSmoothSpot), projector = is(LightKind::kProjector);
    const auto directional = is(LightKind::kDirectional);
    if (any(mesh)) merge<L>(mesh, from_area<L>(from, point_on_mesh<L>(scene, light, mesh, u, query), light), s);
    if (any(sphere)) merge<L>(sphere, sample_sphere<L>(scene, from, light, sphere, u, query), s);
    if (any(quadric))
      merge<L>(quadric, from_area<L>(from, point_on_quadric<L>(scene, light, quadric, u, query), light), s);
    if (any(point)) merge<L>(point, sample_point<L>(from, light), s);
    if (any(constant)) merge<L>(constant, sample_constant<L>(scene, from, light, u), s);
    if (any(map)) merge<L>(map, sample_map<L, Mode>(scene, from, light, u, lambda), s);
    if (any(spot)) merge<L>(spot, sample_spot<L>(scene, from, light, spot, query), s);
    if (any(projector)) merge<L>(projector, sample_projector<L>(scene, from, light, projector, query), s);
    if (any(directional)) merge<L>(directional, sample_directional<L>(scene, from, light), s);
    const auto volume = is(LightKind::kVolume);
    if (any(volume)) sample_volume<L, Mode>(scene, from, light, volume, u, lambda, s);
  }
  s.end = select(is(LightKind::kVolume), light.shape + Uint<L>(1u), Uint<L>(kNone));
  const auto textured = s.valid & (light.texture != Uint<L>(kNone));
  if (any(textured))
    s.radiance = s.radiance * light_textures<L, Mode>(scene, light.texture, textured, query, lambda);
  return s;
}

/// A direction from `from` towards lights that were chosen, and its density, the choice included. `lambda`: the
/// wavelengths in spectral mode.
template <class L, ColorMode Mode = ColorMode::kRgb>
SHEAF_INLINE LightSample<L> sample_light(const SceneView& scene, Vec3<L> from, const LightChoice<L>& choice,
                                         const Random4<L>& u, const Spectrum<L>& lambda = {}) {
  LightLanes<L> light = load_lights<L>(scene, choice.light);
  if constexpr (Mode == ColorMode::kSpectral) light.radiance = light_spectra<L>(scene, choice.light, lambda);
  LightSample<L> s = sample_given_light<L, Mode>(scene, from, light, u, lambda);
  s.pdf_solid_angle = s.pdf_solid_angle * choice.probability;
  return s;
}

/// The density, without the choice, with which sample_given_light from `from` would have found the point at distance `t`
/// in `direction` on an area light with geometric normal `ng` there.
template <class L>
SHEAF_INLINE Float<L> light_pdf_solid_angle(const SceneView& scene, const LightLanes<L>& light, Mask<L> active,
                                            Vec3<L> from, Vec3<L> direction, Float<L> t, Vec3<L> ng) {
  using F = Float<L>;
  using U = Uint<L>;
  const F cos_light = abs(dot(direction, ng));
  F pdf_area = F(1.0f) / light.area;
  const auto sphere = active & light.is(LightKind::kSphere), quadric = active & light.is(LightKind::kQuadric);
  if (any(quadric)) {
    const auto q = load_quadrics<L>(scene, select(quadric, light.first_triangle, U(0u)));
    // |M^-T n| for the canonical unit normal n is 1 / |M^T ng|.
    const auto* m = q.to_world;
    const Vec3<L> back{m[0] * ng.x + m[4] * ng.y + m[8] * ng.z, m[1] * ng.x + m[5] * ng.y + m[9] * ng.z,
                       m[2] * ng.x + m[6] * ng.y + m[10] * ng.z};
    pdf_area = select(quadric, length(back) / max(light.area * q.determinant, F(1e-37f)), pdf_area);
  }
  F pdf = pdf_area * t * t / max(cos_light, F(1e-6f));
  if (any(sphere)) {
    const Vec3<L> to_center = light.position - from;
    const F one_minus_cos_max = sphere_one_minus_cos(light.radius, dot(to_center, to_center));
    const auto outside = one_minus_cos_max > F(0.0f);
    pdf = select(sphere, select(outside, F(0.5f * kInvPi) / select(outside, one_minus_cos_max, F(1.0f)), F(0.0f)), pdf);
  }
  return pdf;
}

}  // namespace sheaf
