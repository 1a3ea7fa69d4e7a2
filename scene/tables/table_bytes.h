// The memory of tables.
#pragma once

#include <cstddef>

namespace sheaf {

/// Memory of vectors, in bytes, excluding data that their elements point to.
template <class... Table> std::size_t bytes_of(const Table&... tables) {
  return (std::size_t{0} + ... + (tables.capacity() * sizeof(typename Table::value_type)));
}

}  // namespace sheaf
