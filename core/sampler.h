// Which random number is used for what. Every decision of a path has its own named block of four dimensions, so that
// no two decisions share numbers and adding a stage does not shift those of another.
#pragma once

#include "core/stratified.h"

namespace sheaf {

/// Blocks of four dimensions. Camera comes once per path, the others once per interaction.
enum class SampleBlock : std::uint32_t {
  kCamera,   ///< x, y: position in the pixel; z, w: position on the lens, without which z: the wavelengths
  kLight,    ///< x: which light; y, z: point on it; w: which part of it
  kScatter,  ///< x: which lobe; y, z: direction; w: roulette
  /// x: which part of a composite material, spread together with kScatter by kSobol and kZSobol; y: how far the path
  /// goes in a medium, or to its first collision there; z: the same of a shadow ray
  kSelect,
  kResample,  ///< x: which of several light candidates
  kCount,
  /// x: the wavelengths with a lens; once per path, at dimension 0: what kCamera would have at dimension 1.
  kWavelength = kCount,
};

/// How the samples of a pixel are spread within a block. Blocks (but for kSelect's x), events and (but for kZSobol)
/// pixels are independent of each other, and every number by itself is uniform, whatever the kind.
enum class SamplerKind : std::uint32_t {
  kIndependent,  ///< not at all
  kStratified,   ///< one sample in each cell of a grid in the two planes of a block
  kMultijitter,  ///< and besides one in each of as many columns and rows (Kensler 2013)
  kSobol,        ///< Sobol sequence, Owen-scrambled: in all elementary intervals of a prefix of 2^k samples
  /// One Sobol sequence for all pixels, which take their samples from it in the order of a Z-shaped curve: what one
  /// pixel has too much of its neighbours have too little of (Ahmed and Wonka 2020).
  kZSobol,
};

/// A sampler: what all numbers of a render depend on besides pixel, sample and block. Made by make_sampler().
struct SamplerView {
  SamplerKind kind = SamplerKind::kSobol;
  std::uint32_t seed = 0;
  SampleGrid grid = {};            ///< kStratified, kMultijitter
  std::uint32_t first_sample = 0;  ///< of each pixel, from which on samples are spread
  /// kZSobol: the frame's width, pixel / frame_width being the row; below 2^30. Pixels are below 2^31.
  std::uint32_t frame_width = 1;
  std::uint32_t sample_count = 1;  ///< kZSobol: per pixel; at least 1
};

/// A sampler for `sample_count` samples per pixel, below or equal to 2^24, of a frame of this width. More may be drawn:
/// the sequence of kSobol has no end, grids are filled again in another order, kZSobol goes on with another sequence.
SamplerView make_sampler(SamplerKind kind, std::uint32_t seed, std::uint32_t sample_count,
                         std::uint32_t frame_width = 1);

/// The same sampler for paths that belong to no pixel, whose numbers of a pixel are anything and whose samples have no
/// end.
SamplerView without_frame(SamplerView sampler);

/// The same sampler for replicate `replicate`: the samples from replicate x `samples` on, independent of those before
/// and spread among themselves alone. Replicate 0 is the sampler as it is.
SamplerView sampler_of_replicate(SamplerView sampler, std::uint32_t replicate, std::uint32_t samples);

/// The smallest number of samples per pixel, `sample_count` or more, that a sampler spreads evenly: the size of its
/// grid for kStratified and kMultijitter, a power of two for kZSobol, any number for the others.
std::uint32_t rounded_sample_count(SamplerKind kind, std::uint32_t sample_count);

/// For decisions that need many numbers at once: which of `count` sets of four; the same in all lanes. The sets of
/// kSobol and kZSobol continue the sequence, so that sets of one sample are spread as evenly as those of different
/// samples; the other samplers spread each set over the samples alone.
struct SampleSet {
  std::uint32_t index = 0, count = 1;
};

/// The numbers of `block` at a path's `dimension` (0 for the camera, then one for each interaction): a pure function of
/// its arguments. The plane that is spread best is (x, y) for the camera and (y, z) elsewhere. `wanted`: which
/// RandomNumbers are asked for; the others may be anything, and cost less.
template <class L>
Random4<L> draw(const SamplerView& sampler, typename L::Uint pixel, typename L::Uint sample, typename L::Uint dimension,
                SampleBlock block, SampleSet set = {}, unsigned wanted = kAllNumbers) noexcept;

}  // namespace sheaf
