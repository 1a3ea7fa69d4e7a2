// Substring test for messages.
#pragma once

#include <string_view>

namespace sheaf::test {

inline bool contains(std::string_view text, std::string_view part) { return text.find(part) != text.npos; }

}  // namespace sheaf::test
