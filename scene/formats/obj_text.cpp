#include "scene/formats/obj_text.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace sheaf {

namespace {

bool is_line_end(char c) { return c == '\n' || c == '\r'; }

/// Length of the line end at `position`: 2 for CR LF.
std::size_t line_end_width(std::string_view text, std::size_t position) {
  return text.substr(position, 2) == "\r\n" ? 2 : 1;
}

/// Number of line ends. `before`: the character before the text.
int count_line_ends(std::string_view text, char before) {
  constexpr std::size_t kBlock = 128;  // 8-bit counts, so compilers use SIMD instructions
  int count = 0;
  for (std::size_t begin = 0; begin < text.size(); begin += kBlock) {
    const std::size_t end = std::min(begin + kBlock, text.size());
    std::uint8_t in_block = text[begin] == '\r' || (text[begin] == '\n' && before != '\r') ? 1 : 0;
    for (std::size_t i = begin + 1; i < end; ++i)
      in_block =
          static_cast<std::uint8_t>(in_block + ((text[i] == '\r') | ((text[i] == '\n') & (text[i - 1] != '\r'))));
    count += in_block;
    before = text[end - 1];
  }
  return count;
}

}  // namespace

ObjSource::ObjSource(const std::filesystem::path& file) : name_(file.string()), text_(file, "OBJ file") {
  if (text_.begin() == text_.end())
    throw SceneError(SourceLocation{name_}, "expected an OBJ file, found an empty file");
}

std::vector<ObjSource::Range> ObjSource::pieces(std::size_t bytes) const {
  std::vector<Range> pieces;
  for (std::size_t begin = text_.begin(); begin < text_.end();) {
    const bool is_last = bytes >= text_.end() - begin;
    pieces.push_back({begin, is_last ? text_.end() : end_of_line(begin + bytes - 1)});
    begin = pieces.back().end;
  }
  return pieces;
}

/// Position after the first line end at or after `position` that continues no line, or the end of the file.
std::size_t ObjSource::end_of_line(std::size_t position) const {
  constexpr std::size_t kWindow = 4096, kBefore = 2;  // a line end is judged by two characters before and one after
  std::string window;
  for (std::size_t first = position;; first += kWindow - 1) {
    const std::size_t begin = std::max(first, text_.begin() + kBefore) - kBefore;
    const std::size_t end = std::min(first + kWindow, text_.end());
    window.resize(end - begin);
    text_.read(begin, window);
    for (std::size_t i = first - begin; begin + i + 1 < end; ++i) {
      if (!is_line_end(window[i]) || line_end_width(window, i) == 2) continue;
      const std::size_t width = i > 0 && line_end_width(window, i - 1) == 2 ? 2 : 1;
      if (i < width || window[i - width] != '\\') return begin + i + 1;
    }
    if (end == text_.end()) return end;
  }
}

void ObjSource::read(Range piece, std::string& text) const {
  text.resize(piece.size());
  text_.read(piece.begin, text);
  if (piece.end == text_.end() && !text.ends_with('\n')) text.push_back('\n');
}

SourceLocation ObjSource::where(std::size_t position) const {
  constexpr std::size_t kBlock = std::size_t{1} << 20;
  std::string block;
  int line = 1;
  char before = '\0';
  for (std::size_t begin = text_.begin(); begin < position; begin += kBlock) {
    block.resize(std::min(kBlock, position - begin));
    text_.read(begin, block);
    line += count_line_ends(block, before);
    before = block.back();
  }
  return {name_, line};
}

ObjText::ObjText(const ObjSource& source, ObjSource::Range piece, std::string buffer)
    : source_(source), begin_(piece.begin), text_(std::move(buffer)) {
  source.read(piece, text_);
  join_continued_lines();
}

void ObjText::join_continued_lines() {
  std::size_t line = 0, searched = 0;  // the line begins at `line`; line ends were searched up to `searched`
  for (std::size_t at = text_.find('\\'); at != text_.npos; at = text_.find('\\', at + 1)) {
    if (!is_line_end(text_[at + 1])) continue;
    // Find the beginning of the line
    for (std::size_t i = at; i > searched; --i)
      if (is_line_end(text_[i - 1])) {
        line = i;
        break;
      }
    searched = at;
    const std::size_t first = text_.find_first_not_of(" \t", line), width = line_end_width(text_, at + 1);
    if ((text_[first] != 'v' && text_[first] != 'f') || at + 1 + width == text_.size()) continue;
    std::fill_n(text_.begin() + static_cast<std::ptrdiff_t>(at), 1 + width, ' ');
    joined_.push_back(at + 1);
  }
}

SourceLocation ObjText::where(const char* line) const {
  return source_.where(begin_ + static_cast<std::size_t>(line - text_.data()));
}

int ObjLineCounter::line_at(const char* line) {
  const std::string_view text = text_.text_;
  const auto end = static_cast<std::size_t>(line - text.data());
  line_ += count_line_ends(text.substr(position_, end - position_), position_ > 0 ? text[position_ - 1] : '\0');
  position_ = end;
  for (; joined_ < text_.joined_.size() && text_.joined_[joined_] < end; ++joined_) ++line_;
  return line_;
}

namespace {

enum Class : std::uint8_t {
  kDigit = 1,
  kZero = 2,  ///< besides kDigit
  kBlank = 4,
  kLineEnd = 8,
  kDot = 16,
  kMinus = 32,
  kSlash = 64,
  kLetter = 128  ///< of a keyword of plain lines
};

constexpr std::size_t kHistory = 64, kChunk = 2048;
using Bytes = std::array<std::uint8_t, kHistory + kChunk>;

/// A chunk of text behind the kHistory bytes before it, with properties of each byte.
struct Chunk {
  Bytes text;
  Bytes classes;  ///< 0 for bytes that plain lines do not have
  Bytes next;     ///< classes that may follow
  /// Bit 0: the last 1, 2, 4, 8 bytes are digits. Bit 1: the byte is one of the first 1, 2, 4, 8 digits behind a dot.
  std::array<Bytes, 4> runs;
};

/// Comparisons of single bytes without branches, which compilers turn into SIMD instructions.
void classify(Chunk& chunk) {
  const auto flag = [](bool condition, int value) { return static_cast<std::uint8_t>(condition ? value : 0); };
  for (std::size_t i = 0; i < chunk.text.size(); ++i) {
    const std::uint8_t c = chunk.text[i];
    const bool is_digit = static_cast<std::uint8_t>(c - '0') < 10, is_blank = (c == ' ') | (c == '\t'),
               ends_line = (c == '\n') | (c == '\r'), is_letter = (c == 'v') | (c == 'f') | (c == 'n') | (c == 't');
    chunk.classes[i] = flag(is_digit, kDigit) | flag(c == '0', kZero) | flag(is_blank, kBlank) |
                       flag(ends_line, kLineEnd) | flag(c == '.', kDot) | flag(c == '-', kMinus) |
                       flag(c == '/', kSlash) | flag(is_letter, kLetter);
    chunk.next[i] = flag(is_digit, kDigit | kBlank | kLineEnd | kDot | kSlash) |
                    flag(is_blank, kDigit | kBlank | kLineEnd | kDot | kMinus) | flag(ends_line, kLineEnd | kLetter) |
                    flag(c == '.', kDigit | kBlank | kLineEnd) | flag(c == '-', kDigit | kDot) |
                    flag(c == '/', kDigit | kMinus | kSlash) | flag(is_letter, kLetter | kBlank);
  }
}

/// Finds runs of digits, by runs of half the length.
void find_runs(Chunk& chunk) {
  for (std::size_t i = 1; i < chunk.text.size(); ++i) {
    const std::uint8_t run = (chunk.classes[i - 1] & kDot) != 0 ? 3 : 1;
    chunk.runs[0][i] = (chunk.classes[i] & kDigit) != 0 ? run : std::uint8_t{0};
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t length = std::size_t{1} << k;
    const Bytes& half = chunk.runs[k];
    for (std::size_t i = 2 * length; i < chunk.text.size(); ++i) {
      const std::uint8_t run = half[i], last = half[i - length];
      chunk.runs[k + 1][i] = static_cast<std::uint8_t>((run & (last | 2)) | ((run + run) & last & 2));
    }
  }
}

/// 255 if byte `i` shows that the line is not plain, else 0. Every rule looks at the bytes before. Truth values are
/// bytes, of which SIMD instructions process more than of wider types.
std::uint8_t is_odd(const Chunk& chunk, std::size_t i) {
  using Byte = std::uint8_t;
  const Byte now = chunk.classes[i], last = chunk.classes[i - 1], before = chunk.classes[i - 2];
  const auto is = [](Byte c, Byte classes) -> Byte { return static_cast<Byte>(c & classes) != 0 ? 255 : 0; };
  const auto is_not = [](Byte c, Byte classes) -> Byte { return static_cast<Byte>(c & classes) == 0 ? 255 : 0; };
  const Byte has_odd_pair = is_not(chunk.next[i - 1], now);
  const Byte has_lone_dot = is(last, kDot) & is_not(before | now, kDigit);
  const Byte has_two_dots = is(now, kDot) & is(chunk.runs[3][i - 1], 2);
  const Byte is_long = is(chunk.runs[3][i], 1) & is((chunk.classes[i - 8] & kDot) | chunk.runs[1][i - 8], kDot | 1);
  const Byte is_zero_index = is(now, kZero) & (is(last, kSlash) | (is(last, kMinus) & is(before, kSlash)));
  const Byte is_empty = is(now, kLineEnd) & is(last, kBlank) & is_not(before, kDigit | kDot);
  return has_odd_pair | has_lone_dot | has_two_dots | is_long | is_zero_index | is_empty;
}

/// All bits that are set in any of these 64 bytes.
std::uint8_t any_of_block(const std::uint8_t* bytes) {
  std::uint64_t all = 0;
  for (std::size_t i = 0; i < 64; i += sizeof(all)) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes + i, sizeof(word));
    all |= word;
  }
  for (const int half : {32, 16, 8}) all |= all >> half;
  return static_cast<std::uint8_t>(all);
}

}  // namespace

PlainObjLines::PlainObjLines(std::string_view text) : found_((text.size() + kBlock - 1) / kBlock) {
  Chunk chunk{};
  std::fill_n(chunk.text.begin(), kHistory, std::uint8_t{'\n'});
  Bytes found{};
  for (std::size_t at = 0; at < text.size(); at += kChunk) {
    const std::size_t size = std::min(kChunk, text.size() - at);
    if (at > 0) std::copy_n(&text[at - kHistory], kHistory, chunk.text.begin());
    std::copy_n(&text[at], size, chunk.text.begin() + kHistory);
    std::fill(chunk.text.begin() + static_cast<std::ptrdiff_t>(kHistory + size), chunk.text.end(), std::uint8_t{'\n'});
    classify(chunk);
    find_runs(chunk);
    for (std::size_t i = kHistory; i < found.size(); ++i)
      found[i] = static_cast<std::uint8_t>((chunk.classes[i] & (kDot | kSlash)) | (is_odd(chunk, i) & kOdd));
    for (std::size_t block = 0; block * kBlock < size; ++block)
      found_[at / kBlock + block] = any_of_block(&found[kHistory + block * kBlock]);
  }
}

}  // namespace sheaf
