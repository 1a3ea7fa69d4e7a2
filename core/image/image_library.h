// Interface to OpenImageIO and OpenColorIO, which are loaded when the first image is read or written. With their 250
// dependent libraries they take 0.2 s and 130 MB to load; renders without images avoid that.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace sheaf {

class ImageSource;

/// The header of an image file.
struct ImageHeader {
  int width = 0, height = 0, depth = 0;  ///< pixels
  int channel_count = 0;
  std::vector<std::string> channels;  ///< names
  bool deep = false;                  ///< pixels hold any number of samples
  bool holds_bytes = false;           ///< values are unsigned 8-bit integers
  bool holds_integers = false;
  int tile_width = 0, tile_height = 0;  ///< pixels, as claimed by the file, unchecked; 0: scan lines
};

/// An open image file.
class ImageReader {
 public:
  virtual ~ImageReader() = default;
  virtual const ImageHeader& header() const = 0;
  /// Reads all values, interleaved, row by row from the top, as bytes or as floats. Integers become floats in [0, 1].
  /// Returns whether everything was read, and sets `remark` to the messages of the library.
  virtual bool read(std::uint8_t* out, std::string& remark) = 0;
  virtual bool read(float* out, std::string& remark) = 0;
};

/// Pixels for a file of integers.
struct IntegerPixels {
  int width, height, channels;
  bool has_alpha;      ///< the last channel is alpha; colors are not premultiplied
  int bits;            ///< per value: 8 or 16
  const void* values;  ///< std::uint8_t or std::uint16_t, interleaved, row by row from the top, sRGB
};

/// File formats of integers.
enum class IntegerFormat { kPng, kJpeg, kTiff };

struct IntegerEncoding {
  IntegerFormat format = IntegerFormat::kPng;
  int level = 6;            ///< PNG: compression, 0 to 9
  int quality = 95;         ///< JPEG: 1 to 100
  std::string description;  ///< text in the header; empty: none
};

/// A view of an OpenColorIO configuration.
class ColorProcessor {
 public:
  virtual ~ColorProcessor() = default;
  /// Converts `count` colors of three values, in place, from linear Rec.709 to values of the display.
  virtual void apply(float* rgb, std::size_t count) const = 0;
};

/// Names a view. An empty string means the default of the configuration.
struct DisplayView {
  std::string config;  ///< file, built-in name such as ocio://default or raw, or empty: the file that $OCIO names
  std::string display, view;
};

/// The libraries behind an interface that does not depend on their headers.
class ImageLibrary {
 public:
  virtual ~ImageLibrary() = default;
  /// Opens an image file of `format`, as the library names it. On failure returns null and sets `problem`. If `bytes`
  /// is not empty, it is read instead of the file and kept by the reader.
  virtual std::unique_ptr<ImageReader> open(const std::string& path, const std::string& format, std::string& problem,
                                            std::vector<std::uint8_t> bytes = {}) const = 0;
  /// Encodes a file. On failure returns an empty vector and sets `problem`.
  virtual std::vector<unsigned char> encode(const IntegerPixels& pixels, const IntegerEncoding& encoding,
                                            std::string& problem) const = 0;
  /// Reads the configuration of a view. On failure, or if this build lacks OpenColorIO, returns null and sets
  /// `problem`.
  virtual std::unique_ptr<ColorProcessor> display_view(const DisplayView& view, std::string& problem) const = 0;
};

/// Returns the library, which the first call loads and keeps: from sheaf_image_io.so next to the program or, if that is
/// installed, in ../lib/sheaf. Throws Error (exit code 1) if the file is missing or cannot be loaded.
const ImageLibrary& image_library();

/// Returns the library's name for the format of an image file. Formats are recognized by their magic number; TGA, which
/// has none, by its file extension. Other formats of the library, for example video and medical images, are rejected
/// for security. In memory, only PNG, JPEG and WebP are supported. Throws SceneError for unsupported formats. Throws
/// Error (exit code 1) or SceneError for files that would make the library allocate more memory than is available, or
/// far more than they need.
std::string checked_image_format(ImageSource& source);
std::string checked_image_format(const std::filesystem::path& file);

/// The size for check_image_size() of a file of `format`: WebP files of a few bytes may hold large images of one
/// color.
std::size_t counted_image_bytes(const ImageSource& source, const std::string& format);

/// The function that sheaf_image_io.so exports. It returns the library.
using ImageLibraryFunction = const ImageLibrary*();
inline constexpr char kImageLibraryFunction[] = "sheaf_image_library";

}  // namespace sheaf
