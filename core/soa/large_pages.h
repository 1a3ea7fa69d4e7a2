// Large pages for memory that other libraries and standard containers allocate, which do not request them.
#pragma once

#include <cstddef>
#include <istream>
#include <vector>

namespace sheaf {

/// The addresses [begin, end).
struct MemoryRange {
  std::size_t begin, end;
};

/// Parses the memory map of a process in the format of /proc/self/smaps (Linux). Returns the whole large pages, of 2
/// MB, of private writable memory without a file that is at least 7/8 resident. Omits ranges of fewer than two large
/// pages, and ranges that are on large pages already.
std::vector<MemoryRange> ranges_for_large_pages(std::istream& smaps);

/// Requests large pages for memory that is about to be written for the first time.
void prefer_large_pages(void* memory, std::size_t bytes) noexcept;

/// Reserves memory for `count` elements in all, and requests large pages for those that are added.
template <class T> void reserve_on_large_pages(std::vector<T>& list, std::size_t count) {
  list.reserve(count);
  prefer_large_pages(list.data() + list.size(), (list.capacity() - list.size()) * sizeof(T));
}

/// prefer_large_pages(), and makes large memory resident by all threads: the system clears pages when they are first
/// used.
void prepare_pages(void* memory, std::size_t bytes) noexcept;

/// Returns whole pages of memory to the system while the owner keeps the addresses. Their contents are lost and read as
/// zero.
void release_pages(void* memory, std::size_t bytes) noexcept;

/// Moves the resident memory of the process to large pages, if the system has any. Renders read scenes in random order:
/// Embree's BVH, vertices, texels. On small pages nearly every such read also waits for address translation. Affects
/// nothing but speed.
void move_to_large_pages() noexcept;

}  // namespace sheaf
