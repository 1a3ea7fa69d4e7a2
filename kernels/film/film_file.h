// Films as files: all sums and counts as they are, so that what is read goes on as if it had never been written.
//
// A file is one line of text, then binary data in the byte order of little-endian machines: the layout, the counts and
// the sums as the film holds them, and a check sum of all of that at the end. Not a format to exchange: the version in
// the first line changes whenever Film does.
#pragma once

#include "kernels/film/film.h"

namespace sheaf {

/// Writes a film; the file appears whole or not at all. Throws Error (exit code 4).
void write_film(const std::filesystem::path& file, const Film& film);

/// Reads a film. Throws Error (exit code 5) for a file that cannot be read, is none of this version, or is damaged.
Film read_film(const std::filesystem::path& file);

}  // namespace sheaf
