// Files that appear whole or not at all: written under a temporary name beside the target, then renamed.
#pragma once

#include <filesystem>
#include <string_view>

namespace sheaf {

/// Checks that a file could be written at `path`, by creating and removing a temporary file beside it; `path` itself is
/// not touched. Throws Error (exit code 4) if not: no such directory, no permission, or something other than a file is
/// there.
void check_writable(const std::filesystem::path& path);

/// A file in the making. Write to temporary(), then commit(); without commit() nothing remains.
class OutputFile {
 public:
  /// Throws as check_writable() does.
  explicit OutputFile(const std::filesystem::path& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  /// Where to write. The file does not exist yet; its folder is the target's.
  const std::filesystem::path& temporary() const { return temporary_; }
  /// Gives the file its final name, replacing what is there. Throws Error (exit code 4) if that fails.
  void commit();

 private:
  std::filesystem::path target_, temporary_;
};

/// Writes a text file whole. Throws Error (exit code 4).
void write_text_file(const std::filesystem::path& path, std::string_view text);

}  // namespace sheaf
