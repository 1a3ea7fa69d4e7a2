#include "core/image/image_source.h"

#include <algorithm>

namespace sheaf {

void ImageSource::read(std::uint64_t at, std::span<unsigned char> out) {
  std::fill(out.begin(), out.end(), static_cast<unsigned char>(0));
  if (at >= size_) return;
  const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(out.size(), size_ - at));
  if (memory_ != nullptr) {
    std::copy_n(memory_->bytes.begin() + static_cast<std::ptrdiff_t>(at), count, out.begin());
    return;
  }
  stream_.clear();
  stream_.seekg(static_cast<std::streamoff>(at));
  stream_.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(count));
}

}  // namespace sheaf
