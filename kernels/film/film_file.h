// Serialization of films for checkpoints. All sums and counts are stored exactly, so a restored render continues to the
// same bits.
#pragma once

#include "core/io/binary_file.h"
#include "kernels/film/adaptive_film.h"
#include "kernels/film/film.h"
#include "kernels/film/splat.h"

namespace sheaf {

void put_film(BinaryOutput& out, const Film& film);
/// Throws Error (exit code 5) for an invalid film.
Film get_film(BinaryInput& in);

/// Contributions of tiles to the pixels of other tiles. `film`: the film of these tiles.
void put_borders(BinaryOutput& out, const std::vector<FilmBorder>& borders);
std::vector<FilmBorder> get_borders(BinaryInput& in, const Film& film);

/// Sums of an adaptive film. `of`: the film that they are assembled into.
void put_adaptive(BinaryOutput& out, const AdaptiveFilm& film);
AdaptiveFilm get_adaptive(BinaryInput& in, const Film& of);

/// Sums of splats. `film`: a splat film with the same crop window and filter.
void put_splats(BinaryOutput& out, const SplatFilm& film);
void get_splats(BinaryInput& in, SplatFilm& film);

}  // namespace sheaf
