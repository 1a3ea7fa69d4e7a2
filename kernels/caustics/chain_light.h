// The light at the end of a specular chain, and the weights of the two techniques that find it: manifold walks to a
// sampled point on the light, and sampling the BSDF of the vertex.
//
// The probability with which walks find a chain has no closed form. Any weights that depend on the path alone and add
// up to 1 keep the sum unbiased, so an assumed probability replaces it. The weights are the power heuristic of two
// densities per area of the light:
//     walks           assumed probability x density of the point on the light
//     BSDF sampling   cosine / pi x solid angle of the first direction per area of the light
// Specular vertices have the same probabilities in both. Near caustics the solid angle per area, which is a factor of
// what a walk contributes, is unbounded; there BSDF sampling has all the weight.
#pragma once

#include "kernels/caustics/manifold_walk.h"

namespace sheaf {

/// A sampled end of chains.
struct ChainLight {
  ChainTarget target;
  std::uint32_t light;  ///< row
  float pdf;            ///< probability of the light; area lights: times the density of the point, 1/m^2
};

/// Samples a light and a point on it, independently of the vertex that it shines on, at a time in [0, 1]. `lambda`:
/// spectral mode. `p`: any point outside of the lights. Empty if the sample is unusable.
std::optional<ChainLight> sample_chain_light(const SceneView& scene, const CausticCasters& casters, Vec3f p, float time,
                                             const Spectrum4& lambda, MediumRandom& random);

/// Light that arrives at the start of a chain along its direction at the time of the tracer, over the pdf of `end` and
/// with its MIS weight: radiance times solid angle, with the specular vertices taken as lossless. 0 if something lies
/// between the chain and the light. `cosine`: absolute, of the first direction to the geometric normal of the vertex.
Spectrum4 arriving_light(ChainTracer& tracer, const SceneView& scene, const CausticCasters& casters,
                         const ChainLight& end, const ConnectedChain& chain, float cosine, const Spectrum4& lambda);

/// A point on an area light that the last ray of a chain hits.
struct ChainEnd {
  Vec3f from, direction;    ///< the last ray; unit length
  float t;                  ///< distance, m
  Vec3f ng;                 ///< geometric normal of the light
  std::uint32_t light;      ///< row
  std::uint32_t primitive;  ///< triangle of the light
  float time;               ///< in [0, 1]
};

/// The weight of BSDF sampling for a chain; that of manifold walks is 1 minus it. `ratio`:
/// ConnectedChain::solid_angle_ratio.
float chain_bsdf_weight(const SceneView& scene, const CausticCasters& casters, const ChainEnd& end, float ratio,
                        float cosine);

}  // namespace sheaf
