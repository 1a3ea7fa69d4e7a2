// Chains of specular reflections and refractions, traced together with the derivatives of the ray by the two
// coordinates of its first direction (Igehy, "Tracing Ray Differentials", 1999). The derivatives are those of the map
// that BSDF sampling follows, shading normals included.
#pragma once

#include "core/color/spectrum.h"
#include "kernels/caustics/casters.h"
#include "scene/accel/accel.h"

namespace sheaf {

/// A ray and its derivatives. All derivatives are by orthonormal coordinates of the first direction, rad.
struct DifferentialRay {
  Vec3f origin, direction;  ///< unit length
  Vec3f d_origin[2] = {};   ///< m/rad
  Vec3f d_direction[2];     ///< perpendicular to `direction`
};

/// The ray along the unit vector `direction`, with derivatives by coordinates along Frame::from_normal().
DifferentialRay start_ray(Vec3f origin, Vec3f direction);

/// The choice between reflection and refraction at each vertex of a chain.
struct ChainType {
  int length = 0;               ///< vertices, at most kMaxChainLength
  std::uint32_t refracted = 0;  ///< bit i: vertex i refracts; otherwise it reflects

  bool refracts(int i) const { return (refracted >> i & 1u) != 0; }
  void add(bool refraction) { refracted |= (refraction ? 1u : 0u) << length++; }
  bool operator==(const ChainType&) const = default;
};

/// A hit on a caster.
struct CasterHit {
  Vec3f p, ng, ns;            ///< as in SurfacePoint; ns faces the incident ray if the material is two-sided
  float offset;               ///< see SurfacePoint::offset
  Vec3f d_normal[2], d_p[2];  ///< derivatives of ns and p along the incident DifferentialRay
  std::uint32_t material;     ///< row of the side that was hit
};

/// A hit of any surface.
struct SurfaceHit {
  std::uint32_t shape = kNone, instance = kNone, primitive = 0;  ///< shape kNone: no hit
  float t = 0, u = 0, v = 0;
  Vec3f normal;  ///< geometric, any length
};

/// Traces chains, one ray at a time. One per worker and call of the stage.
class ChainTracer {
 public:
  ChainTracer(const SceneView& scene, const CausticCasters& casters) : scene_(scene), casters_(casters) {}

  /// Wavelengths of the next chains, nm, in spectral mode. The first of them determines refracted directions.
  void set_wavelengths(const Spectrum4& lambda) { lambda_ = lambda; }
  /// Time of the next chains, in [0, 1] over the shutter; 0 by default.
  void set_time(float time) { packet_.time[0] = time; }
  float time() const { return packet_.time[0]; }

  SurfaceHit intersect(Vec3f origin, Vec3f direction);
  /// Whether nothing lies between `origin` and `origin` + `direction`.
  bool is_open(Vec3f origin, Vec3f direction);

  bool is_caster(const SurfaceHit& hit) const { return casters_.is_caster(hit.shape, hit.instance); }
  /// The surface of a caster that `ray` has hit.
  CasterHit surface(const DifferentialRay& ray, const SurfaceHit& hit) const;
  /// Probability with which BSDF sampling reflects at a hit; 1: it never refracts. 0 if it does neither.
  float reflection_probability(const CasterHit& hit, Vec3f direction) const;
  /// Scatters the ray at a hit. Returns false if the surface does not scatter that way. Multiplies `weight`, unless
  /// null, by the weight of BSDF sampling times the probability of the choice.
  bool scatter(const CasterHit& hit, bool refract, DifferentialRay& ray, Spectrum4* weight);

  /// Follows a ray along a chain of a given type to the ray that leaves its last vertex. Returns false if there is no
  /// such chain. `weight`: as for scatter().
  bool follow(const ChainType& type, DifferentialRay& ray, Spectrum4* weight = nullptr);

  /// CausticCasters::sample_point() at the time of the chains.
  Vec3f sample_caster_point(const Random4<Scalar>& u) const { return casters_.sample_point(scene_, u, time()); }
  /// Whether any caster is a dielectric.
  bool has_glass() const { return casters_.has_glass(); }

  std::uint64_t rays() const { return rays_; }

 private:
  float first_index(std::uint32_t material) const;

  const SceneView& scene_;
  const CausticCasters& casters_;
  Spectrum4 lambda_{};
  RayPacket packet_;
  std::uint64_t rays_ = 0;
};

}  // namespace sheaf
