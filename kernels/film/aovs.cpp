#include "kernels/film/aovs.h"

#include "core/io/error.h"
#include "core/io/name_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace sheaf {

namespace {

constexpr std::string_view kAll = "all";

std::vector<std::string> aov_names() {
  std::vector<std::string> names;
  for (const AovEntry& entry : kAovList) names.emplace_back(entry.name);
  names.emplace_back(kAll);
  return names;
}

void insert_named(std::string_view name, AovSet& aovs) {
  bool known = name == kAll;
  for (const AovEntry& entry : kAovList) {
    if (name != entry.name && name != kAll) continue;
    aovs.insert(entry.aov);
    known = true;
  }
  if (known) return;
  throw Error(ExitCode::kUsage, unknown_option("layer", name, aov_names()));
}

/// Maximum bytes of a group's name, so that the layer's name plus number and channel stay within OpenEXR's 255.
constexpr std::size_t kMaxLayerName = 200;

/// Turns a light group's name into a layer name. Dots separate layers from channels, and some programs end names at
/// control characters, so "_" replaces both.
std::string layer_name(std::string name) {
  for (char& c : name)
    if (c == '.' || static_cast<unsigned char>(c) < 32 || c == 127) c = '_';
  std::size_t length = std::min(name.size(), kMaxLayerName);
  // Do not cut a UTF-8 character in two.
  while (length < name.size() && length > 0 && (static_cast<unsigned char>(name[length]) & 0xc0u) == 0x80u) --length;
  name.resize(length);
  return "light_" + name;
}

}  // namespace

std::string aov_descriptions() {
  std::string text;
  for (const AovEntry& entry : kAovList) {
    text += fmt::format("{}{}: {} (", text.empty() ? "" : ";\n", entry.name, entry.description);
    for (const std::string_view channel : entry.channels)
      if (!channel.empty()) text += (text.back() == '(' ? "" : " ") + std::string(channel);
    text += entry.type == PixelType::kHalf ? ", 16 bits)" : ", 32 bits)";
  }
  return text;
}

std::vector<std::string> light_group_layers(const std::vector<std::string>& light_groups) {
  std::vector<std::string> layers;
  std::set<std::string> taken;
  // Reserve the names that need no change first, independently of their order.
  for (const std::string& group : light_groups) layers.push_back(layer_name(group));
  std::vector<bool> done(layers.size());
  for (std::size_t i = 0; i < layers.size(); ++i)
    if (layers[i] == "light_" + light_groups[i]) done[i] = taken.insert(layers[i]).second;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if (done[i]) continue;
    const std::string base = layers[i];
    for (int number = 2; !taken.insert(layers[i]).second; ++number) layers[i] = fmt::format("{}_{}", base, number);
  }
  return layers;
}

AovSet aovs_from_names(std::string_view names) {
  AovSet aovs;
  while (!names.empty()) {
    const std::size_t end = std::min(names.find(','), names.size());
    insert_named(names.substr(0, end), aovs);
    names.remove_prefix(std::min(end + 1, names.size()));
  }
  return aovs;
}

FilmLayout film_layout(AovSet aovs, bool with_variances, const std::vector<std::string>& light_groups) {
  std::vector<FilmChannel> channels = FilmLayout::beauty(with_variances).channels();
  if (aovs.contains(aov_named("half")))
    for (const int channel : {kRed, kGreen, kBlue}) channels[static_cast<std::size_t>(channel)].has_half = true;
  for (const AovEntry& entry : kAovList) {
    if (entry.source != AovSource::kVertex || !aovs.contains(entry.aov)) continue;
    const bool has_variance = with_variances && entry.has_variance && aovs.contains(aov_named("variance"));
    for (const std::string_view channel : entry.channels)
      if (!channel.empty()) channels.push_back({std::string(channel), has_variance});
  }
  for (const std::string& layer : light_group_layers(light_groups))
    for (const char* component : {".R", ".G", ".B"}) channels.push_back({layer + component});
  return FilmLayout(std::move(channels));
}

AovChannels::AovChannels(const FilmLayout& layout, AovSet aovs) : has_surfaces_(aovs.contains(AovSource::kSurfaceId)) {
  first_.fill(-1);
  for (const AovEntry& entry : kAovList)
    if (entry.source == AovSource::kVertex)
      first_[static_cast<std::size_t>(entry.aov)] = layout.find(entry.channels[0]);
}

bool AovChannels::any() const {
  return has_surfaces_ || std::any_of(first_.begin(), first_.end(), [](int channel) { return channel >= 0; });
}

std::vector<std::string> half_channels(const std::vector<std::string>& channels) {
  std::vector<std::string> halves;
  for (const std::string& name : channels)
    for (const AovEntry& entry : kAovList)
      if (entry.type == PixelType::kHalf &&
          std::find(entry.channels.begin(), entry.channels.end(), name) != entry.channels.end())
        halves.push_back(name);
  return halves;
}

}  // namespace sheaf
