// Input and output images of commands: checks of file names, overwriting and formats, and writing.
#pragma once

#include "core/exr.h"

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace sheaf {

/// The file extension in lower case, with its dot.
std::string extension_of(const std::filesystem::path& path);

/// Throws Error (exit code 2) unless the file extension is .exr or .png.
void check_image_name(const std::filesystem::path& path);

/// A file that a command writes or reads, with its description for messages: "the image", "--stats".
struct NamedFile {
  std::string what;
  std::filesystem::path file;
};

/// Turns the output images of a command line into NamedFiles, after check_image_name().
std::vector<NamedFile> named_images(const std::vector<std::string>& files);

/// Throws SceneError, which names the actual format, unless the file is an OpenEXR image. Does not throw for a missing
/// file, for which the readers have better messages.
void check_is_exr(const std::filesystem::path& file);

/// Like check_is_exr() for images of any format. Judges by the file's content or name.
void check_is_image(const std::filesystem::path& file);

/// Throws Error (exit code 2) if two outputs are the same file, or if an output is one of `sources`.
void check_overwriting(std::span<const NamedFile> written, std::span<const NamedFile> sources);

/// Throws Error unless all files can be written: exit code 4, see check_writable(), or 1 for .png if the image library
/// is missing.
void check_all_writable(std::span<const NamedFile> written);

/// Calls write() and prints the error if it throws. Returns whether it succeeded, so that callers can continue with
/// other outputs.
bool try_to_write(const std::function<void()>& write);

/// Writes the image to each file, regardless of failures of others. Returns the files that were written. PNG files show
/// the denoised image if there is one; their description is the interruption(), if any.
std::vector<std::filesystem::path> write_images(const std::vector<std::filesystem::path>& files, const Image& image,
                                                const ExrMetadata& metadata);

}  // namespace sheaf
