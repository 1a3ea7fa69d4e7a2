// Files that appear whole or not at all: written under a temporary name beside the target, then renamed.
#pragma once

#include <filesystem>
#include <fstream>
#include <string_view>

namespace sheaf {

/// Checks that a file could be written at `path`, by creating and removing a temporary file beside it; `path` itself is
/// not touched. Removes what programs that were killed while they wrote this file have left of it beside it: temporary
/// files of this user for `path` that are older than ten seconds, whose process does not run here, and that nobody on
/// any machine holds open for writing. Throws Error (exit code 4) if not: no such directory, no permission, a file that
/// must not be written to, or something other than a file is there.
void check_writable(const std::filesystem::path& path);

/// Whether two names mean the same file, by whatever way they lead there, and whether it is there yet or not.
bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// A file in the making. Where a symbolic link is in its place, it is what that leads to, on whatever file system, and
/// whether it is there yet or not; the link stays. Write to stream(), then commit(); without commit() nothing remains.
class OutputFile {
 public:
  /// Throws as check_writable() does.
  explicit OutputFile(const std::filesystem::path& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// The file under its temporary name, in the target's folder. Its errors may be left to commit().
  std::ostream& stream() { return stream_; }
  /// Closes the file and gives it its final name, replacing what is there, whose permissions it takes. Throws Error
  /// (exit code 4), and leaves what is there as it was, unless all that was written has arrived on the disk.
  void commit();

 private:
  std::filesystem::path target_, temporary_;
  std::ofstream stream_;
  int lock_ =
      -1;  ///< a descriptor whose lock tells others that temporary_ is being written; -1: there are no locks here
};

/// Writes a text file whole. Throws Error (exit code 4).
void write_text_file(const std::filesystem::path& path, std::string_view text);

}  // namespace sheaf
