// Byte order marks at the beginning of text files (Unicode 15, section 23.8).
#pragma once

#include "core/io/error.h"

#include <string>

namespace sheaf {

/// Removes a byte order mark of UTF-8, if present. Throws SceneError, at line 1, for byte order marks of UTF-16 and
/// UTF-32.
void remove_byte_order_mark(std::string& text, const std::string& file);

}  // namespace sheaf
