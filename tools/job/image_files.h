// Input and output images of commands: checks of file names, overwriting and formats, and writing.
#pragma once

#include "core/image/exr.h"
#include "tools/job/output_options.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sheaf {

/// The file extension in lower case, with its dot.
std::string extension_of(const std::filesystem::path& path);

/// Throws Error (exit code 2) unless the file extension is that of an output format: .exr, .png, .jpg, .jpeg, .tif or
/// .tiff.
void check_image_name(const std::filesystem::path& path);

/// The output formats, for help texts.
inline constexpr const char* kOutputFormats =
    ".exr (linear floats, all layers), .png or .jpg (8 bits, sRGB), or .tif (16 bits, sRGB)";

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

/// Throws Error (exit code 4) unless all files can be written; see check_writable().
void check_all_writable(std::span<const NamedFile> written);

/// Calls write() and prints the error if it throws. Returns whether it succeeded, so that callers can continue with
/// other outputs.
bool try_to_write(const std::function<void()>& write);

/// The image that files of formats other than OpenEXR show: the denoised one if there is one, exposed and mapped. Sets
/// `exposure` to an exposure that was chosen automatically, stops.
Image displayed_image(const Image& image, const OutputSettings& settings, std::optional<double>& exposure);

/// Writes the image to a file. `display` returns the displayed image; it is called for formats other than OpenEXR.
/// Throws Error (exit code 4).
void write_image(const std::filesystem::path& file, const Image& image, const ExrMetadata& metadata,
                 const OutputSettings& settings, const std::function<const Image&()>& display);

/// Files that write_images() wrote.
struct WrittenImages {
  std::vector<std::filesystem::path> files;
  std::string denoiser = {};       ///< its name on the command line; empty if the image is not denoised
  std::optional<double> exposure;  ///< stops; only if it was chosen automatically and affects a file
  Shown shown = Shown::kPicture;   ///< by the files of formats other than OpenEXR
  double helpful_exposure = 0;     ///< stops; only if they show no picture
};

/// Writes the image to each file, regardless of failures of others. Formats other than OpenEXR show the denoised image
/// if there is one, exposed and mapped by the settings; their description is the interruption(), if any.
WrittenImages write_images(const std::vector<std::filesystem::path>& files, const Image& image,
                           const ExrMetadata& metadata, const OutputSettings& settings);

}  // namespace sheaf
