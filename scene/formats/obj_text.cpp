#include "scene/formats/obj_text.h"

#include "scene/formats/mesh_io.h"

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

}  // namespace

ObjText::ObjText(const std::filesystem::path& file) : file_(file.string()), text_(read_mesh_text(file, "OBJ file")) {
  if (text_.empty()) throw SceneError(SourceLocation{file_}, "expected an OBJ file, found an empty file");
  if (!text_.ends_with('\n')) text_.push_back('\n');
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

std::vector<std::string_view> ObjText::pieces(std::size_t bytes) const {
  std::vector<std::string_view> pieces;
  for (std::size_t begin = 0; begin < text_.size();) {
    std::size_t end = std::min(begin + bytes, text_.size()) - 1;
    while (!is_line_end(text_[end])) ++end;
    end += line_end_width(text_, end);
    pieces.push_back(std::string_view(text_).substr(begin, end - begin));
    begin = end;
  }
  return pieces;
}

SourceLocation ObjText::where(const char* line) const { return {file_, ObjLineCounter(*this).line_at(line)}; }

int ObjLineCounter::line_at(const char* line) {
  const std::string& text = text_.text_;
  const auto end = static_cast<std::size_t>(line - text.data());
  for (; position_ < end; ++position_)
    if (text[position_] == '\n' || (text[position_] == '\r' && text[position_ + 1] != '\n')) ++line_;
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

/// Whether byte `i` shows that the line is not plain. Every rule looks at the bytes before.
bool is_odd(const Chunk& chunk, std::size_t i) {
  const std::uint8_t now = chunk.classes[i], last = chunk.classes[i - 1], before = chunk.classes[i - 2];
  const auto is = [](int c, int classes) { return static_cast<std::uint8_t>(c & classes) != 0; };
  const bool has_odd_pair = !is(chunk.next[i - 1], now);
  const bool has_lone_dot = is(last, kDot) & !is(before | now, kDigit);
  const bool has_two_dots = is(now, kDot) & is(chunk.runs[3][i - 1], 2);
  const bool is_long = is(chunk.runs[3][i], 1) & is((chunk.classes[i - 8] & kDot) | chunk.runs[1][i - 8], kDot | 1);
  const bool is_zero_index = is(now, kZero) & (is(last, kSlash) | (is(last, kMinus) & is(before, kSlash)));
  const bool is_empty = is(now, kLineEnd) & is(last, kBlank) & !is(before, kDigit | kDot);
  return has_odd_pair | has_lone_dot | has_two_dots | is_long | is_zero_index | is_empty;
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
      found[i] = static_cast<std::uint8_t>((chunk.classes[i] & (kDot | kSlash)) | (is_odd(chunk, i) ? kOdd : 0));
    for (std::size_t block = 0; block * kBlock < size; ++block) {
      std::uint8_t all = 0;
      for (std::size_t i = 0; i < kBlock; ++i) all |= found[kHistory + block * kBlock + i];
      found_[at / kBlock + block] = all;
    }
  }
}

}  // namespace sheaf
