// The bytes of an image file, on the disk or in memory.
#pragma once

#include "core/image/image.h"

#include <fstream>
#include <span>

namespace sheaf {

/// Random access to the bytes of an image file.
class ImageSource {
 public:
  explicit ImageSource(const std::filesystem::path& file)
      : path_(file), size_(std::filesystem::file_size(file)), stream_(file, std::ios::binary) {}
  /// `image` must outlive the object.
  explicit ImageSource(const EncodedImage& image) : path_(image.name), size_(image.bytes.size()), memory_(&image) {}

  /// The file, or the name of the image in memory, for messages.
  const std::filesystem::path& path() const { return path_; }
  /// The image in memory; null for files.
  const EncodedImage* memory() const { return memory_; }
  std::uint64_t size() const { return size_; }
  /// Reads the bytes from `at` on. Bytes beyond the end become 0.
  void read(std::uint64_t at, std::span<unsigned char> out);

 private:
  std::filesystem::path path_;
  std::uint64_t size_ = 0;
  const EncodedImage* memory_ = nullptr;
  std::ifstream stream_;
};

}  // namespace sheaf
