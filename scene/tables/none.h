// The word that stands for "no such row".
#pragma once

#include <cstdint>

namespace sheaf {

/// "No such row" in any table.
inline constexpr std::uint32_t kNone = 0xffffffffu;

}  // namespace sheaf
