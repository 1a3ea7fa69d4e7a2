// Blosc compression, which volume files use. The only file that depends on Blosc, which is optional.
#pragma once

#include <span>
#include <string_view>

namespace sheaf {

/// Whether this build supports Blosc compression.
bool has_blosc();

/// What to do about data that this build cannot decompress, for messages.
inline constexpr char kNoBlosc[] =
    "compressed with Blosc, which this build of Sheaf does not support (write the file with ZIP compression, or build "
    "Sheaf with libblosc-dev)";

/// Decompresses a buffer. Returns whether it is valid and fills `out` exactly; false without Blosc.
bool decompress_blosc(std::string_view stored, std::span<char> out);

}  // namespace sheaf
