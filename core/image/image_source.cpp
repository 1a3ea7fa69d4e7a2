#include "core/image/image_source.h"

#include "core/io/error.h"

#include <algorithm>

namespace sheaf {

ImageSource::ImageSource(const std::filesystem::path& file) : path_(file), stream_(file, std::ios::binary) {
  std::error_code error;
  size_ = std::filesystem::file_size(file, error);
  if (error || !stream_) throw SceneError({file.string(), 0}, "the image file cannot be opened");
}

bool ImageSource::read(std::uint64_t at, std::span<unsigned char> out) {
  std::fill(out.begin(), out.end(), static_cast<unsigned char>(0));
  if (at >= size_) return true;
  const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(out.size(), size_ - at));
  if (memory_ != nullptr) {
    std::copy_n(memory_->bytes.begin() + static_cast<std::ptrdiff_t>(at), count, out.begin());
    return true;
  }
  stream_.clear();
  stream_.seekg(static_cast<std::streamoff>(at));
  stream_.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(count));
  return stream_.gcount() == static_cast<std::streamsize>(count);
}

bool ImageStream::read(std::span<unsigned char> out) {
  const std::uint64_t at = position();
  if (at > size() || out.size() > size() - at) return false;
  const std::size_t buffered = std::min(out.size(), available());
  std::copy_n(buffer_.begin() + static_cast<std::ptrdiff_t>(next_), buffered, out.begin());
  next_ += buffered;
  const std::span<unsigned char> rest = out.subspan(buffered);
  if (rest.size() >= buffer_.size()) {
    if (!source_.read(at + buffered, rest)) return false;
    seek(at + out.size());
  } else if (!rest.empty()) {
    if (!fill()) return false;
    std::copy_n(buffer_.begin(), rest.size(), rest.begin());
    next_ = rest.size();
  }
  return true;
}

bool ImageStream::fill() {
  if (end_ >= size()) return false;
  const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(buffer_.size(), size() - end_));
  if (!source_.read(end_, {buffer_.data(), count})) return false;
  next_ = 0;
  filled_ = count;
  end_ += count;
  return true;
}

}  // namespace sheaf
