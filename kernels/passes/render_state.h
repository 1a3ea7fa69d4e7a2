// What a render is between two of its tasks, and how that is kept in a file: a checkpoint.
#pragma once

#include "core/stats.h"
#include "kernels/film/adaptive_film.h"
#include "kernels/film/splat.h"

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sheaf {

/// All that a render goes on from. What else it works with it makes anew: photon maps, and what a guide has learned.
struct RenderState {
  Film film;                             ///< without what the tiles of the pass at work bring to each other
  std::uint32_t first_sample = 0;        ///< per pixel, of the pass at work; where there is none, of the next one
  std::vector<std::uint8_t> tiles;       ///< of that pass: 1 for those that are done; empty: it has not begun
  std::vector<FilmBorder> borders;       ///< of these tiles
  std::optional<AdaptiveFilm> adaptive;  ///< adaptive sampling: the sums of tiles, of which `film` is the picture
  std::optional<SplatFilm> splats;       ///< light tracing: what photons have added
  std::uint64_t photons = 0;             ///< that were emitted
  Stats::Dropped dropped;                ///< up to the last time that the render was taken up
};

/// What a render depends on, as names and values for people to read.
using RenderSettings = std::vector<std::pair<std::string, std::string>>;

/// Writes a checkpoint; the file appears whole or not at all. Throws Error (exit code 4).
void write_checkpoint(const std::filesystem::path& file, const RenderSettings& settings, const RenderState& state);

/// Reads one. Throws Error (exit code 5) for a file that cannot be read, is damaged or none of this version, and where
/// it was made with other settings: the message says which.
RenderState read_checkpoint(const std::filesystem::path& file, const RenderSettings& settings);

}  // namespace sheaf
