// The columns of a wave that a scene needs. Columns that are not needed are not allocated and take no cache.
#pragma once

#include "kernels/wave/context.h"

namespace sheaf {

/// Columns that not every scene needs. The default needs all of them.
struct WaveNeeds {
  bool spectral = true;                  ///< wavelengths
  bool times = true;                     ///< times of paths
  bool transparency = true;              ///< RescaledPdfs and TransmittanceItem
  bool distance = true;                  ///< distance from the last vertex, for rays that continue behind a surface
  bool textures = true;                  ///< inputs of textures and normal maps
  bool candidates = true;                ///< light candidates
  bool reservoirs = true;                ///< resampling of several light candidates
  bool light_cuts = true;                ///< cuts of the light tree, shared by the candidates of a vertex
  bool candidate_moments = true;         ///< moments by the number of light candidates
  bool raster_positions = true;          ///< film positions of photons' vertices
  std::uint32_t counted_lights = 0;      ///< lights whose shadow rays are counted separately
  bool guides = true;                    ///< guide cells
  bool chains = true;                    ///< starts of specular chains
  bool segments = true;                  ///< segments in media, which are connected to lights
  int closure_words = kMaxClosureWords;  ///< words of the longest closure

  static WaveNeeds of(const StageContext& context);
  /// Union of the needs of passes that compare numbers of light candidates and of the final passes.
  static WaveNeeds with_candidate_moments(const StageContext& context);
};

}  // namespace sheaf
