// The state of a render between two tasks, and checkpoint files that store it.
#pragma once

#include "kernels/film/adaptive_film.h"
#include "kernels/film/splat.h"
#include "kernels/render/sample_division.h"
#include "kernels/wave/wave_stats.h"

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sheaf {

/// The state of a sample plan: everything from which a render resumes. Photon maps and the guide are not stored but
/// computed again.
struct RenderState {
  SampleDivision division;               ///< of the render that wrote the state
  Film film;                             ///< without the borders of the tiles of the current pass
  std::uint32_t first_sample = 0;        ///< per pixel, of the current pass, or of the next one between passes
  std::vector<std::uint8_t> tiles;       ///< of the current pass: 1 for tiles that are done; empty: not begun
  std::vector<FilmBorder> borders;       ///< of these tiles
  std::optional<AdaptiveFilm> adaptive;  ///< adaptive sampling: sums of tiles, from which `film` is assembled
  std::optional<SplatFilm> splats;       ///< light tracing: contributions of photons
  std::uint64_t photons = 0;             ///< number of photons emitted
  Stats::Dropped dropped;                ///< of this render and of those that it resumes
};

/// A setting on which a render depends.
struct RecordedSetting {
  enum class Kind {
    kProgram,  ///< version and instruction set
    kOption,   ///< an option that all parts of an image share
    kPart,     ///< an option that selects a part of the image
    kFile,     ///< a file of the scene
  };
  std::string name, value;    ///< readable; all that checkpoints store
  Kind kind = Kind::kOption;  ///< not known for settings of a checkpoint
};
using RecordedSettings = std::vector<RecordedSetting>;

/// Name of the setting that holds the version of Sheaf, the first of every checkpoint.
inline constexpr const char* kVersionSetting = "Sheaf's version";

/// Writes a checkpoint atomically. Throws Error (exit code 4).
void write_checkpoint(const std::filesystem::path& file, const RecordedSettings& settings, const RenderState& state);

/// Reads a checkpoint. Throws Error (exit code 5) if the file cannot be read, is damaged, was written by another
/// version of Sheaf, or belongs to other settings, which the message names. --spp may differ, and then
/// --replicates, too; continue_from() judges them.
RenderState read_checkpoint(const std::filesystem::path& file, const RecordedSettings& settings);

}  // namespace sheaf
