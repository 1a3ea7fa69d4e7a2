// What core/image.cpp asks of OpenImageIO, which is loaded when the first picture is read or written: with the 250
// libraries that it brings it takes 0.2 s and 130 MB to start, which renders without pictures need not wait for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace sheaf {

/// What a picture's file says of it.
struct PictureHeader {
  int width = 0, height = 0, depth = 0;  ///< pixels
  int channel_count = 0;
  std::vector<std::string> channels;  ///< names
  bool deep = false;                  ///< any number of samples in a pixel
  bool holds_bytes = false;           ///< 8 bits without sign for each value
  bool holds_integers = false;
  int tile_width = 0, tile_height = 0;  ///< pixels, of any size the file claims; 0: pixels lie in rows
};

/// An open picture.
class ImageReader {
 public:
  virtual ~ImageReader() = default;
  virtual const PictureHeader& header() const = 0;
  /// Reads all values, interleaved, row by row from the top: as bytes, or as floats, integers in [0, 1]. Returns what
  /// the library has to say, and whether it has read everything.
  virtual bool read(std::uint8_t* out, std::string& remark) = 0;
  virtual bool read(float* out, std::string& remark) = 0;
};

/// Pixels for a PNG file.
struct PngPixels {
  int width, height, channels;
  bool has_alpha;             ///< the last channel is alpha; colours are not multiplied by it
  const std::uint8_t* bytes;  ///< interleaved, row by row from the top, sRGB
  std::string description;    ///< text chunk; empty: none
};

/// The library, behind functions that need nothing of its headers.
class PictureLibrary {
 public:
  virtual ~PictureLibrary() = default;
  /// Opens a picture of `format` (the library's name for it). Nothing if it cannot, and `problem` says why. `bytes`, if
  /// there are any, are read in place of the file; the reader keeps them.
  virtual std::unique_ptr<ImageReader> open(const std::string& path, const std::string& format, std::string& problem,
                                            std::vector<std::uint8_t> bytes = {}) const = 0;
  /// A PNG file's bytes, packed at `level` (0 to 9); none if that fails, and `problem` says why.
  virtual std::vector<unsigned char> encode_png(const PngPixels& pixels, int level, std::string& problem) const = 0;
};

/// The library, from the file sheaf_pictures.so beside the program or, where that is installed, in ../lib/sheaf. Loaded
/// at the first call and kept. Throws Error (exit code 1) if there is none.
const PictureLibrary& picture_library();

/// The library's name for the format of a picture: by how the file begins, and TGA, which begins in no way of its own,
/// by its name. Its other formats, among them those of films and of medicine, are closed to files from outside. Throws
/// SceneError for all that are not read, and Error (exit code 1 or SceneError) for files that would have the library
/// take more memory for opening them than there is, or far more than they need.
std::string checked_picture_format(const std::filesystem::path& file);

/// What sheaf_pictures.so has: the library.
using PictureLibraryFunction = const PictureLibrary*();
inline constexpr char kPictureLibraryFunction[] = "sheaf_picture_library";

}  // namespace sheaf
