// Which random number is used for what. Every decision of a path has its own named block of four dimensions, so that
// no two decisions share numbers and adding a stage does not shift those of another.
#pragma once

#include "core/rng.h"

namespace sheaf {

/// Blocks of four dimensions. Camera comes once per path, the others once per path event (interaction).
enum class SampleBlock : std::uint32_t {
  kCamera,   ///< x, y: position in the pixel; z, w: position on the lens
  kLight,    ///< x: which light; y, z: point on it; w: which part of it
  kScatter,  ///< x: which lobe; y, z: direction; w: roulette
  kSelect,   ///< x: which part of a composite material
  kCount,
};

/// The numbers of `block` at a path's event `event` (0 for the camera).
template <class L>
SHEAF_INLINE Random4<L> draw(std::uint32_t seed, typename L::Uint pixel, typename L::Uint sample,
                             typename L::Uint event, SampleBlock block) {
  using U = typename L::Uint;
  return random4<L>(seed, pixel, sample,
                    event * U(static_cast<std::uint32_t>(SampleBlock::kCount)) + U(static_cast<std::uint32_t>(block)));
}

}  // namespace sheaf
