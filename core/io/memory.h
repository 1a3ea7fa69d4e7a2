// Available and used memory, and out-of-memory errors. Systems overcommit memory and kill the processes that use it, so
// large allocations are checked in advance.
#pragma once

#include "core/io/error.h"

#include <cstdint>
#include <span>
#include <string>

namespace sheaf {

/// One use of memory.
struct MemoryUse {
  std::string what;  ///< e.g. "the film"
  double bytes = 0;
  std::string advice;  ///< how to reduce it, in the imperative: "use a smaller image"; may be empty
};

/// Bytes that this process can still allocate: the minimum of the free memory of the system, the remainder of the
/// limits of its control groups, and available_addresses(). Infinite if all are unknown.
double available_memory();

/// Reduces the result of available_memory() on the calling thread to a fraction, while the object exists. Threads that
/// read files at the same time check their memory independently of each other.
class MemoryFraction {
 public:
  /// `fraction`: above 0, at most 1.
  explicit MemoryFraction(double fraction);
  ~MemoryFraction();
  MemoryFraction(const MemoryFraction&) = delete;
  MemoryFraction& operator=(const MemoryFraction&) = delete;

 private:
  double previous_;
};

/// Bytes that this process can still map under its limit on address space (`ulimit -v`); infinite without a limit.
double available_addresses();

/// Resident bytes of the process; 0 if unknown.
double resident_memory();

/// The peak resident set size of this process in bytes; 0 if unknown.
std::uint64_t peak_rss_bytes();

/// The peak resident set size minus the file pages that are resident now, mostly code of libraries. Heap, stacks, and
/// data that libraries have written to remain. In bytes; 0 if unknown.
std::uint64_t peak_private_bytes();

/// Formats bytes as "12.3 GB", or as "45 MB" below 0.1 GB.
std::string format_bytes(double bytes);

/// An error (exit code 1) with the memory that `task` needs in total and per use, the available memory, and the advice
/// of the largest use.
Error not_enough_memory(const std::string& task, std::span<const MemoryUse> uses);

/// The same error after a failed allocation of unknown size.
Error out_of_memory(const std::string& task, const std::string& advice);

/// Throws not_enough_memory() if the uses together are more than available_memory().
void check_memory(const std::string& task, std::span<const MemoryUse> uses);

}  // namespace sheaf
