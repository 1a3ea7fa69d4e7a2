// How much memory there is, and what is said where it does not do. Systems hand out more than they have and kill the
// programs that use it, so what is large is checked before it is asked for.
#pragma once

#include "core/error.h"

#include <span>
#include <string>

namespace sheaf {

/// Something that takes memory.
struct MemoryUse {
  std::string what;  ///< e.g. "the film"
  double bytes = 0;
  std::string advice;  ///< how it takes less, a sentence; may be empty
};

/// Bytes that this process may take besides what it has: the least of what the system has free, of what the limits of
/// its control groups leave, and of what its own limit of address space does. Infinite where the system tells nothing.
double available_memory();

/// Bytes that this process may still map under its own limit of address space (`ulimit -v`); infinite if it has none.
double available_addresses();

/// Bytes that the process has in memory now; 0 where the system does not tell.
double resident_memory();

/// "12.3 GB", or "45 MB" below a tenth of that unit.
std::string format_bytes(double bytes);

/// An error (exit code 1): `task` takes all this, so much is free, and what helps where most is needed.
Error not_enough_memory(const std::string& task, std::span<const MemoryUse> uses);

/// The same where nobody has told how much it takes: after an allocation that failed.
Error out_of_memory(const std::string& task, const std::string& advice);

/// Throws not_enough_memory() if the uses together are more than available_memory().
void check_memory(const std::string& task, std::span<const MemoryUse> uses);

}  // namespace sheaf
