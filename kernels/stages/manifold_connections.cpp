// Stage: manifold connections. Connects non-specular vertices to lights by chains of specular vertices (Zeltner,
// Georgiev and Jakob 2020, "Specular Manifold Sampling for Rendering High-Frequency Caustics and Glints", the unbiased
// variant of section 4.2).
//
// A seed and a manifold walk find one of the chains between the vertex and a sampled point on a light, with an unknown
// probability. Further walks from new seeds, until one finds the same chain again, give an unbiased estimate of the
// reciprocal of that probability: their number. The expected number of walks is one plus the number of chains.
// kernels/stages/chain_state.h states which light the emission stage leaves to this stage.
#include "kernels/bsdf/list.h"
#include "kernels/caustics/chain_light.h"
#include "kernels/stages/chain_state.h"
#include "kernels/stages/normal_map.h"
#include "kernels/stages/shading_frame.h"
#include "kernels/stages/stage_list.h"
#include "kernels/wave/add_radiance.h"
#include "kernels/wave/load_bsdf.h"
#include "kernels/wave/path_time.h"
#include "kernels/wave/path_wavelengths.h"
#include "kernels/wave/stage_timer.h"

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Maximum number of walks (Bernoulli trials) that estimate the probability of one chain. Chains of lower probability
/// are too dark; Stats::Chains::capped counts them.
constexpr std::uint64_t kMaxTrials = 1u << 16;
/// Probability of an attempt at vertices that are not the first non-specular one of their path.
constexpr float kLaterAttempts = 0.25f;

/// A vertex with its BSDF.
template <template <class> class Bsdf> class BsdfStart : public ChainStart {
 public:
  BsdfStart(const SceneView& scene, const Wave& wave, int column, bool mapped)
      : BsdfStart(scene, wave, column, mapped, wave.vertices.load<Scalar>(column)) {}

  /// Whether the BSDF scatters light from a direction, of unit length.
  bool accepts(Vec3f direction) const { return max_component(f_cos(direction)) > 0; }

  /// BSDF times cosine for light from `direction`.
  Spectrum4 f_cos(Vec3f direction) const {
    const Vec3f wi = frame_.to_local(direction);
    const Spectrum4 value = bsdf_.evaluate(wo_, wi).f_cos;
    if (!mapped_) return value;
    return value * shadow_terminator<Scalar>(textured_.ns_unmapped, textured_.terminator, direction, wi.z);
  }
  /// Whether light from `direction` keeps the first of four wavelengths only.
  bool loses_wavelengths_from(Vec3f direction) const {
    return loses_wavelengths<Scalar>(bsdf_, wo_, frame_.to_local(direction));
  }

 private:
  BsdfStart(const SceneView& scene, const Wave& wave, int column, bool mapped, const VertexItem<Scalar>& item)
      : ChainStart{item.p, item.ng, item.offset},
        bsdf_(load_bsdf<Scalar, Bsdf>(scene, wave, column)),
        frame_(item),
        wo_(item.wo),
        mapped_(mapped) {
    if (mapped) textured_ = wave.textured.load<Scalar>(column);
  }

  Bsdf<Scalar> bsdf_;
  ShadingFrame<Scalar, Bsdf<Scalar>::kIsAnisotropic> frame_;
  Vec3f wo_;
  bool mapped_;
  TexturedItem<Scalar> textured_;
};

/// Walks from random seeds for one vertex and one point on a light.
template <template <class> class Bsdf> struct ChainSearch {
  const StageContext& context;
  ChainTracer& tracer;
  const BsdfStart<Bsdf>& start;
  const ChainTarget& target;
  int max_length;
  MediumRandom& random;

  std::optional<ConnectedChain> walk() {
    const Vec3f direction = sample_seed_direction(tracer, start, target, random);
    if (!is_finite(direction) || !start.accepts(direction)) return {};
    const auto seed = sample_seed_type(tracer, start, target, direction, max_length, random);
    if (!seed) return {};
    return walk_to_target(tracer, start, target, seed->type, seed->direction);
  }

  /// Number of walks up to the first that finds `chain` again: an estimate of the reciprocal of its probability.
  std::uint64_t walks_to(const ConnectedChain& chain, Stats::Chains& stats) {
    for (std::uint64_t count = 1; count < kMaxTrials; ++count) {
      ++stats.trials;
      const auto found = walk();
      if (found && is_same_chain(*found, chain)) return count;
    }
    ++stats.capped;
    return kMaxTrials;
  }
};

/// Maximum number of specular vertices behind a vertex of this path.
int max_length_of(const StageContext& context, const PathState<Scalar>& path) {
  if (context.max_depth < 0) return kMaxChainLength;
  return std::min(kMaxChainLength, context.max_depth - 2 - static_cast<int>(path.depth()));
}

template <template <class> class Bsdf>
void connect_vertex(const StageContext& context, Wave& wave, ChainTracer& tracer, Slot slot, int column, bool mapped) {
  const SceneView& scene = context.scene;
  const PathState<Scalar>& path = wave.paths.row(slot);
  const int max_length = max_length_of(context, path);
  if (max_length < 1) return;
  // Attempt a connection with a probability
  MediumRandom random(context.sampler.seed, path.pixel, path.sample, path.dimension(), MediumStream::kCaustics);
  const float probability = chain_state<Scalar>(wave.rays.row(slot).flags) == 0 ? 1.0f : kLaterAttempts;
  if (random.next() >= probability) return;
  Stats::Chains& stats = wave.stats.chains;
  ++stats.attempts;
  // Sample a point on a light, and find a chain to it
  Spectrum4 lambda;
  if (scene.color == ColorMode::kSpectral) lambda = path_wavelengths<Scalar>(wave, &slot);
  tracer.set_wavelengths(lambda);
  const float time = path_time(scene, wave, slot);
  tracer.set_time(time);
  const BsdfStart<Bsdf> start(scene, wave, column, mapped);
  const auto end = sample_chain_light(scene, context.caustic_casters(), start.p, time, lambda, random);
  if (!end) return;
  ChainSearch<Bsdf> search{context, tracer, start, end->target, max_length, random};
  const auto chain = search.walk();
  if (!chain) return;
  // Compute the contribution of the chain
  if (start.loses_wavelengths_from(chain->direction)) lambda = Spectrum4(lambda.c0);
  tracer.set_wavelengths(lambda);
  Spectrum4 weight = path.beta * start.f_cos(chain->direction);
  DifferentialRay ray = start.ray(chain->direction);
  if (!tracer.follow(chain->type, ray, &weight)) return;
  const float cosine = std::fabs(dot(start.ng, chain->direction));
  weight = weight * arriving_light(tracer, scene, context.caustic_casters(), *end, *chain, cosine, lambda) *
           (1 / probability);
  if (!is_finite(total(weight)) || is_black(weight)) return;
  ++stats.solutions;
  weight = weight * static_cast<float>(search.walks_to(*chain, stats));
  add_radiance(wave, slot, Float4(weight), end->light, 1 + chain->type.length);
}

}  // namespace

template <class L> void manifold_connections(const StageContext& context, Wave& wave) noexcept {
  StageTimer timer(wave.stats, stage_named<L>("manifold_connections"));
  ChainTracer tracer(context.scene, context.caustic_casters());
  for_each_bsdf([&]<template <class> class Bsdf>(ClosureKind kind, BsdfTag<Bsdf>) {
    if constexpr (!Bsdf<Scalar>::kIsSpecular && !kIsPhaseFunction<Bsdf<Scalar>>) {
      const VertexRun& run = wave.runs[static_cast<int>(kind)];
      const bool mapped = (context.scene.materials.buckets.kind_flags[static_cast<int>(kind)] & kMapped) != 0;
      timer.count(run.count, 1);
      for (int i = 0; i < run.count; ++i)
        connect_vertex<Bsdf>(context, wave, tracer, wave.sorted[run.slot_begin + i], run.column_begin + i, mapped);
    }
  });
  wave.stats.chains.rays += tracer.rays();
}

SHEAF_INSTANTIATE_STAGE(manifold_connections);

}  // namespace sheaf
