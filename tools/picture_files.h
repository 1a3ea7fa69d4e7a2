// The files that commands write: what may stand on the command line, what must not be overwritten, and how pictures get
// there.
#pragma once

#include "core/exr.h"

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace sheaf {

/// The extension in lower case, with its dot.
std::string extension_of(const std::filesystem::path& path);

/// Throws Error (exit code 2) unless the name ends in .exr or .png.
void check_picture_name(const std::filesystem::path& path);

/// A file that a command writes or reads, and what it is to people: "the picture", "--stats".
struct NamedFile {
  std::string what;
  std::filesystem::path file;
};

/// The pictures of a command line as such files, checked by check_picture_name().
std::vector<NamedFile> named_pictures(const std::vector<std::string>& files);

/// Throws SceneError unless the file is an OpenEXR picture, which says what it is instead. Without an error for a file
/// that is not there: readers know better why.
void check_is_exr(const std::filesystem::path& file);

/// The same for pictures of any format, as far as its name or beginning tells.
void check_is_picture(const std::filesystem::path& file);

/// Throws Error (exit code 2) if two of the files to write are one, or one of them is among `sources`.
void check_overwriting(std::span<const NamedFile> written, std::span<const NamedFile> sources);

/// Throws Error unless all of them can be written: exit code 4, see check_writable(), or 1 for a .png where there is no
/// library for it.
void check_all_writable(std::span<const NamedFile> written);

/// Calls write(), and says what went wrong if it throws. Returns whether it did not: what else there is to be saved is
/// to be tried all the same.
bool try_to_write(const std::function<void()>& write);

/// Writes the picture to each of the files, whatever becomes of the others, and returns those that are written. PNG
/// files show the denoised picture where there is one, and their description is the interruption(), if any.
std::vector<std::filesystem::path> write_pictures(const std::vector<std::filesystem::path>& files, const Image& image,
                                                  const ExrMetadata& metadata);

}  // namespace sheaf
