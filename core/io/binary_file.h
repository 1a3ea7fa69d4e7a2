// Sheaf's own binary files: a first line that identifies the file, numbers in the memory layout of little-endian
// machines, and a CRC-32 at the end. Not an exchange format: only the version that wrote a file knows its contents.
#pragma once

#include "core/io/output_file.h"

#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace sheaf {

/// Writes a file atomically: it appears complete or not at all.
class BinaryOutput {
 public:
  /// Throws Error (exit code 4) if the file cannot be written.
  BinaryOutput(const std::filesystem::path& file, std::string_view first_line);

  template <class T> void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    put_bytes(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  /// Writes the length as 32 bits, then the text.
  void put(std::string_view text);
  /// Writes the values without their number.
  template <class T> void put(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    put_bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  /// Writes the checksum and gives the file its final name. Throws Error (exit code 4).
  void commit();

 private:
  void put_bytes(const char* bytes, std::size_t size);

  OutputFile file_;
  std::uint32_t check_ = 0;
};

/// Reads a file of BinaryOutput. All failures throw Error (exit code 5) that names the file.
class BinaryInput {
 public:
  /// Throws if the file cannot be read, begins with another line, or fails its checksum. The last word of the line is
  /// the number of the layout.
  BinaryInput(const std::filesystem::path& file, std::string_view first_line);

  template <class T> T get() {
    T value;
    get_bytes(reinterpret_cast<char*>(&value), sizeof(T));
    return value;
  }
  std::string get_text();
  /// Fills the vector, whose size is the number of values to read.
  template <class T> void get(std::vector<T>& values) {
    get_bytes(reinterpret_cast<char*>(values.data()), values.size() * sizeof(T));
  }
  /// Reads `count` values. Throws before it allocates memory for more values than the file holds.
  template <class T> std::vector<T> get_vector(std::uint64_t count) {
    if (count > left_ / sizeof(T)) fail("is truncated");
    std::vector<T> values(static_cast<std::size_t>(count));
    get(values);
    return values;
  }
  /// Bytes left to read, without the checksum.
  std::uint64_t left() const { return left_; }
  [[noreturn]] void fail(const std::string& what) const;

 private:
  void get_bytes(char* bytes, std::size_t size);
  void check(std::uint64_t size_of_rest);

  std::filesystem::path path_;
  std::ifstream stream_;
  std::uint64_t left_ = 0;
};

}  // namespace sheaf
