// Readers of image formats other than OpenEXR, and the interface to OpenImageIO and OpenColorIO. Those are loaded when
// an image needs them: with their 250 dependent libraries they take 0.2 s and 130 MB to load. PNG and JPEG need
// neither.
#pragma once

#include "core/image/image_reader.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace sheaf {

class ImageSource;

/// OpenImageIO behind an interface that does not depend on its headers.
class ImageLibrary {
 public:
  virtual ~ImageLibrary() = default;
  /// Opens an image file of `format`, as the library names it. On failure returns null and sets `problem`. If `bytes`
  /// is not empty, it is read instead of the file and kept by the reader.
  virtual std::unique_ptr<ImageReader> open(const std::string& path, const std::string& format, std::string& problem,
                                            std::vector<std::uint8_t> bytes = {}) const = 0;
  /// Encodes a TIFF file. `description`: text in the header; empty: none. On failure returns an empty vector and sets
  /// `problem`.
  virtual std::vector<unsigned char> encode_tiff(const IntegerPixels& pixels, const std::string& description,
                                                 std::string& problem) const = 0;
};

/// The library that links OpenImageIO.
inline constexpr char kImageLibrary[] = "sheaf_image_io.so";

/// Returns the library, which the first call loads and keeps. Throws Error (exit code 1) if it is missing or cannot be
/// loaded.
const ImageLibrary& image_library();

/// Returns the library's name for the format of an image file. Formats are recognized by their magic number; TGA, which
/// has none, by its file extension. Other formats of the library, for example video and medical images, are rejected
/// for security. In memory, only PNG, JPEG and WebP are supported. Throws SceneError for unsupported formats. Throws
/// Error (exit code 1) or SceneError for files that would make the library allocate more memory than is available, or
/// far more than they need.
std::string checked_image_format(ImageSource& source);
std::string checked_image_format(const std::filesystem::path& file);

/// Opens an image file of `format`, as returned by checked_image_format(), with the reader of that format. `bytes`:
/// read instead of a file on the disk; empty: none. On failure returns null and sets `problem`. Throws like
/// image_library().
std::unique_ptr<ImageReader> open_image_reader(ImageSource source, const std::string& format, std::string& problem,
                                               std::vector<std::uint8_t> bytes = {});

/// The size for check_image_size() of a file of `format`: WebP files of a few bytes may hold large images of one
/// color.
std::size_t counted_image_bytes(const ImageSource& source, const std::string& format);

/// The function that sheaf_image_io.so exports. It returns the library.
using ImageLibraryFunction = const ImageLibrary*();
inline constexpr char kImageLibraryFunction[] = "sheaf_image_library";

}  // namespace sheaf
