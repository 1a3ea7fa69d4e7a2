// Iteration over lines of numbers.
#include "scene/formats/number_lines.h"
#include "scene/formats/text.h"

#include <charconv>
#include <cmath>

namespace sheaf {

namespace {

constexpr std::string_view kSeparators = " \t\v\f";

}  // namespace

bool NumberLines::next() {
  if (rest_.empty()) return false;
  const std::size_t end = std::min(rest_.find_first_of("\r\n"), rest_.size());
  line_ = trimmed(rest_.substr(0, end), kSeparators);
  const std::size_t ending = rest_.substr(end).starts_with("\r\n") ? 2 : 1;
  rest_.remove_prefix(std::min(end + ending, rest_.size()));
  ++number_;
  return true;
}

void NumberLines::read(std::span<float> numbers, const char* what) const {
  constexpr std::size_t kShown = 60;
  const auto malformed = [&] {
    const std::string displayed(line_.substr(0, kShown));
    fail(fmt::format("expected {} finite numbers ({}), found '{}{}", numbers.size(), what, displayed,
                     line_.size() > kShown ? "...'" : "'"));
  };
  std::string_view rest = line_;
  for (float& number : numbers) {
    std::string_view word = rest.substr(0, std::min(rest.find_first_of(kSeparators), rest.size()));
    rest = trimmed(rest.substr(word.size()), kSeparators);
    if (word.starts_with('+')) word.remove_prefix(1);
    double value = 0;
    const char* const end = word.data() + word.size();
    const auto [stop, failure] = std::from_chars(word.data(), end, value);
    number = static_cast<float>(value);
    if (failure != std::errc{} || stop != end || !std::isfinite(number)) malformed();
  }
  if (!rest.empty()) malformed();
}

}  // namespace sheaf
