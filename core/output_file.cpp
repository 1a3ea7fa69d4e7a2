// Temporary names, the check for writability, and the rename at the end.
#include "core/output_file.h"

#include "core/error.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

namespace sheaf {

namespace fs = std::filesystem;

namespace {

Error cannot_write(const fs::path& path, const std::string& why) {
  return Error(ExitCode::kOutput, "cannot write '" + path.string() + "': " + why);
}

/// The path with symbolic links to files resolved, so that the rename replaces the file and not the link.
fs::path final_target(const fs::path& path) {
  std::error_code error;
  const fs::path resolved = fs::is_symlink(path, error) ? fs::weakly_canonical(path, error) : path;
  return error ? path : resolved;
}

fs::path temporary_name(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  const std::string suffix = "." + std::to_string(getpid()) + "." + std::to_string(counter++) + ".tmp";
  return target.parent_path() / ("." + target.filename().string() + suffix);
}

/// Waits until the file is on the disk: some file systems say only then that there was no room. Returns an errno, or 0.
int sync_file(const fs::path& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return errno;
  const int reason = fsync(file) == 0 ? 0 : errno;
  close(file);
  return reason == EINVAL || reason == ENOSYS || reason == EROFS ? 0 : reason;  // nothing to be synchronised there
}

}  // namespace

bool is_same_file(const fs::path& a, const fs::path& b) {
  std::error_code error;
  if (fs::exists(a, error) && fs::exists(b, error)) return fs::equivalent(a, b, error);
  const auto place = [](const fs::path& path) {
    std::error_code failure;
    const fs::path full = fs::absolute(path, failure);
    const fs::path resolved = fs::weakly_canonical(full, failure);
    return failure ? full.lexically_normal() : resolved;
  };
  return place(a) == place(b);
}

OutputFile::OutputFile(const fs::path& path) : target_(final_target(path)) {
  if (!target_.has_filename()) throw cannot_write(path, "the name of the file is missing");
  std::error_code error;
  const fs::file_status status = fs::status(target_, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw cannot_write(path, fs::is_directory(status) ? "it is a folder" : "it is not a regular file");
  }
  const fs::path folder = target_.has_parent_path() ? target_.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error)) throw cannot_write(path, "there is no folder '" + folder.string() + "'");
  temporary_ = temporary_name(target_);
  errno = 0;
  stream_.open(temporary_, std::ios::binary);
  if (!stream_) throw cannot_write(path, std::strerror(errno));
}

OutputFile::~OutputFile() {
  stream_.close();
  std::error_code error;
  fs::remove(temporary_, error);
}

void OutputFile::commit() {
  const bool was_good = stream_.good();
  errno = 0;
  stream_.close();  // what is still in its buffer is written now
  const int reason = errno;
  const bool is_known = was_good && reason != 0;
  if (!stream_) throw cannot_write(target_, is_known ? std::strerror(reason) : "not all of it could be written");
  if (const int failure = sync_file(temporary_); failure != 0) throw cannot_write(target_, std::strerror(failure));
  std::error_code error;
  fs::rename(temporary_, target_, error);
  if (error) throw cannot_write(target_, error.message());
}

void check_writable(const fs::path& path) { const OutputFile probe(path); }

void write_text_file(const fs::path& path, std::string_view text) {
  OutputFile file(path);
  file.stream().write(text.data(), static_cast<std::streamsize>(text.size()));
  file.commit();
}

}  // namespace sheaf
