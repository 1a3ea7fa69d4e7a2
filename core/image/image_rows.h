// Reading of image files row by row.
#pragma once

#include "core/image/image_reader.h"

#include <filesystem>
#include <memory>
#include <optional>

namespace sheaf {

/// An open image file of bytes with rows from the top, such as most PNG and JPEG files. Large images need no memory for
/// all pixels at once.
class ImageRows {
 public:
  /// Returns nothing for files that can only be read as a whole, or that hold no bytes. Throws like
  /// read_stored_image().
  static std::optional<ImageRows> open(const std::filesystem::path& path);

  const ImageHeader& header() const { return reader_->header(); }
  /// Reads the next rows, interleaved. Throws SceneError.
  void read(int count, std::uint8_t* out);

 private:
  ImageRows(std::unique_ptr<ImageReader> reader, std::filesystem::path path);

  std::unique_ptr<ImageReader> reader_;
  std::filesystem::path path_;  ///< for messages
};

}  // namespace sheaf
