#include "tools/job/interrupted_image.h"

#include "core/simd/saturate.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace sheaf {

namespace {

/// First words of interruption(), which other formats than OpenEXR hold as their description.
constexpr const char* kInterruption = "the render was interrupted";

}  // namespace

void add_interrupted_attributes(ExrMetadata& metadata, double taken, std::uint32_t planned) {
  metadata.attributes.push_back({kInterruptedAttribute, 1});
  metadata.attributes.push_back({kSamplesTakenAttribute, static_cast<float>(taken)});
  metadata.attributes.push_back({kSamplesPlannedAttribute, saturate<int>(planned)});
}

std::string interruption(std::span<const ExrMetadata::Attribute> attributes) {
  const auto find = [&](const char* name) -> const ExrMetadata::Attribute* {
    const auto found =
        std::find_if(attributes.begin(), attributes.end(), [&](auto& each) { return each.name == name; });
    return found == attributes.end() ? nullptr : &*found;
  };
  if (find(kInterruptedAttribute) == nullptr) return {};
  std::string text = kInterruption;
  const ExrMetadata::Attribute *taken = find(kSamplesTakenAttribute), *planned = find(kSamplesPlannedAttribute);
  if (taken != nullptr && std::holds_alternative<float>(taken->value)) {
    text += fmt::format(" after {:.4g}", std::get<float>(taken->value));
    if (planned != nullptr && std::holds_alternative<int>(planned->value))
      text += fmt::format(" of {}", std::get<int>(planned->value));
    text += " samples per pixel";
  }
  if (const ExrMetadata::Attribute* noise = find(kNoiseAttribute)) {
    const std::optional<double> value = number_of(*noise);
    text += ", at a noise of " + (value ? fmt::format("{:.6g}", *value) : std::string("unknown size"));
  }
  return text;
}

bool is_interrupted(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  // Neither headers of OpenEXR files nor descriptions are compressed
  return bytes.find(kInterruptedAttribute) != std::string::npos || bytes.find(kInterruption) != std::string::npos;
}

}  // namespace sheaf
