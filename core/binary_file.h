// Binary files of our own: a first line that says what the file is, numbers as little-endian machines have them in
// memory, and a check sum at the end. Not to be exchanged: what is in them is known to the version that wrote them.
#pragma once

#include "core/output_file.h"

#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace sheaf {

/// A file in the making, which appears whole or not at all.
class BinaryOutput {
 public:
  /// Throws Error (exit code 4) if nothing can be written there.
  BinaryOutput(const std::filesystem::path& file, std::string_view first_line);

  template <class T> void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    put_bytes(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  /// Its length, and the text.
  void put(std::string_view text);
  /// The values alone.
  template <class T> void put(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    put_bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  /// Writes the check sum and gives the file its name. Throws Error (exit code 4).
  void commit();

 private:
  void put_bytes(const char* bytes, std::size_t size);

  OutputFile file_;
  std::uint32_t check_ = 0;
};

/// A file as BinaryOutput writes it. All that is wrong with it is an Error (exit code 5) that names the file.
class BinaryInput {
 public:
  /// Throws if the file cannot be read, begins with another line, or has another check sum than it should.
  BinaryInput(const std::filesystem::path& file, std::string_view first_line);

  template <class T> T get() {
    T value;
    get_bytes(reinterpret_cast<char*>(&value), sizeof(T));
    return value;
  }
  std::string get_text();
  /// As many values as the vector has.
  template <class T> void get(std::vector<T>& values) {
    get_bytes(reinterpret_cast<char*>(values.data()), values.size() * sizeof(T));
  }
  /// The vector of `count` values. Throws before it takes memory for more than the file holds.
  template <class T> std::vector<T> get_vector(std::uint64_t count) {
    if (count > left_ / sizeof(T)) fail("ends too early: cut off");
    std::vector<T> values(static_cast<std::size_t>(count));
    get(values);
    return values;
  }
  /// Bytes that were not read yet, without the check sum.
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
