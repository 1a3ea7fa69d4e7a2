#include "core/image/image_reader.h"

#include <fmt/format.h>

#include <cstring>
#include <limits>
#include <utility>

namespace sheaf {

namespace {

/// Converts integers at the end of an array to floats that fill it. In order, so that no integer is overwritten before
/// it is read.
template <class Integer> void widen(float* values, std::size_t count) {
  constexpr float kScale = 1.0f / static_cast<float>(std::numeric_limits<Integer>::max());
  const unsigned char* const end = reinterpret_cast<const unsigned char*>(values + count);
  const unsigned char* const begin = end - count * sizeof(Integer);
  for (std::size_t i = 0; i < count; ++i) {
    Integer value = 0;
    std::memcpy(&value, begin + i * sizeof(Integer), sizeof(Integer));
    values[i] = static_cast<float>(value) * kScale;
  }
}

}  // namespace

bool ImageReader::read(std::uint8_t* /*out*/, std::string& problem) {
  problem = "the file does not hold bytes";
  return false;
}

bool ImageReader::read_rows(int /*count*/, std::uint8_t* /*out*/, std::string& problem) {
  problem = "the file has no rows of bytes";
  return false;
}

void ImageReader::set_header(int width, int height, std::vector<std::string> channels) {
  header_.width = width;
  header_.height = height;
  header_.channels = std::move(channels);
}

bool IntegerReader::read(float* out, std::string& problem) {
  const std::size_t count =
      static_cast<std::size_t>(header_.width) * static_cast<std::size_t>(header_.height) * header_.channels.size();
  const std::size_t bytes = count * (header_.holds_bytes ? 1 : 2);
  // Decode into the end of the array, which saves a second one
  if (!decode(reinterpret_cast<unsigned char*>(out + count) - bytes, problem)) return false;
  if (header_.holds_bytes)
    widen<std::uint8_t>(out, count);
  else
    widen<std::uint16_t>(out, count);
  return true;
}

void IntegerReader::set_header(int width, int height, std::vector<std::string> channels, int bits) {
  ImageReader::set_header(width, height, std::move(channels));
  header_.holds_bytes = bits == 8;
  header_.holds_integers = true;
}

std::vector<std::string> default_channel_names(int count) {
  if (count == 1) return {"Y"};
  std::vector<std::string> names{"R", "G", "B", "A"};
  for (int c = 4; c < count; ++c) names.push_back(fmt::format("channel{}", c));
  names.resize(static_cast<std::size_t>(count));
  return names;
}

}  // namespace sheaf
