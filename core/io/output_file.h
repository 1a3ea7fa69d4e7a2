// Atomic output files: written under a temporary name next to the target, then renamed.
#pragma once

#include <filesystem>
#include <fstream>
#include <string_view>

namespace sheaf {

/// Checks that a file can be written at `path` by creating and removing a temporary file next to it; `path` itself is
/// not touched. Also removes the temporary files that killed processes left for `path`. These belong to this user, are
/// older than 10 s, their process no longer runs on this machine, and no process on any machine has them locked. Throws
/// Error (exit code 4) if the folder is missing, permission is missing, the file is write-protected, or `path` is not a
/// regular file.
void check_writable(const std::filesystem::path& path);

/// Whether two paths lead to the same file, through any links, whether or not the file exists.
bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// A file that is written atomically. If `path` is a symbolic link, the link stays and its target is written, on any
/// file system, whether or not it exists. Write to stream(), then call commit(); without commit() nothing remains.
class OutputFile {
 public:
  /// Throws like check_writable().
  explicit OutputFile(const std::filesystem::path& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// The temporary file in the folder of the target. Its errors may be left to commit().
  std::ostream& stream() { return stream_; }
  /// Closes the file and renames it to the target. It replaces an existing file and takes over its permissions. Throws
  /// Error (exit code 4), and keeps the existing file, unless all data has reached the disk.
  void commit();

 private:
  std::filesystem::path target_, temporary_;
  std::ofstream stream_;
  int lock_ = -1;  ///< descriptor whose lock marks temporary_ as being written; -1 without a lock
};

/// Writes a text file atomically. Throws Error (exit code 4).
void write_text_file(const std::filesystem::path& path, std::string_view text);

}  // namespace sheaf
