// Samplers: the random numbers of each decision of a path. Every decision has its own named block of four dimensions.
// So no two decisions use the same numbers, and a new stage does not shift the numbers of others.
#pragma once

#include "core/sampling/stratified.h"

namespace sheaf {

/// Blocks of four dimensions. kCamera is used once per path, the others once per interaction.
enum class SampleBlock : std::uint32_t {
  kCamera,   ///< x, y: position in the pixel; z, w: position on the lens, or without a lens z: the wavelengths
  kLight,    ///< x: selects the light; y, z: point on the light; w: part of the light
  kScatter,  ///< x: selects the lobe; y, z: direction; w: Russian roulette
  /// x: component of a composite material, which kSobol and kZSobol stratify together with kScatter; y: distance
  /// through a medium, or to the first collision in it; z: the same for a shadow ray
  kSelect,
  kResample,  ///< x: selects one of several light candidates
  kCount,
  /// x: the wavelengths if there is a lens; y: the time; once per path, at dimension 0. Photons: x: the wavelengths;
  /// y: the hero lane; z: the time. Occupies the block that kCamera would have at dimension 1.
  kWavelength = kCount,
};

/// Stratification of the samples of a pixel within a block. For every kind, each number by itself is uniform. Blocks
/// (except x of kSelect), interactions and (except for kZSobol) pixels are independent of each other.
enum class SamplerKind : std::uint32_t {
  kIndependent,  ///< no stratification
  kStratified,   ///< one sample in each cell of a grid, in both planes of a block
  kMultijitter,  ///< also one sample in each of as many columns and rows (Kensler 2013)
  kSobol,        ///< Sobol sequence, Owen-scrambled: a prefix of 2^k samples is stratified in all elementary intervals
  /// One Sobol sequence for all pixels, which take their samples from it in Z-order (Morton order). Errors of
  /// neighboring pixels then cancel (Ahmed and Wonka 2020).
  kZSobol,
};

/// A sampler: everything that determines the numbers of a render besides pixel, sample and block. Made by
/// make_sampler().
struct SamplerView {
  SamplerKind kind = SamplerKind::kSobol;
  std::uint32_t seed = 0;
  SampleGrid grid = {};            ///< kStratified, kMultijitter
  std::uint32_t first_sample = 0;  ///< first sample of each pixel that is stratified
  /// kZSobol: width of the frame, below 2^30; pixel / frame_width is the row. Pixels are below 2^31.
  std::uint32_t frame_width = 1;
  std::uint32_t sample_count = 1;  ///< kZSobol: per pixel; at least 1
};

/// Makes a sampler for `sample_count` samples per pixel, at most 2^24, of a frame of this width. More samples may be
/// drawn: kSobol continues its sequence, grids are filled again in another order, and kZSobol continues with another
/// sequence.
SamplerView make_sampler(SamplerKind kind, std::uint32_t seed, std::uint32_t sample_count,
                         std::uint32_t frame_width = 1);

/// The same sampler for paths that belong to no pixel. Their pixel index is arbitrary and their number of samples is
/// not limited.
SamplerView without_frame(SamplerView sampler);

/// The same sampler for replicate `replicate`: samples from replicate x `samples` on, which are independent of those
/// before and stratified among themselves only. Replicate 0 is the unchanged sampler.
SamplerView sampler_of_replicate(SamplerView sampler, std::uint32_t replicate, std::uint32_t samples);

/// The smallest number of samples per pixel, at least `sample_count`, that a sampler stratifies evenly: the size of its
/// grid for kStratified and kMultijitter, a power of two for kZSobol, any number for the others.
std::uint32_t rounded_sample_count(SamplerKind kind, std::uint32_t sample_count);

/// One of `count` sets of four numbers, for decisions that need many numbers at once; the same in all lanes. With
/// kSobol and kZSobol the sets continue the sequence, so the sets of one sample are stratified like those of different
/// samples. The other samplers stratify each set over the samples only.
struct SampleSet {
  std::uint32_t index = 0, count = 1;
};

/// Draws the numbers of `block` at a path's `dimension` (0 for the camera, then one for each interaction): a pure
/// function of its arguments. The best stratified plane is (x, y) for the camera and (y, z) elsewhere. `requested`:
/// mask of the RandomNumbers that are needed; the others are undefined and cost less.
template <class L>
Random4<L> draw(const SamplerView& sampler, typename L::Uint pixel, typename L::Uint sample, typename L::Uint dimension,
                SampleBlock block, SampleSet set = {}, unsigned requested = kAllNumbers) noexcept;

}  // namespace sheaf
