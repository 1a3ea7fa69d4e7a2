// Limits of Linux: setrlimit(2) and a filter of system calls, seccomp(2).
#include "tools/importer/sandbox.h"

#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>

#include <cerrno>
#include <cstddef>
#include <iterator>
#include <vector>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SHEAF_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define SHEAF_SANITIZED
#endif
#endif

namespace sheaf::importer {

namespace {

void limit(decltype(RLIMIT_AS) resource, std::uint64_t value) {
  const rlimit both{value, value};
  setrlimit(resource, &both);
}

#if (defined(__x86_64__) || defined(__aarch64__)) && !defined(SHEAF_SANITIZED)

#if defined(__x86_64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#else
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#endif

/// Allocation, open files, synchronization, and the end of the process.
constexpr int kAllowed[] = {
    SYS_brk,   SYS_mmap,       SYS_munmap,       SYS_mremap,      SYS_madvise,       SYS_mprotect,     SYS_read,
    SYS_write, SYS_writev,     SYS_lseek,        SYS_fstat,       SYS_newfstatat,    SYS_close,        SYS_futex,
    SYS_exit,  SYS_exit_group, SYS_rt_sigreturn, SYS_sched_yield, SYS_clock_gettime, SYS_gettimeofday, SYS_getrandom,
};

void filter_system_calls() {
  std::vector<sock_filter> program = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, arch)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 1, 0),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
  };
  auto left = static_cast<std::uint8_t>(std::size(kAllowed));
  for (const int call : kAllowed)
    program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), left--, 0));
  program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM));
  program.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  const sock_fprog filter{static_cast<unsigned short>(program.size()), program.data()};
  // Kernels without filters, such as those of some containers, fail here; the limits above remain.
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0) prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter);
}

#else

void filter_system_calls() {}

#endif

}  // namespace

void restrict_process([[maybe_unused]] std::uint64_t memory, std::uint64_t seconds) {
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, seconds);
#ifndef SHEAF_SANITIZED
  if (memory > 0) limit(RLIMIT_AS, memory);
#endif
  filter_system_calls();
}

}  // namespace sheaf::importer
