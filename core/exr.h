// OpenEXR files: writing rendered layers with their metadata, reading any flat image.
#pragma once

#include "core/color_space.h"
#include "core/image.h"
#include "core/pixel_rect.h"
#include "core/transform.h"

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace sheaf {

/// What an EXR file says besides its pixels.
struct ExrMetadata {
  struct Attribute {
    std::string name;  ///< e.g. "sheaf/seed"
    std::variant<int, float, std::string> value;
  };
  std::vector<Attribute> attributes;        ///< written as given; each name once
  std::string software;                     ///< the Software attribute; left out if empty
  std::optional<Matrix4> world_to_camera;   ///< points are columns; camera space as in OpenEXR: looks along -z, +y up
  std::vector<std::string> half_channels;   ///< channels stored with 16 bits; all others are 32-bit float
  std::optional<std::string> capture_date;  ///< "YYYY:MM:DD hh:mm:ss" local time; left out if not given
};

/// Whether the file starts as an OpenEXR file does. False if it cannot be read.
bool is_exr(const std::filesystem::path& path);

/// Writes one part, ZIP-compressed scan lines, with the image as data window and the frame as display window. The same
/// arguments give the same bytes. Throws Error (exit code 4).
void write_exr(const std::filesystem::path& path, const Image& image, const ExrMetadata& metadata = {});

/// Reads the first part, scan lines or tiles, all channels as float, with the windows as the image's place in its
/// frame. Channels come in the file's order, which is alphabetical. Throws SceneError if the file is missing,
/// malformed, truncated, deep, subsampled or beyond the limits of core/image.h.
Image read_exr(const std::filesystem::path& path);

/// What a file says of one of its parts.
struct ExrPart {
  std::string name;                   ///< may be empty
  bool deep = false;                  ///< any number of samples in a pixel
  std::vector<std::string> channels;  ///< in the file's order
  std::optional<RgbChromaticities> chromaticities;
};

/// All parts, at least one. Throws as read_exr() does.
std::vector<ExrPart> read_exr_parts(const std::filesystem::path& path);

/// Reads some channels of a part, in the order of `channels`, which must be there. Throws as read_exr() does.
Image read_exr_channels(const std::filesystem::path& path, std::size_t part, std::vector<std::string> channels);

/// The string, integer and float attributes of the first part, in the file's order. Throws as read_exr() does.
std::vector<ExrMetadata::Attribute> read_exr_attributes(const std::filesystem::path& path);

/// All of what write_exr() writes besides pixels, for files that are written anew with other channels. Throws as
/// read_exr() does.
ExrMetadata read_exr_metadata(const std::filesystem::path& path);

/// What the header of a file's first part says.
struct ExrHeader {
  struct Channel {
    std::string name;
    const char* type;  ///< "half", "float" or "uint"
  };
  PixelRect frame, window;  ///< display window and data window, in the file's coordinates
  std::vector<Channel> channels;
  std::vector<ExrMetadata::Attribute> attributes;  ///< strings, integers and floats, in the file's order
};

/// Throws as read_exr() does, but for what lies behind the header.
ExrHeader read_exr_header(const std::filesystem::path& path);

}  // namespace sheaf
