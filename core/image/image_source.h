// The bytes of an image file, on the disk or in memory.
#pragma once

#include "core/image/image.h"

#include <array>
#include <fstream>
#include <span>
#include <utility>

namespace sheaf {

/// Random access to the bytes of an image file.
class ImageSource {
 public:
  /// Throws SceneError if the file cannot be opened.
  explicit ImageSource(const std::filesystem::path& file);
  /// `image` must outlive the object.
  explicit ImageSource(const EncodedImage& image) : path_(image.name), size_(image.bytes.size()), memory_(&image) {}

  /// The file, or the name of the image in memory, for messages.
  const std::filesystem::path& path() const { return path_; }
  /// The image in memory; null for files.
  const EncodedImage* memory() const { return memory_; }
  std::uint64_t size() const { return size_; }
  /// Reads the bytes from `at` on. Bytes beyond the end become 0. Returns false if the file can no longer be read.
  bool read(std::uint64_t at, std::span<unsigned char> out);

 private:
  std::filesystem::path path_;
  std::uint64_t size_ = 0;
  const EncodedImage* memory_ = nullptr;
  std::ifstream stream_;
};

/// Reads the bytes of an image file in order.
class ImageStream {
 public:
  explicit ImageStream(ImageSource source) : source_(std::move(source)) {}

  std::uint64_t size() const { return source_.size(); }
  /// The position of the next byte.
  std::uint64_t position() const { return end_ - available(); }
  void seek(std::uint64_t position) {
    next_ = filled_ = 0;
    end_ = position;
  }
  /// Returns false if there are fewer bytes, or if the file can no longer be read.
  bool read(std::span<unsigned char> out);
  /// The next byte, or -1 at the end.
  int get() { return next_ < filled_ || fill() ? buffer_[next_++] : -1; }
  /// The same without advancing.
  int peek() { return next_ < filled_ || fill() ? buffer_[next_] : -1; }

 private:
  std::size_t available() const { return filled_ - next_; }
  bool fill();

  ImageSource source_;
  std::array<unsigned char, 1 << 14> buffer_;
  std::size_t next_ = 0, filled_ = 0;  ///< in the buffer
  std::uint64_t end_ = 0;              ///< position after the buffer
};

/// A number in little-endian order.
inline std::uint32_t little_endian_number(std::span<const unsigned char> bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | bytes[i];
  return value;
}

/// The message for files whose pixels are incomplete.
inline constexpr const char* kImageEndsEarly = "the file is damaged or ends too early";

}  // namespace sheaf
