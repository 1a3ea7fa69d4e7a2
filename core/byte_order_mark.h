// The marks that some editors put in front of a text (Unicode 15, section 23.8).
#pragma once

#include "core/error.h"

#include <string>

namespace sheaf {

/// Removes the mark of UTF-8, if there is one. Throws SceneError, at line 1, for the marks of UTF-16 and UTF-32.
void remove_byte_order_mark(std::string& text, const std::string& file);

}  // namespace sheaf
