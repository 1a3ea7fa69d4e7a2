// Restrictions of the process that imports models.
#include "tests/support/temporary_folder.h"
#include "tools/importer/sandbox.h"

#include <doctest/doctest.h>

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>

namespace sheaf::test_importer_sandbox {

namespace {

/// The status of waitpid() of a process that runs `call` and exits with its result.
template <class Call> int status_of(Call&& call) {
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) _exit(call());
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

/// Whether this program has no sanitizers, for a processor with a filter of system calls.
constexpr bool has_filter() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !(defined(__x86_64__) || defined(__aarch64__))
  return false;
#else
  return true;
#endif
}

}  // namespace

TEST_CASE("importer sandbox: files and network are denied, memory and open files are not") {
  if (!has_filter()) return;
  const TemporaryFolder folder;
  const std::string file = (folder / "file").string();
  write_bytes(file, "x");
  const int open_file = open(file.c_str(), O_RDWR | O_CLOEXEC);
  REQUIRE(open_file >= 0);
  const int status = status_of([&] {
    importer::restrict_process(0, 10);
    if (open(file.c_str(), O_RDONLY) >= 0 || errno != EPERM) return 1;
    if (unlink(file.c_str()) == 0 || errno != EPERM) return 2;
    if (socket(AF_INET, SOCK_STREAM, 0) >= 0 || errno != EPERM) return 3;
    if (fork() >= 0) return 4;
    constexpr std::size_t kLarge = std::size_t{64} << 20;
    auto* const memory = static_cast<volatile char*>(std::malloc(kLarge));
    if (memory == nullptr) return 5;
    memory[kLarge - 1] = 'y';
    if (write(open_file, "y", 1) != 1) return 6;
    return 0;
  });
  close(open_file);
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  CHECK(read_bytes(file) == "y");
}

TEST_CASE("importer sandbox: memory and time are limited") {
  if (!has_filter()) return;
  const int large = status_of([] {
    importer::restrict_process(std::uint64_t{1} << 30, 10);
    void* volatile memory = std::malloc(std::size_t{2} << 30);  // volatile: must not be optimized away
    return memory == nullptr ? 0 : 1;
  });
  CHECK(WIFEXITED(large));
  CHECK(WEXITSTATUS(large) == 0);
  const int stopped = status_of([] {
    importer::restrict_process(0, 1);
    volatile bool endless = true;
    while (endless) {}
    return 0;
  });
  CHECK(WIFSIGNALED(stopped));
}

}  // namespace sheaf::test_importer_sandbox
