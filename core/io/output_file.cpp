// Temporary names, the check for writability, and the final rename.
#include "core/io/output_file.h"

#include "core/io/error.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <ctime>
#include <string>
#include <system_error>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

/// Minimum age of temporary files to remove: the writer of a younger file may not have locked it yet.
constexpr std::time_t kLeftOverSeconds = 10;

Error cannot_write(const fs::path& path, const std::string& why) {
  return Error(ExitCode::kOutput, fmt::format("cannot write '{}': {}", path.string(), why));
}

/// Resolves symbolic links, so that the rename replaces the file and not the link. The file need not exist. Throws
/// Error (exit code 4) for circular links.
fs::path final_target(const fs::path& path) {
  constexpr int kMaxLinks = 40;
  fs::path target = path;
  for (int links = 0; links < kMaxLinks; ++links) {
    std::error_code error;
    const fs::path next = fs::read_symlink(target, error);  // fails if it is not a link
    if (error) return target;
    target = target.parent_path() / next;
  }
  throw cannot_write(path, std::strerror(ELOOP));
}

/// Opens and locks a file. Returns its descriptor, or -1 if it is locked already or locking fails. The lock ends with
/// the process, however it ends. It also holds for other machines if the file system supports that.
int lock_file(const fs::path& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (file < 0 || flock(file, LOCK_EX | LOCK_NB) == 0) return file;
  close(file);
  return -1;
}

/// The process id in a name that temporary_name() made for `target`; 0 for other names.
long writer_of(const std::string& name, const fs::path& target) {
  const std::string before = fmt::format(".{}.", target.filename().string()), after = ".tmp";
  if (!name.starts_with(before) || !name.ends_with(after) || name.size() < before.size() + after.size()) return 0;
  long process = 0;
  unsigned number = 0;
  const char* const begin = name.data() + before.size();
  const char* const end = name.data() + name.size() - after.size();
  const auto [dot, failure] = std::from_chars(begin, end, process);
  if (failure != std::errc() || dot == end || *dot != '.') return 0;
  const auto [last, other_failure] = std::from_chars(dot + 1, end, number);
  return other_failure == std::errc() && last == end && process > 0 ? process : 0;
}

/// Whether a temporary file was left by a process that no longer exists; see check_writable().
bool is_left_over(const fs::path& path, long process) {
  struct stat found {};
  if (lstat(path.c_str(), &found) != 0 || !S_ISREG(found.st_mode) || found.st_uid != geteuid()) return false;
  if (std::time(nullptr) - found.st_mtime < kLeftOverSeconds) return false;
  return kill(static_cast<pid_t>(process), 0) != 0 && errno == ESRCH;
}

void remove_left_over(const fs::path& target) {
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const long process = writer_of(entry->path().filename().string(), target);
    if (process == 0 || !is_left_over(entry->path(), process)) continue;
    const int lock = lock_file(entry->path());
    if (lock < 0) continue;
    std::error_code ignored;
    fs::remove(entry->path(), ignored);
    close(lock);
  }
}

fs::path temporary_name(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  return target.parent_path() / fmt::format(".{}.{}.{}.tmp", target.filename().string(), getpid(), counter++);
}

/// Waits until the file is on the disk, because some file systems report a full disk only then. Returns an errno, or 0.
int sync_file(const fs::path& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return errno;
  const int reason = fsync(file) == 0 ? 0 : errno;
  close(file);
  // the file system has nothing to synchronize
  return reason == EINVAL || reason == ENOSYS || reason == EROFS ? 0 : reason;
}

/// Determines why writing fails, which streams do not report, by writing once more. Returns an errno, or 0.
int ask_for_reason(const fs::path& path) {
  const int file = open(path.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (file < 0) return errno;
  const std::array<char, 65536> zeros{};  // more than the unused rest of the last page
  const ssize_t written = write(file, zeros.data(), zeros.size());
  int reason = written < 0 ? errno : 0;
  if (written >= 0 && static_cast<std::size_t>(written) < zeros.size())
    reason = write(file, zeros.data(), zeros.size()) < 0 ? errno : 0;
  close(file);
  return reason;
}

}  // namespace

bool is_same_file(const fs::path& a, const fs::path& b) {
  std::error_code error;
  if (fs::exists(a, error) && fs::exists(b, error)) return fs::equivalent(a, b, error);
  const auto location = [](const fs::path& path) {
    std::error_code failure;
    const fs::path full = fs::absolute(path, failure);
    const fs::path resolved = fs::weakly_canonical(full, failure);
    return failure ? full.lexically_normal() : resolved;
  };
  return location(a) == location(b);
}

OutputFile::OutputFile(const fs::path& path) : target_(final_target(path)) {
  if (!target_.has_filename()) throw cannot_write(path, "the name of the file is missing");
  std::error_code error;
  const fs::file_status status = fs::status(target_, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw cannot_write(path, fs::is_directory(status) ? "it is a folder" : "it is not a regular file");
  }
  // A rename needs permission to write to the folder only, so it would replace a write-protected file.
  if (fs::exists(status) && faccessat(AT_FDCWD, target_.c_str(), W_OK, AT_EACCESS) != 0)
    throw cannot_write(path, std::strerror(errno));
  const fs::path folder = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error))
    throw cannot_write(path, fmt::format("there is no folder '{}'", folder.string()));
  temporary_ = temporary_name(target_);
  errno = 0;
  stream_.open(temporary_, std::ios::binary);
  if (!stream_) throw cannot_write(path, std::strerror(errno));
  lock_ = lock_file(temporary_);
}

OutputFile::~OutputFile() {
  stream_.close();
  std::error_code error;
  fs::remove(temporary_, error);
  if (lock_ >= 0) close(lock_);
}

void OutputFile::commit() {
  const bool was_good = stream_.good();
  errno = 0;
  stream_.close();  // flushes the buffer
  if (!stream_) {
    const int reason = was_good && errno != 0 ? errno : ask_for_reason(temporary_);
    throw cannot_write(target_, reason != 0 ? std::strerror(reason) : "the data could not be written completely");
  }
  if (const int failure = sync_file(temporary_); failure != 0) throw cannot_write(target_, std::strerror(failure));
  std::error_code error;
  if (const fs::file_status old = fs::status(target_, error); fs::is_regular_file(old))
    fs::permissions(temporary_, old.permissions(), error);  // keep the permissions of the existing file
  fs::rename(temporary_, target_, error);
  if (error) throw cannot_write(target_, error.message());
}

void check_writable(const fs::path& path) {
  const OutputFile probe(path);
  remove_left_over(final_target(path));
}

void write_text_file(const fs::path& path, std::string_view text) {
  OutputFile file(path);
  file.stream().write(text.data(), static_cast<std::streamsize>(text.size()));
  file.commit();
}

}  // namespace sheaf
