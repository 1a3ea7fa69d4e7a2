// OpenEXR files: writing of rendered layers with metadata, and reading of any flat image.
#pragma once

#include "core/color/color_space.h"
#include "core/image/image.h"
#include "core/image/pixel_rect.h"
#include "core/math/transform.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace sheaf {

/// Compression of EXR files. kDwaa and kDwab are lossy for channels named R, G, B or Y in any
/// layer.
enum class ExrCompression { kUncompressed, kRle, kZips, kZip, kPiz, kDwaa, kDwab };

/// Metadata of an EXR file, and how it is stored.
struct ExrMetadata {
  struct Attribute {
    std::string name;  ///< e.g. "sheaf/seed"
    std::variant<int, float, double, std::string> value;
  };
  std::vector<Attribute> attributes;        ///< written as given; names are unique
  std::string software;                     ///< the Software attribute; left out if empty
  std::optional<Matrix4> world_to_camera;   ///< for column vectors; camera space as in OpenEXR: looks along -z, +y up
  std::vector<std::string> half_channels;   ///< channels stored as 16-bit half; all others are 32-bit float
  std::optional<std::string> capture_date;  ///< "YYYY:MM:DD hh:mm:ss" local time; left out if not given
  ExrCompression compression = ExrCompression::kZip;
  float dwa_level = 45;  ///< kDwaa, kDwab: compression level; larger values give smaller files and larger errors
};

/// An attribute with an integer: stored as int if it fits, otherwise as double.
ExrMetadata::Attribute integer_attribute(std::string name, std::uint64_t value);

/// The number in an attribute: an int, float or double, or a decimal number as text. Nothing if it is not a number.
std::optional<double> number_of(const ExrMetadata::Attribute& attribute);

/// Whether the file has the magic number of OpenEXR. False if it cannot be read.
bool is_exr(const std::filesystem::path& path);

/// Writes one part with scan lines. The image becomes the data window, its frame the display window. The
/// same arguments give the same bytes. Throws Error (exit code 4).
void write_exr(const std::filesystem::path& path, const Image& image, const ExrMetadata& metadata = {});

/// Reads all channels of the first part as float, from scan lines or tiles. The windows determine the position of the
/// image in its frame. Channels keep the order of the file, which is alphabetical. Throws SceneError if the file is
/// missing, malformed, truncated, deep, subsampled or beyond the limits of core/image/image.h.
Image read_exr(const std::filesystem::path& path);

/// The header of one part of a file.
struct ExrPart {
  std::string name;                   ///< may be empty
  bool deep = false;                  ///< pixels hold any number of samples
  std::vector<std::string> channels;  ///< in the file's order
  std::optional<RgbChromaticities> chromaticities;
};

/// Reads the headers of all parts, at least one. Throws like read_exr() if the file is missing or malformed.
std::vector<ExrPart> read_exr_parts(const std::filesystem::path& path);

/// Reads the given channels of a part, in the order of `channels`. Throws like read_exr(), and if a channel is missing.
Image read_exr_channels(const std::filesystem::path& path, std::size_t part, std::vector<std::string> channels);

/// Reads the string and number attributes of the first part, in the order of the file. Throws like read_exr().
std::vector<ExrMetadata::Attribute> read_exr_attributes(const std::filesystem::path& path);

/// Reads all metadata that write_exr() writes, without the compression, for rewriting a file with other channels.
/// Throws like read_exr().
ExrMetadata read_exr_metadata(const std::filesystem::path& path);

/// The header of the first part of a file.
struct ExrHeader {
  struct Channel {
    std::string name;
    const char* type;  ///< "half", "float" or "uint"
  };
  PixelRect frame, window;  ///< display window and data window, in the file's coordinates
  std::vector<Channel> channels;
  std::vector<ExrMetadata::Attribute> attributes;  ///< strings and numbers, in the file's order
};

/// Reads the header of the first part. Throws like read_exr() if the file is missing or its header is malformed.
ExrHeader read_exr_header(const std::filesystem::path& path);

}  // namespace sheaf
