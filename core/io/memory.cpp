// Memory limits of the system, of control groups and of the process (Linux), its peak use of memory, and the text of
// out-of-memory errors.
#include "core/io/memory.h"

#include <fmt/format.h>

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string_view>
#include <utility>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

thread_local double memory_fraction = 1;  ///< of the calling thread, see MemoryFraction

/// The first number in a file; infinite if there is no number, as for a control group whose limit is "max".
double number_in(const fs::path& file) {
  std::ifstream stream(file);
  double number = 0;
  return stream >> number ? number : kNoLimit;
}

/// The number behind `word` in a file whose lines begin with words; `missing` if there is no such line.
double number_after(const fs::path& file, const std::string& word, double missing) {
  std::ifstream stream(file);
  std::string found;
  double number = 0;
  while (stream >> found) {
    if (found == word && stream >> number) return number;
    stream.clear();
    stream.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return missing;
}

double free_in_system() {
  const fs::path file = "/proc/meminfo";
  const double kilobytes = number_after(file, "MemAvailable:", kNoLimit) + number_after(file, "SwapFree:", 0);
  return kilobytes * 1024;
}

/// The memory that a control group and its ancestors leave. Cached file pages count as free.
double free_in_group(const fs::path& root, const std::string& group, const char* limit, const char* usage) {
  double available = kNoLimit;
  std::error_code error;
  for (fs::path folder = root / fs::path(group).relative_path();; folder = folder.parent_path()) {
    const double max_bytes = number_in(folder / limit);
    if (max_bytes < 1e18) {  // version 1 of control groups stores a huge number for "no limit"
      const double files = number_after(folder / "memory.stat", "inactive_file", 0) +
                           number_after(folder / "memory.stat", "active_file", 0);
      const double used = number_in(folder / usage);
      if (used < kNoLimit) available = std::min(available, max_bytes - std::max(used - files, 0.0));
    }
    if (folder == root || !folder.has_relative_path()) break;
  }
  return available;
}

/// The memory that all control groups leave. Lines are "4:memory:/user" in version 1 and "0::/user" in version 2.
double free_in_groups() {
  std::ifstream stream("/proc/self/cgroup");
  double available = kNoLimit;
  for (std::string line; std::getline(stream, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == line.npos || second == line.npos) continue;
    const std::string kind = line.substr(first + 1, second - first - 1), group = line.substr(second + 1);
    if (kind.empty()) {
      available = std::min(available, free_in_group("/sys/fs/cgroup", group, "memory.max", "memory.current"));
    } else if (fmt::format(",{},", kind).find(",memory,") != std::string::npos) {
      available = std::min(
          available, free_in_group("/sys/fs/cgroup/memory", group, "memory.limit_in_bytes", "memory.usage_in_bytes"));
    }
  }
  return available;
}

/// Entry `index` of /proc/self/statm, converted from pages to bytes; 0 if missing.
double pages_in_statm(int index) {
  std::ifstream stream("/proc/self/statm");
  double pages = 0;
  for (int i = 0; i <= index; ++i)
    if (!(stream >> pages)) return 0;
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE));
}

/// The value of `key`, such as "VmHWM", in /proc/self/status, in bytes; 0 if missing.
std::uint64_t process_status_bytes(std::string_view key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.size() > key.size() && line.starts_with(key) && line[key.size()] == ':')
      return 1024 * std::strtoull(line.c_str() + key.size() + 1, nullptr, 10);
  return 0;
}

}  // namespace

double available_addresses() {
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kNoLimit;
  return static_cast<double>(limit.rlim_cur) - pages_in_statm(0);
}

double available_memory() {
  return memory_fraction * std::max(0.0, std::min({free_in_system(), free_in_groups(), available_addresses()}));
}

MemoryFraction::MemoryFraction(double fraction) : previous_(std::exchange(memory_fraction, fraction)) {}

MemoryFraction::~MemoryFraction() { memory_fraction = previous_; }

double resident_memory() { return pages_in_statm(1); }

std::uint64_t peak_rss_bytes() {
  // getrusage() also counts the program that this process ran before.
  if (const std::uint64_t bytes = process_status_bytes("VmHWM"); bytes != 0) return bytes;
#if defined(__APPLE__)
  constexpr std::uint64_t kUnit = 1;
#else
  constexpr std::uint64_t kUnit = 1024;
#endif
#if defined(__unix__) || defined(__APPLE__)
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) == 0) return static_cast<std::uint64_t>(usage.ru_maxrss) * kUnit;
#endif
  return 0;
}

std::uint64_t peak_private_bytes() {
  const std::uint64_t peak = process_status_bytes("VmHWM");
  const std::uint64_t files = process_status_bytes("RssFile") + process_status_bytes("RssShmem");
  return peak > files ? peak - files : 0;
}

std::string format_bytes(double bytes) {
  if (bytes < 1e8) return fmt::format("{:.3g} MB", bytes * 1e-6);
  return fmt::format("{:.{}f} GB", bytes * 1e-9, bytes < 1e10 ? 2 : 1);
}

Error not_enough_memory(const std::string& task, std::span<const MemoryUse> uses) {
  double sum = 0;
  std::string list;
  int listed = 0;
  const MemoryUse* largest = nullptr;
  for (const MemoryUse& use : uses) {
    sum += use.bytes;
    if (use.bytes >= 1e6)
      list += fmt::format("{}{} for {}", listed++ == 0 ? "" : ", ", format_bytes(use.bytes), use.what);
    if (largest == nullptr || use.bytes > largest->bytes) largest = &use;
  }
  std::string message = fmt::format("not enough memory for {}: it takes {}{}, and {} are free", task, format_bytes(sum),
                                    listed > 1 ? fmt::format(" ({})", list) : "", format_bytes(available_memory()));
  if (largest != nullptr && !largest->advice.empty()) message += fmt::format(" ({})", largest->advice);
  return {ExitCode::kRuntime, message};
}

Error out_of_memory(const std::string& task, const std::string& advice) {
  return {ExitCode::kRuntime,
          fmt::format("not enough memory for {}: the program has {} already, and {} are free ({})", task,
                      format_bytes(resident_memory()), format_bytes(available_memory()), advice)};
}

void check_memory(const std::string& task, std::span<const MemoryUse> uses) {
  double sum = 0;
  for (const MemoryUse& use : uses) sum += use.bytes;
  if (sum > available_memory()) throw not_enough_memory(task, uses);
}

}  // namespace sheaf
