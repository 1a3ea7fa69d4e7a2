// Films in files: all sums and counts as they are, so that what is read goes on as if it had never been written.
#pragma once

#include "core/binary_file.h"
#include "kernels/film/adaptive_film.h"
#include "kernels/film/film.h"
#include "kernels/film/splat.h"

namespace sheaf {

void put_film(BinaryOutput& out, const Film& film);
/// Throws Error (exit code 5) for what cannot be a film.
Film get_film(BinaryInput& in);

/// What tiles bring to each other; `in`: to the film that they are of.
void put_borders(BinaryOutput& out, const std::vector<FilmBorder>& borders);
std::vector<FilmBorder> get_borders(BinaryInput& in, const Film& film);

/// The sums of tiles; `of`: the film that they become.
void put_adaptive(BinaryOutput& out, const AdaptiveFilm& film);
AdaptiveFilm get_adaptive(BinaryInput& in, const Film& of);

/// The sums of splats; `film`: one of the same crop and filter.
void put_splats(BinaryOutput& out, const SplatFilm& film);
void get_splats(BinaryInput& in, SplatFilm& film);

}  // namespace sheaf
