// Colors of OpenEXR files as their halves.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace sheaf {

/// An image of numbers of 16 bits (IEEE 754 binary16).
struct HalfImage {
  int width = 0, height = 0;          ///< pixels
  std::vector<std::string> channels;  ///< names
  std::vector<std::uint16_t> values;  ///< interleaved, row by row from the top
};

/// Reads the given channels of a part. Returns nothing if one of them is no half or if the data window is not the
/// display window. Throws like read_exr_channels().
std::optional<HalfImage> read_exr_half_channels(const std::filesystem::path& path, std::size_t part,
                                                std::vector<std::string> channels);

/// Reads the same colors as read_exr_colors(). Returns nothing if they are not stored as halves of the display window,
/// or not as they are to be read: in another color space, unless `raw`. Throws like read_exr_colors().
std::optional<HalfImage> read_exr_halves(const std::filesystem::path& path, bool raw);

}  // namespace sheaf
