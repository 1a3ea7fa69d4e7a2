// Large pages by madvise(), and the parser of /proc/self/smaps.
#include "core/soa/large_pages.h"

#include "core/io/parallel_ranges.h"

#include <charconv>
#include <fstream>
#include <string>

#if defined(__linux__)
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace sheaf {

namespace {

constexpr std::size_t kPageBytes = std::size_t{2} << 20;

/// One entry of the memory map.
struct Mapping {
  MemoryRange range{};
  bool is_private_memory = false;
  std::size_t resident = 0, large = 0;  ///< resident bytes, and those of them on large pages
};

/// Parses the first line of an entry, such as "7f00-7fff rw-p 00000000 00:00 0 [heap]". Returns false for other lines.
bool read_first_line(const std::string& line, Mapping& mapping) {
  const char* const end = line.data() + line.size();
  std::size_t first = 0, last = 0;
  const auto dash = std::from_chars(line.data(), end, first, 16);
  if (dash.ec != std::errc() || dash.ptr == end || *dash.ptr != '-') return false;
  const auto space = std::from_chars(dash.ptr + 1, end, last, 16);
  if (space.ec != std::errc() || space.ptr == end || *space.ptr != ' ') return false;
  const std::string rest(space.ptr + 1, end);
  const std::size_t name = rest.find_first_of("/[");
  const bool unnamed = name == std::string::npos || rest.compare(name, std::string::npos, "[heap]") == 0;
  mapping = {{first, last}, unnamed && rest.starts_with("rw-p"), 0, 0};
  return true;
}

/// Parses a line such as "Rss: 94208 kB", if it begins with `name`.
void read_size(const std::string& line, const char* name, std::size_t& bytes) {
  if (!line.starts_with(name)) return;
  const std::size_t digit = line.find_first_of("0123456789");
  std::size_t kilobytes = 0;
  if (digit == std::string::npos) return;
  std::from_chars(line.data() + digit, line.data() + line.size(), kilobytes);
  bytes = kilobytes << 10;
}

void add_pages(const Mapping& mapping, std::vector<MemoryRange>& out) {
  const std::size_t begin = (mapping.range.begin + kPageBytes - 1) / kPageBytes * kPageBytes;
  const std::size_t end = mapping.range.end / kPageBytes * kPageBytes;
  const std::size_t size = mapping.range.end - mapping.range.begin;
  if (!mapping.is_private_memory || end < begin + 2 * kPageBytes || mapping.resident < size - size / 8) return;
  if (mapping.large < mapping.resident - mapping.resident / 8) out.push_back({begin, end});
}

}  // namespace

std::vector<MemoryRange> ranges_for_large_pages(std::istream& smaps) {
  std::vector<MemoryRange> out;
  Mapping mapping, next;
  for (std::string line; std::getline(smaps, line);) {
    if (read_first_line(line, next)) {
      add_pages(mapping, out);
      mapping = next;
    }
    read_size(line, "Rss:", mapping.resident);
    read_size(line, "AnonHugePages:", mapping.large);
  }
  add_pages(mapping, out);
  return out;
}

void prefer_large_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) noexcept {
#if defined(__linux__)
  const auto address = reinterpret_cast<std::size_t>(memory);
  const std::size_t begin = (address + kPageBytes - 1) / kPageBytes * kPageBytes;
  const std::size_t end = (address + bytes) / kPageBytes * kPageBytes;
  if (begin < end) madvise(static_cast<char*>(memory) + (begin - address), end - begin, MADV_HUGEPAGE);
#endif
}

void prepare_pages(void* memory, std::size_t bytes) noexcept {
  prefer_large_pages(memory, bytes);
#if defined(__linux__)
  constexpr int kPopulateWrite = 23;  // MADV_POPULATE_WRITE of Linux 5.14
  constexpr std::size_t kPages = 4;   // at a time
  const auto address = reinterpret_cast<std::size_t>(memory);
  const std::size_t first = (address + kPageBytes - 1) / kPageBytes, last = (address + bytes) / kPageBytes;
  if (last < first + 2 * kPages) return;
  parallel_ranges(
      last - first,
      [&](std::size_t begin, std::size_t end) {
        madvise(static_cast<char*>(memory) + ((first + begin) * kPageBytes - address), (end - begin) * kPageBytes,
                kPopulateWrite);
      },
      kPages);
#endif
}

void release_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) noexcept {
#if defined(__linux__)
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const auto address = reinterpret_cast<std::size_t>(memory);
  const std::size_t begin = (address + page - 1) / page * page, end = (address + bytes) / page * page;
  if (begin < end) madvise(static_cast<char*>(memory) + (begin - address), end - begin, MADV_DONTNEED);
#endif
}

void move_to_large_pages() noexcept {
#if defined(__linux__)
  // MADV_COLLAPSE of Linux 6.1 waits until the pages are moved. Before 6.1, the system moves them in the background.
  constexpr int kCollapse = 25;
  try {
    std::ifstream smaps("/proc/self/smaps");
    for (const MemoryRange& range : ranges_for_large_pages(smaps)) {
      // Only the addresses of this memory are known.
      void* const begin = reinterpret_cast<void*>(range.begin);  // NOLINT(performance-no-int-to-ptr)
      const std::size_t bytes = range.end - range.begin;
      madvise(begin, bytes, MADV_HUGEPAGE);
      madvise(begin, bytes, kCollapse);
    }
  } catch (...) {
    // If memory for the list runs out, all pages stay where they are.
  }
#endif
}

}  // namespace sheaf
