// The index that refers to no row.
#pragma once

#include <cstdint>

namespace sheaf {

/// Index that refers to nothing, in any table.
inline constexpr std::uint32_t kNone = 0xffffffffu;

}  // namespace sheaf
