// Sequential number sources for PLY bodies, ASCII and binary. Internal to the readers of PLY files.
#pragma once

#include "scene/formats/ply_header.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <utility>

namespace sheaf {

/// Position in the body, with its location for messages.
class Cursor {
 public:
  Cursor(const std::string& bytes, const PlyHeader& header, const std::string& file)
      : at_(bytes.data() + header.size), end_(bytes.data() + bytes.size()), file_(file) {}

  void enter(const PlyElement& element) { element_ = &element; }
  void enter_row(std::uint64_t row) { row_ = row; }

 protected:
  [[noreturn]] void fail(const std::string& message, int line) const {
    throw SceneError(SourceLocation{file_, line}, fmt::format("row {} of element '{}' ({} rows): {}", row_,
                                                              element_->name, element_->count, message));
  }
  std::uint64_t bytes_left() const { return static_cast<std::uint64_t>(end_ - at_); }

  const char* at_;
  const char* end_;

 private:
  const std::string& file_;
  const PlyElement* element_ = nullptr;
  std::uint64_t row_ = 0;
};

/// Numbers of a binary body.
class BinarySource : public Cursor {
 public:
  BinarySource(const std::string& bytes, const PlyHeader& header, const std::string& file)
      : Cursor(bytes, header, file),
        swaps_((header.encoding == PlyHeader::Encoding::kBigEndian) != (std::endian::native == std::endian::big)) {}

  [[noreturn]] void fail(const std::string& message) const { Cursor::fail(message, 0); }

  double number(PlyType type) {
    switch (type) {
      case PlyType::kInt8:
        return take<std::int8_t>();
      case PlyType::kUint8:
        return take<std::uint8_t>();
      case PlyType::kInt16:
        return take<std::int16_t>();
      case PlyType::kUint16:
        return take<std::uint16_t>();
      case PlyType::kInt32:
        return take<std::int32_t>();
      case PlyType::kUint32:
        return take<std::uint32_t>();
      case PlyType::kFloat32:
        return static_cast<double>(take<float>());
      default:
        return take<double>();
    }
  }

  /// Throws if the file cannot hold `count` more numbers.
  void require(PlyType type, std::uint64_t count) const {
    if (count > bytes_left() / ply_type_size(type)) fail("the file is truncated");
  }

  void skip(PlyType type, std::uint64_t count) {
    require(type, count);
    at_ += count * ply_type_size(type);
  }

  /// Whether the bytes of numbers are in the order of this machine.
  bool is_native() const { return !swaps_; }
  /// Returns the next `size` bytes and moves past them.
  const char* take_bytes(std::uint64_t size) {
    if (size > bytes_left()) fail("the file is truncated");
    return std::exchange(at_, at_ + size);
  }

  /// Reads 32-bit indices in the byte order of this machine into `out`, if all are below `limit`. Otherwise returns
  /// false and stays at the first of them.
  bool take_indices(std::span<std::uint32_t> out, std::uint64_t limit) {
    if (out.size_bytes() > bytes_left()) fail("the file is truncated");
    std::memcpy(out.data(), at_, out.size_bytes());
    if (std::any_of(out.begin(), out.end(), [&](std::uint32_t index) { return index >= limit; })) return false;
    at_ += out.size_bytes();
    return true;
  }

 private:
  template <class T> T take() {
    if (bytes_left() < sizeof(T)) fail("the file is truncated");
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), at_, sizeof(T));
    if (swaps_) std::reverse(raw.begin(), raw.end());
    at_ += sizeof(T);
    return std::bit_cast<T>(raw);
  }

  bool swaps_;
};

/// Numbers of an ASCII body, separated by blanks and line ends.
class AsciiSource : public Cursor {
 public:
  AsciiSource(const std::string& bytes, const PlyHeader& header, const std::string& file)
      : Cursor(bytes, header, file), body_(at_), header_lines_(header.lines) {}

  [[noreturn]] void fail(const std::string& message) const {
    const std::string_view read(body_, static_cast<std::size_t>(at_ - body_));
    auto breaks = std::count(read.begin(), read.end(), '\n');
    if (breaks == 0) breaks = std::count(read.begin(), read.end(), '\r');
    Cursor::fail(message, header_lines_ + 1 + static_cast<int>(breaks));
  }

  double number(PlyType) {
    std::string_view token = next_token();
    const std::string_view found = token;
    if (token.starts_with('+')) token.remove_prefix(1);
    double value = 0;
    const char* const end = token.data() + token.size();
    const auto [stop, failure] = std::from_chars(token.data(), end, value);
    if (stop != end || token.empty() || failure == std::errc::invalid_argument) {
      fail(fmt::format("expected a number, found '{}'", found.substr(0, 40)));
    }
    if (failure == std::errc::result_out_of_range) {
      const bool is_tiny = token.find("e-") != token.npos || token.find("E-") != token.npos;
      const double infinity = std::numeric_limits<double>::infinity();
      return is_tiny ? 0.0 : token.starts_with('-') ? -infinity : infinity;
    }
    return value;
  }

  void require(PlyType, std::uint64_t count) const {
    if (count > bytes_left() / 2 + 1) fail("the file is truncated");
  }

  void skip(PlyType type, std::uint64_t count) {
    require(type, count);
    for (std::uint64_t i = 0; i < count; ++i) next_token();
  }

 private:
  std::string_view next_token() {
    const auto is_blank = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
    at_ = std::find_if_not(at_, end_, is_blank);
    if (at_ == end_) fail("the file is truncated");
    const char* const begin = at_;
    at_ = std::find_if(at_, end_, is_blank);
    return {begin, static_cast<std::size_t>(at_ - begin)};
  }

  const char* body_;
  int header_lines_;
};

/// Reads the length of a list; its numbers follow.
template <class Source> std::uint64_t list_length(Source& source, const PlyProperty& list) {
  const double length = source.number(*list.count_type);
  if (!(length >= 0 && length < 1e18 && length == std::floor(length))) {
    source.fail(fmt::format("list '{}' has an impossible length", list.name));
  }
  const auto count = static_cast<std::uint64_t>(length);
  source.require(list.type, count);
  return count;
}

template <class Source> void skip_property(Source& source, const PlyProperty& property) {
  source.skip(property.type, property.count_type ? list_length(source, property) : 1);
}

/// Calls read(source) with a source for the body's encoding.
template <class Read>
void with_ply_source(const std::string& bytes, const PlyHeader& header, const std::string& file, Read&& read) {
  if (header.encoding == PlyHeader::Encoding::kAscii) {
    AsciiSource source(bytes, header, file);
    read(source);
  } else {
    BinarySource source(bytes, header, file);
    read(source);
  }
}

}  // namespace sheaf
