// Selection of the memory that moves to large pages: large, private, in use, and not on large pages yet.
#include "core/soa/large_pages.h"

#include <doctest/doctest.h>

#include <sstream>
#include <string>

namespace sheaf::test_large_pages {

namespace {

/// An entry of /proc/self/smaps with the relevant lines and one irrelevant line.
std::string entry(const std::string& first_line, int resident, int large) {
  return first_line + "\nSize:                  8 kB\nRss:                 " + std::to_string(resident) +
         " kB\nAnonHugePages:         " + std::to_string(large) + " kB\nVmFlags: rd wr mr mw me ac sd\n";
}

std::vector<MemoryRange> ranges(const std::string& text) {
  std::istringstream stream(text);
  return ranges_for_large_pages(stream);
}

constexpr int kSixteenMegabytes = 16 << 10;

}  // namespace

TEST_CASE("large pages: whole pages of anonymous memory are found") {
  const auto found = ranges(entry("7f0000100000-7f0001100000 rw-p 00000000 00:00 0 ", kSixteenMegabytes, 0) +
                            entry("564e7a400000-564e7b400000 rw-p 00000000 00:00 0    [heap]", kSixteenMegabytes, 0));
  REQUIRE(found.size() == 2);
  CHECK(found[0].begin == 0x7f0000200000);
  CHECK(found[0].end == 0x7f0001000000);
  CHECK(found[1].begin == 0x564e7a400000);
  CHECK(found[1].end == 0x564e7b400000);
}

TEST_CASE("large pages: other memory is left alone") {
  const std::string page = "7f0000000000-7f0001000000 ";
  CHECK(ranges(entry(page + "rw-p 00000000 00:00 0 ", kSixteenMegabytes, 0)).size() == 1);
  CHECK(ranges(entry(page + "r-xp 00000000 00:00 0 ", kSixteenMegabytes, 0)).empty());
  CHECK(ranges(entry(page + "rw-s 00000000 00:00 0 ", kSixteenMegabytes, 0)).empty());
  CHECK(ranges(entry(page + "rw-p 00000000 fe:00 99    /usr/lib/libm.so", kSixteenMegabytes, 0)).empty());
  CHECK(ranges(entry(page + "rw-p 00000000 00:00 0    [stack]", kSixteenMegabytes, 0)).empty());
  // Mostly unused, like stacks of threads; already on large pages; too small.
  CHECK(ranges(entry(page + "rw-p 00000000 00:00 0 ", 4000, 0)).empty());
  CHECK(ranges(entry(page + "rw-p 00000000 00:00 0 ", kSixteenMegabytes, kSixteenMegabytes)).empty());
  CHECK(ranges(entry("7f0000100000-7f0000400000 rw-p 00000000 00:00 0 ", 3 << 10, 0)).empty());
  CHECK(ranges("").empty());
  CHECK(ranges("Rss: 12 kB\nnonsense\n7f00-\n").empty());
}

}  // namespace sheaf::test_large_pages
