// Large pages for memory whose owner cannot ask for them itself: other libraries' and that of ordinary containers.
#pragma once

#include <cstddef>
#include <istream>
#include <vector>

namespace sheaf {

/// Addresses from `begin` to below `end`.
struct MemoryRange {
  std::size_t begin, end;
};

/// Of a list of a process's memory as Linux writes it in /proc/self/smaps: the whole large pages, of 2 MB, of memory
/// that belongs to no file, may be written, and is in use nearly everywhere. What is less than two of them long is left
/// out, and what lies on large pages already.
std::vector<MemoryRange> ranges_for_large_pages(std::istream& smaps);

/// Asks for large pages for memory that is about to be written for the first time.
void prefer_large_pages(void* memory, std::size_t bytes) noexcept;

/// Gives memory back to the system that its owner keeps: what lies on whole pages of it is lost, and reads as zero.
void release_pages(void* memory, std::size_t bytes) noexcept;

/// Moves what the process has in memory now to large pages, as far as the system has them. Scenes are read in no order
/// while they are rendered: Embree's hierarchy, vertices, texels. On small pages nearly every such read waits for its
/// page to be looked up too. Nothing changes but time.
void move_to_large_pages() noexcept;

}  // namespace sheaf
