// Decompression of zlib and gzip streams in memory (RFC 1950, 1952), and check sums. The only file that knows zlib.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

namespace sheaf {

/// A zlib or gzip stream in memory, inflated piece by piece.
class Inflater {
 public:
  /// `deflated` begins with the stream, may go on behind its end, and must outlive the object.
  explicit Inflater(std::string_view deflated);
  ~Inflater();
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  /// Fills `out` with the next bytes. Returns how many there were: fewer than asked for if the stream ends or is
  /// truncated. Throws Error if the stream is corrupt.
  std::size_t read(std::span<char> out);

  /// An upper bound on the bytes that read() can still return: deflate shrinks no input by more than 1032 to 1.
  std::uint64_t most_left() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The CRC-32 of some bytes (RFC 1952, section 8), which tells whether they were damaged by accident. `before`: that of
/// what comes before them.
std::uint32_t check_sum(std::string_view bytes, std::uint32_t before = 0);

}  // namespace sheaf
