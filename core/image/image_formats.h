// The formats of image files other than OpenEXR.
#pragma once

#include "core/image/image_encoding.h"
#include "core/image/image_reader.h"
#include "core/image/image_source.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sheaf {

/// A format of image files.
struct ImageFormat {
  std::string_view name{};
  std::vector<std::string_view> extensions{};  ///< in lower case, with their dots
  std::vector<std::string_view> magic{};       ///< one of these marks the format; empty: the extension does
  std::size_t magic_at = 0;                    ///< position of the magic number, bytes
  std::optional<IntegerFormat> written{};      ///< also written
  bool in_memory = false;               ///< also read from memory: a format of images that are part of other files
  std::uint64_t min_counted_bytes = 0;  ///< what check_image_size() assumes of smaller files
  /// Opens a file. On failure returns null and sets `problem`.
  std::unique_ptr<ImageReader> (*open)(ImageSource source, std::string& problem) = nullptr;
  std::string_view library{};          ///< that reads it; empty: Sheaf itself
  std::string (*version)() = nullptr;  ///< of the library
};

/// All formats, in the order in which they are tried.
std::span<const ImageFormat> image_formats();

/// The names of all formats and OpenEXR, or of those that are read from memory: "PNG, JPEG or WebP".
std::string list_image_formats(bool in_memory = false);

/// Finds the format of an image file by its magic number, or by its extension for formats that have none. Throws
/// SceneError for unsupported formats.
const ImageFormat& find_image_format(ImageSource& source);

}  // namespace sheaf
