// Temporary names, the check for writability, and the rename at the end.
#include "core/output_file.h"

#include "core/error.h"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
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

}  // namespace

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
  const bool created = std::ofstream(temporary_, std::ios::binary).is_open();
  const int reason = errno;
  fs::remove(temporary_, error);
  if (!created) throw cannot_write(path, std::strerror(reason));
}

OutputFile::~OutputFile() {
  std::error_code error;
  fs::remove(temporary_, error);
}

void OutputFile::commit() {
  std::error_code error;
  fs::rename(temporary_, target_, error);
  if (error) throw cannot_write(target_, error.message());
}

void check_writable(const fs::path& path) { const OutputFile probe(path); }

void write_text_file(const fs::path& path, std::string_view text) {
  OutputFile file(path);
  std::ofstream stream(file.temporary(), std::ios::binary);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  stream.close();
  if (!stream) throw cannot_write(path, "not all of it could be written");
  file.commit();
}

}  // namespace sheaf
