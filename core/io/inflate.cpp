// Decompression by zlib, which takes input and output in pieces whose sizes fit an unsigned int.
#include "core/io/inflate.h"

#include "core/io/error.h"

#include <zlib.h>

#include <algorithm>
#include <limits>

namespace sheaf {

struct Inflater::State {
  z_stream stream{};
  std::string_view input;  ///< input that zlib has not received yet
  bool at_end = false;
};

namespace {

constexpr std::size_t kLargestPiece = std::numeric_limits<uInt>::max();

}  // namespace

Inflater::Inflater(std::string_view deflated) : state_(std::make_unique<State>()) {
  state_->input = deflated;
  constexpr int kWindow = 15, kZlibOrGzip = 32;  // window bits, plus a flag that detects zlib or gzip by the header
  if (inflateInit2(&state_->stream, kWindow + kZlibOrGzip) != Z_OK)
    throw Error(ExitCode::kRuntime, "zlib cannot be started");
}

Inflater::~Inflater() { inflateEnd(&state_->stream); }

std::size_t Inflater::read(std::span<char> out) {
  z_stream& stream = state_->stream;
  std::size_t written = 0;
  while (written < out.size() && !state_->at_end) {
    // Pass the next piece of input to zlib
    if (stream.avail_in == 0 && !state_->input.empty()) {
      const std::size_t piece = std::min(state_->input.size(), kLargestPiece);
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(state_->input.data()));  // zlib only reads it
      stream.avail_in = static_cast<uInt>(piece);
      state_->input.remove_prefix(piece);
    }
    // Decompress into the rest of the output
    const std::size_t room = std::min(out.size() - written, kLargestPiece);
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + written);
    stream.avail_out = static_cast<uInt>(room);
    const int result = inflate(&stream, Z_NO_FLUSH);
    written += room - stream.avail_out;
    // Handle the end of the stream and errors
    if (result == Z_BUF_ERROR) break;  // truncated
    if (result == Z_STREAM_END) {
      state_->at_end = true;
    } else if (result != Z_OK) {
      throw Error(ExitCode::kScene,
                  std::string("corrupt compressed data: ") + (stream.msg != nullptr ? stream.msg : "no zlib stream"));
    }
  }
  return written;
}

std::uint64_t Inflater::max_remaining() const {
  constexpr std::uint64_t kLargestRatio = 1032;
  constexpr std::uint64_t kPending = 65536;  // input that zlib has read but not written yet: a match, a few bits
  if (state_->at_end) return 0;
  return (state_->input.size() + state_->stream.avail_in) * kLargestRatio + kPending;
}

std::uint32_t check_sum(std::string_view bytes, std::uint32_t before) {
  if (bytes.empty()) return before;  // their address may be null, which makes zlib start anew
  return static_cast<std::uint32_t>(crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace sheaf
