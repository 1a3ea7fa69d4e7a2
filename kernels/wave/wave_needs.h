// Which of a wave's columns a scene asks for: what is not needed takes no part of the cache.
#pragma once

#include "kernels/wave/context.h"

namespace sheaf {

/// Columns that not every scene needs; all of them unless told otherwise.
struct WaveNeeds {
  bool spectral = true;                  ///< wavelengths
  bool transparency = true;              ///< what shadow rays need where they may pass media and surfaces
  bool distance = true;                  ///< from the last vertex, where rays may go on behind a surface
  bool textures = true;                  ///< what lookups and normal maps need to know of vertices
  bool candidates = true;                ///< light candidates
  bool reservoirs = true;                ///< resampling of several light candidates
  bool light_tops = true;                ///< upper turns in the light tree, which many candidates have in common
  bool raster_positions = true;          ///< where photons are seen by the camera
  std::uint32_t counted_lights = 0;      ///< whose shadow rays are counted apart
  bool guides = true;                    ///< places of the guide
  int closure_words = kMaxClosureWords;  ///< longest parameters of a closure

  static WaveNeeds of(const StageContext& context);
};

}  // namespace sheaf
