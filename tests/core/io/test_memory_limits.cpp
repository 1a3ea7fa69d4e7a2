// Available memory, and the error messages for renders that exceed it.
#include "core/io/memory.h"

#include <doctest/doctest.h>

#include <sys/resource.h>

#include <string>
#include <vector>

namespace sheaf::test_memory_limits {

namespace {

std::string message_of(const std::string& task, const std::vector<MemoryUse>& uses) {
  try {
    check_memory(task, uses);
  } catch (const Error& error) { return error.exit_code() == ExitCode::kRuntime ? error.what() : "another exit code"; }
  return {};
}

}  // namespace

TEST_CASE("memory: sizes are printed in readable units") {
  CHECK(format_bytes(0) == "0 MB");
  CHECK(format_bytes(45.06e6) == "45.1 MB");
  CHECK(format_bytes(1e8) == "0.10 GB");
  CHECK(format_bytes(12.34e9) == "12.3 GB");
}

TEST_CASE("anonymous memory is counted apart from mapped files") {
  constexpr std::size_t kBytes = std::size_t{200} << 20;
  const std::uint64_t before = peak_private_bytes();
  if (before == 0) return;
  CHECK(before <= peak_rss_bytes());
  {
    const std::vector<char> block(kBytes, 1);
    CHECK(block[kBytes / 2] == 1);
  }
  CHECK(peak_private_bytes() >= kBytes);
  CHECK(peak_private_bytes() <= peak_rss_bytes());
}

// Address sanitizers reserve address space of their own.
#ifndef __SANITIZE_ADDRESS__
TEST_CASE("memory: an address space limit reduces the available memory") {
  const double before = available_memory();
  CHECK(before > 1e6);
  CHECK(before < 1e15);
  CHECK(resident_memory() > 1e6);
  CHECK(resident_memory() < 1e12);
  rlimit old{};
  getrlimit(RLIMIT_AS, &old);
  const rlimit low{rlim_t{1} << 20, old.rlim_max};  // less than the program uses
  setrlimit(RLIMIT_AS, &low);
  const double none = available_memory();
  setrlimit(RLIMIT_AS, &old);
  CHECK(none == 0);
}
#endif

TEST_CASE("memory: exceeding the available memory is an error that names the purpose and a remedy") {
  CHECK(message_of("nothing", {}).empty());
  CHECK(message_of("a bit", {{"the film", 1000, "Help"}}).empty());
  const std::string one = message_of("a map", {{"its tables", 5e15, "use a smaller map"}, {"dust", 0, ""}});
  CHECK(one.starts_with("not enough memory for a map: it takes 5000000.0 GB, and "));
  CHECK(one.ends_with(" are free (use a smaller map)"));
  const std::string two =
      message_of("an image", {{"the film", 2e15, "Crop"}, {"rays", 3e15, "Threads"}, {"dust", 1000, "Sweep"}});
  CHECK(two.find("it takes 5000000.0 GB (2000000.0 GB for the film, 3000000.0 GB for rays), and ") != two.npos);
  CHECK(two.ends_with(" (Threads)"));
  // Each fits alone, but not both together.
  const double half = 0.7 * available_memory();
  CHECK(message_of("one", {{"film", half, ""}}).empty());
  CHECK_FALSE(message_of("two", {{"film", half, ""}, {"map", half, ""}}).empty());
}

}  // namespace sheaf::test_memory_limits
