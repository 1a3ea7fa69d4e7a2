#include "tools/farm/frame_names.h"

#include "core/io/error.h"

#include <fmt/format.h>

#include <charconv>
#include <filesystem>

namespace sheaf {

namespace fs = std::filesystem;

std::vector<int> FrameRange::frames() const {
  std::vector<int> all;
  for (int frame = first; frame <= last; frame += step) all.push_back(frame);
  return all;
}

FrameRange parse_frames(const std::string& text) {
  constexpr int kLast = 9'999'999;
  int numbers[3] = {-1, -1, 1};
  const char *at = text.data(), *const end = text.data() + text.size();
  std::size_t count = 0;
  for (; count < 3; ++count) {
    const auto [after, problem] = std::from_chars(at, end, numbers[count]);
    if (problem != std::errc()) break;
    at = after;
    if (at == end || *at != ':') {
      ++count;
      break;
    }
    ++at;
  }
  const auto [first, last, step] = numbers;
  const bool valid = count >= 2 && at == end && *(end - 1) != ':' && first >= 0 && last >= first && last <= kLast &&
                     step >= 1 && step <= kLast;
  if (!valid)
    throw Error(ExitCode::kUsage,
                fmt::format("--frames '{}': expected FIRST:LAST or FIRST:LAST:STEP, such as 1:240", text));
  return {first, last, step};
}

std::string FrameName::at(int frame) const {
  std::string name = texts.front();
  for (std::size_t i = 0; i < digits.size(); ++i) name += fmt::format("{:0{}d}", frame, digits[i]) + texts[i + 1];
  return name;
}

FrameName frame_name(const std::string& file) {
  constexpr std::string_view kHashes = "####", kVariable = "$frame";
  FrameName name{{""}, {}};
  for (std::size_t i = 0; i < file.size();) {
    const std::string_view rest = std::string_view(file).substr(i);
    int digits = 0;
    std::size_t length = 0;
    if (rest.starts_with(kHashes)) {
      digits = 4;
      length = kHashes.size();
    } else if (rest.starts_with(kVariable)) {
      const bool has_width =
          rest.size() > kVariable.size() && rest[kVariable.size()] >= '1' && rest[kVariable.size()] <= '9';
      digits = has_width ? rest[kVariable.size()] - '0' : 1;
      length = kVariable.size() + (has_width ? 1 : 0);
    }
    if (digits == 0) {
      name.texts.back() += file[i++];
      continue;
    }
    name.digits.push_back(digits);
    name.texts.emplace_back();
    i += length;
  }
  if (!name.digits.empty()) return name;
  const std::string extension = fs::path(file).extension().string();
  return {{file.substr(0, file.size() - extension.size()) + "_", extension}, {4}};
}

}  // namespace sheaf
