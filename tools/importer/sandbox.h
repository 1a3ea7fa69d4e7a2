// Restriction of a process that parses untrusted files.
#pragma once

#include <cstdint>

namespace sheaf::importer {

/// Limits this process: `memory` bytes of address space (0: unlimited) and `seconds` of processor time. From now on it
/// can allocate memory, and read and write open files; all other system calls fail. With sanitizers, only the time is
/// limited.
void restrict_process(std::uint64_t memory, std::uint64_t seconds);

}  // namespace sheaf::importer
