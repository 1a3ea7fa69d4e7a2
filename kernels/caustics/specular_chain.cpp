// Traces chains of specular vertices with ray differentials.
#include "kernels/caustics/specular_chain.h"

#include "kernels/bsdf/conductor.h"
#include "kernels/bsdf/dielectric.h"
#include "kernels/bsdf/dispersive_dielectric.h"
#include "kernels/bsdf/list.h"
#include "scene/surfaces/shape.h"

#include <cmath>

namespace sheaf {

namespace {

/// The BSDF of a material, at the wavelengths `lambda` in spectral mode.
template <template <class> class Bsdf>
Bsdf<Scalar> bsdf_of(const SceneView& scene, std::uint32_t material, const Spectrum4& lambda) {
  float words[kMaxClosureWords];
  std::copy(std::begin(scene.materials.rows[material].words), std::end(scene.materials.rows[material].words), words);
  if (scene.color == ColorMode::kSpectral) {
    constexpr ClosureSpectra kSpectra = closure_spectra<Bsdf>();
    for (int k = 0; k < kSpectra.count; ++k) {
      const Spectrum4 value = closure_spectrum<Scalar>(scene, material, k, lambda);
      float* const word = words + kSpectra.word[k];
      word[0] = value.c0, word[1] = value.c1, word[2] = value.c2, word[3] = value.c3;
    }
  }
  return bsdf_of_words<Bsdf<Scalar>>(nullptr, [&](int k, float& word) { word = words[k]; });
}

template <class Closure> bool has_closure(const SceneView& scene, std::uint32_t material) {
  return scene.materials.rows[material].kind == kClosureKind<Closure>;
}

/// Derivative of an interpolated normal by a displacement `d` in the plane of a triangle. Not normalized.
Vec3f interpolated_change(const CasterTriangle& at, Vec3f d) {
  const Vec3f e1 = at.p[1] - at.p[0], e2 = at.p[2] - at.p[0];
  const float e11 = dot(e1, e1), e12 = dot(e1, e2), e22 = dot(e2, e2), d1 = dot(d, e1), d2 = dot(d, e2);
  const float determinant = e11 * e22 - e12 * e12;
  if (!(determinant > 0)) return {};
  const float du = (e22 * d1 - e12 * d2) / determinant, dv = (e11 * d2 - e12 * d1) / determinant;
  return (at.n[1] - at.n[0]) * du + (at.n[2] - at.n[0]) * dv;
}

/// Normal of a hit before normalization, and its derivatives by displacements.
struct NormalChange {
  Vec3f normal;  ///< 0: the normal is constant
  Vec3f d[2];
};

NormalChange mesh_change(const SceneView& scene, const ShapeRow& shape, const SurfaceHit& hit, const Vec3f (&d_p)[2],
                         float time) {
  if ((shape.flags & kHasNormals) == 0) return {};
  const CasterTriangle at = caster_triangle(scene, shape, hit.primitive, time);
  const Vec3f sum = at.n[0] * (1 - hit.u - hit.v) + at.n[1] * hit.u + at.n[2] * hit.v;
  if (!(dot(sum, sum) > 1e-12f)) return {};
  return {sum, {interpolated_change(at, d_p[0]), interpolated_change(at, d_p[1])}};
}

NormalChange quadric_change(const SceneView& scene, const ShapeRow& shape, Vec3f p, const Vec3f (&d_p)[2]) {
  const auto kind = static_cast<ShapeKind>(shape.kind);
  if (kind == ShapeKind::kDisk) return {};
  const QuadricRow& q = scene.geometry.quadrics[shape.first_triangle];
  const float with_z = kind == ShapeKind::kSphere ? 1.0f : 0.0f;
  // The gradient of the canonical shape is linear in the object-space point.
  const auto gradient = [&](Vec3f x) { return q.world_normal({x.x, x.y, x.z * with_z}); };
  const Vec3f zero = q.object_point({0, 0, 0});
  const auto vector = [&](Vec3f v) { return q.object_point(v) - zero; };
  return {gradient(q.object_point(p)), {gradient(vector(d_p[0])), gradient(vector(d_p[1]))}};
}

/// The change at a point `p` of any shape, in world space.
NormalChange normal_change(const SceneView& scene, const ShapeRow& shape, const SurfaceHit& hit, Vec3f p,
                           const Vec3f (&d_p)[2], float time) {
  const auto in_shape = [&](Vec3f q, const Vec3f(&d_q)[2]) {
    return static_cast<ShapeKind>(shape.kind) == ShapeKind::kMesh ? mesh_change(scene, shape, hit, d_q, time)
                                                                  : quadric_change(scene, shape, q, d_q);
  };
  const auto placed = caster_placement(scene, hit.instance, time);
  if (!placed) return in_shape(p, d_p);
  NormalChange change =
      in_shape(placed->object_point(p), {placed->object_vector(d_p[0]), placed->object_vector(d_p[1])});
  change.normal = placed->normal(change.normal);
  for (Vec3f& d : change.d) d = placed->normal(d);
  return change;
}

/// Derivative of the normalized normal `n` from that of the normal before normalization.
Vec3f normalized_change(Vec3f n, Vec3f change, float length) { return (change - n * dot(n, change)) / length; }

}  // namespace

DifferentialRay start_ray(Vec3f origin, Vec3f direction) {
  const auto frame = Frame<Scalar>::from_normal(direction);
  DifferentialRay ray;
  ray.origin = origin;
  ray.direction = direction;
  ray.d_direction[0] = frame.s;
  ray.d_direction[1] = frame.t;
  return ray;
}

SurfaceHit ChainTracer::intersect(Vec3f origin, Vec3f direction) {
  if (!is_finite(origin) || !(std::fabs(dot(direction, direction) - 1) < 0.5f)) return {};
  ++rays_;
  packet_.set_ray(0, origin, direction);
  packet_.shape[0] = packet_.instance[0] = kNone;
  scene_.accel->intersect(packet_, 1);
  return {packet_.shape[0],
          packet_.instance[0],
          packet_.primitive[0],
          packet_.t_far[0],
          packet_.u[0],
          packet_.v[0],
          {packet_.normal_x[0], packet_.normal_y[0], packet_.normal_z[0]}};
}

bool ChainTracer::is_open(Vec3f origin, Vec3f direction) {
  ++rays_;
  packet_.set_ray(0, origin, direction, 1.0f);
  scene_.accel->occluded(packet_, 1);
  return packet_.t_far[0] >= 0;
}

CasterHit ChainTracer::surface(const DifferentialRay& ray, const SurfaceHit& hit) const {
  const ShapeRow& shape = scene_.geometry.shapes[hit.shape];
  const auto y = surface_point<Scalar>(scene_, shape, hit.primitive, hit.u, hit.v, ray.origin + ray.direction * hit.t,
                                       hit.instance, time());
  CasterHit out;
  out.p = y.p;
  out.ng = y.ng;
  out.ns = y.ns;
  out.offset = y.offset;
  out.material = dot(hit.normal, ray.direction) > 0 ? scene_.materials.rows[shape.material].back : shape.material;
  // Move the hit with the ray along the surface
  const float cosine = dot(ray.direction, y.ng);
  for (int i = 0; i < 2; ++i) {
    const Vec3f moved = ray.d_origin[i] + ray.d_direction[i] * hit.t;
    out.d_p[i] = moved - ray.direction * (dot(moved, y.ng) / cosine);
  }
  // Differentiate the shading normal
  const bool mesh = static_cast<ShapeKind>(shape.kind) == ShapeKind::kMesh;
  const NormalChange change = normal_change(scene_, shape, hit, y.p, out.d_p, time());
  const float size = length(change.normal);
  const float sign = mesh || static_cast<ShapeKind>(shape.kind) == ShapeKind::kDisk
                         ? 1.0f
                         : scene_.geometry.quadrics[shape.first_triangle].normal_sign;
  for (int i = 0; i < 2; ++i) out.d_normal[i] = size > 0 ? normalized_change(y.ns, change.d[i] * sign, size) : Vec3f{};
  // Flip the frame of two-sided materials
  if ((scene_.materials.rows[out.material].flags & kTwoSided) != 0 && dot(out.ns, ray.direction) > 0) {
    out.ns = -out.ns;
    for (Vec3f& d : out.d_normal) d = -d;
  }
  return out;
}

/// Index of refraction of a dielectric at the first wavelength, inside over outside.
float ChainTracer::first_index(std::uint32_t material) const {
  const MaterialRow& row = scene_.materials.rows[material];
  if (has_closure<DispersiveDielectricClosure>(scene_, material) && scene_.color == ColorMode::kSpectral)
    return closure_spectrum<Scalar>(scene_, material, 0, lambda_).c0;
  return row.words[0];
}

float ChainTracer::reflection_probability(const CasterHit& hit, Vec3f direction) const {
  const float cosine = -dot(direction, hit.ns);
  if (has_closure<ConductorClosure>(scene_, hit.material)) return cosine > 0 ? 1.0f : 0.0f;
  return fresnel_dielectric<Scalar>(cosine, first_index(hit.material)).reflectance;
}

bool ChainTracer::scatter(const CasterHit& hit, bool refract, DifferentialRay& ray, Spectrum4* weight) {
  const Vec3f d = ray.direction;
  const float wo = -dot(d, hit.ns);
  const bool conductor = has_closure<ConductorClosure>(scene_, hit.material);
  if (wo == 0 || (conductor && (refract || wo < 0))) return false;
  // Compute the new direction from the normal that faces the ray
  const float side = wo > 0 ? 1.0f : -1.0f, cosine = side * wo;
  const Vec3f n = hit.ns * side;
  const DielectricFresnel<Scalar> fresnel =
      conductor ? DielectricFresnel<Scalar>{} : fresnel_dielectric<Scalar>(wo, first_index(hit.material));
  const float inverse = refract ? 1 / fresnel.eta : 1.0f;
  const float transmitted = refract ? std::fabs(fresnel.cos_transmitted) : -cosine;
  if (refract && (!(fresnel.reflectance < 1) || !(transmitted > 0))) return false;
  const float along = inverse * cosine - transmitted;
  ray.direction = normalize(d * inverse + n * along);
  // Differentiate it
  for (int i = 0; i < 2; ++i) {
    const Vec3f d_n = hit.d_normal[i] * side, d_d = ray.d_direction[i];
    const float d_cosine = -(dot(d_d, n) + dot(d, d_n));
    const float d_transmitted = refract ? d_cosine * cosine * inverse * inverse / transmitted : -d_cosine;
    const Vec3f change = d_d * inverse + n * (inverse * d_cosine - d_transmitted) + d_n * along;
    ray.d_direction[i] = change - ray.direction * dot(change, ray.direction);
    ray.d_origin[i] = hit.d_p[i];
  }
  ray.origin = offset_origin<Scalar>(hit.p, hit.ng, hit.offset, ray.direction);
  if (weight == nullptr) return true;
  // Evaluate the BSDF
  if (conductor) {
    const auto b = bsdf_of<ConductorBsdf>(scene_, hit.material, lambda_);
    *weight = *weight * (b.reflectance * fresnel_conductor<Scalar>(cosine, b.eta, b.k));
  } else if (has_closure<DielectricClosure>(scene_, hit.material)) {
    const auto b = bsdf_of<DielectricBsdf>(scene_, hit.material, lambda_);
    const Spectrum4 reflected =
        SpecularChoice<Scalar>(fresnel.reflectance, b.eta, b.specular, b.specular_color).reflectance;
    const Spectrum4 refracted = map_spectrum<Scalar>(reflected, [](float r) { return 1 - r; });
    *weight = *weight * (refract ? b.transmittance * refracted * (inverse * inverse) : b.reflectance * reflected);
  } else {
    const auto b = bsdf_of<DispersiveDielectricBsdf>(scene_, hit.material, lambda_);
    const auto f = fresnel_dispersive<Scalar>(wo, b.eta, b.specular, b.specular_color);
    const float through = (1 - f.first.reflectance) * inverse * inverse;
    *weight = *weight *
              (refract ? b.transmittance * first_for_all<Scalar>(f.single, through) : b.reflectance * f.reflectance);
    if (refract) lambda_ = Spectrum4(lambda_.c0);
  }
  return true;
}

bool ChainTracer::follow(const ChainType& type, DifferentialRay& ray, Spectrum4* weight) {
  for (int i = 0; i < type.length; ++i) {
    const SurfaceHit hit = intersect(ray.origin, ray.direction);
    if (!is_caster(hit) || !scatter(surface(ray, hit), type.refracts(i), ray, weight)) return false;
  }
  return true;
}

}  // namespace sheaf
