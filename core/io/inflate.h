// Decompression of zlib and gzip streams in memory (RFC 1950, 1952), and CRC-32 checksums. Its source file is the only
// one that includes zlib.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

namespace sheaf {

/// A zlib or gzip stream in memory that is decompressed piece by piece.
class Inflater {
 public:
  /// `deflated` begins with the stream, may contain more data behind it, and must outlive the object.
  explicit Inflater(std::string_view deflated);
  ~Inflater();
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  /// Fills `out` with the next bytes. Returns their number, which is smaller than the size of `out` if the stream ends
  /// or is truncated. Throws Error (exit code 3) if the stream is corrupt.
  std::size_t read(std::span<char> out);

  /// An upper bound on the bytes that read() can still return. Deflate compresses at most 1032 to 1.
  std::uint64_t max_remaining() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The CRC-32 of `bytes` (RFC 1952, section 8), for detecting accidental damage. `before`: CRC-32 of the preceding
/// bytes.
std::uint32_t check_sum(std::string_view bytes, std::uint32_t before = 0);

}  // namespace sheaf
