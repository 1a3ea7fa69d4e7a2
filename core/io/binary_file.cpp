// Writing and reading of Sheaf's own binary files, with verification of their checksum.
#include "core/io/binary_file.h"

#include "core/io/error.h"
#include "core/io/inflate.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <system_error>

namespace sheaf {

static_assert(std::endian::native == std::endian::little);

namespace {

/// Maximum length of a text in bytes: far longer than any name or setting, far too short to exhaust memory.
constexpr std::uint32_t kMaxText = 1 << 20;

}  // namespace

BinaryOutput::BinaryOutput(const std::filesystem::path& file, std::string_view first_line) : file_(file) {
  put_bytes(first_line.data(), first_line.size());
}

void BinaryOutput::put(std::string_view text) {
  put(static_cast<std::uint32_t>(text.size()));
  put_bytes(text.data(), text.size());
}

void BinaryOutput::put_bytes(const char* bytes, std::size_t size) {
  check_ = check_sum({bytes, size}, check_);
  file_.stream().write(bytes, static_cast<std::streamsize>(size));
}

void BinaryOutput::commit() {
  const std::uint32_t check = check_;
  put(check);
  file_.commit();
}

BinaryInput::BinaryInput(const std::filesystem::path& file, std::string_view first_line) : path_(file) {
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(file, error);
  stream_.open(file, std::ios::binary);
  if (error || !stream_) fail("cannot be read");
  std::string line(first_line.size(), '\0');
  stream_.read(line.data(), static_cast<std::streamsize>(line.size()));
  if (!stream_ || line != first_line) {
    const std::string_view kind = first_line.substr(0, first_line.rfind(' '));
    fail(line.starts_with(kind) ? "was written by another version of Sheaf" : fmt::format("is not a {}", kind));
  }
  if (size < line.size() + sizeof(std::uint32_t)) fail("is truncated");
  left_ = size - line.size() - sizeof(std::uint32_t);
  check(size - sizeof(std::uint32_t));
  stream_.seekg(static_cast<std::streamoff>(line.size()));
}

/// Verifies the checksum, for which it reads the whole file once. `size_of_rest`: bytes before the checksum.
void BinaryInput::check(std::uint64_t size_of_rest) {
  stream_.seekg(0);
  std::vector<char> piece(static_cast<std::size_t>(std::min<std::uint64_t>(size_of_rest, std::uint64_t{1} << 20)));
  std::uint32_t sum = 0, expected = 0;
  for (std::uint64_t rest = size_of_rest; rest > 0;) {
    const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(rest, piece.size()));
    stream_.read(piece.data(), static_cast<std::streamsize>(size));
    if (!stream_) fail("cannot be read");
    sum = check_sum({piece.data(), size}, sum);
    rest -= size;
  }
  stream_.read(reinterpret_cast<char*>(&expected), sizeof expected);
  if (!stream_ || sum != expected) fail("is damaged (wrong checksum)");
}

std::string BinaryInput::get_text() {
  const auto size = get<std::uint32_t>();
  if (size > kMaxText) fail(fmt::format("is damaged (a text of {} characters)", size));
  std::string text(std::min<std::uint64_t>(size, left_), '\0');
  if (text.size() < size) fail("is truncated");
  get_bytes(text.data(), text.size());
  return text;
}

void BinaryInput::get_bytes(char* bytes, std::size_t size) {
  if (size > left_) fail("is truncated");
  stream_.read(bytes, static_cast<std::streamsize>(size));
  if (!stream_) fail("cannot be read");
  left_ -= size;
}

void BinaryInput::fail(const std::string& what) const { throw Error(ExitCode::kCheckpoint, {path_.string(), 0}, what); }

}  // namespace sheaf
