#include "kernels/film/cryptomatte.h"

#include "core/simd/lanes.h"
#include "kernels/film/more_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>

namespace sheaf {

namespace {

/// Layers and scene tables of one kind of name.
struct NameLayers {
  Aov number, cryptomatte;
  const char* layer;  ///< of Cryptomatte
  const char* part;   ///< channel prefix of add_part_ids()
  const std::vector<std::string> SceneNames::*names;
  const std::vector<std::uint32_t> SceneNames::*of_shape;
};
constexpr NameLayers kNameLayers[] = {{aov_named("object_id"), aov_named("cryptomatte_object"), "CryptoObject",
                                       "part.object.", &SceneNames::objects, &SceneNames::object_of_shape},
                                      {aov_named("material_id"), aov_named("cryptomatte_material"), "CryptoMaterial",
                                       "part.material.", &SceneNames::materials, &SceneNames::material_of_shape}};
static_assert(std::size(kNameLayers) == kNameKinds);

/// Quotes and escapes a string as JSON.
std::string json_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      out += fmt::format("\\u{:04x}", static_cast<int>(c));
    else
      out += c;
  }
  return out + '"';
}

/// A name and its weight in a pixel.
struct IdWeight {
  std::uint32_t index;  ///< of the name
  double weight;
};

/// The names that cover a pixel.
struct PixelNames {
  std::vector<IdWeight> ranked;  ///< by decreasing weight
  double total = 0;              ///< weight of all samples
  double nothing = 0;            ///< weight of samples that hit no surface
};

/// `index_of`: maps an entry's shape to the index of its name.
template <class IndexOf> PixelNames names_of(const IdCoverage& pixel, IndexOf&& index_of) {
  std::vector<IdCoverage::Entry> entries = pixel.entries();
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.shape < b.shape; });
  std::map<std::uint32_t, double> weights;
  PixelNames names;
  for (const IdCoverage::Entry& entry : entries) {
    names.total += entry.weight;
    if (entry.shape == IdCoverage::kNothing)
      names.nothing = entry.weight;
    else
      weights[index_of(entry.shape)] += entry.weight;
  }
  // Negative filter lobes can leave negative weights.
  for (const auto& [index, weight] : weights)
    if (weight > 0.0 && names.total > 0.0) names.ranked.push_back({index, weight});
  std::stable_sort(names.ranked.begin(), names.ranked.end(),
                   [](const auto& a, const auto& b) { return a.weight > b.weight; });
  return names;
}

/// 1-based index of the name that covers most of the pixel; 0 if the background covers more.
float number_of(const PixelNames& names) {
  if (names.ranked.empty() || names.nothing > names.ranked[0].weight) return 0.0f;
  return static_cast<float>(names.ranked[0].index + 1);
}

/// Maps each name to the first of equal names.
std::vector<std::uint32_t> first_of_name(const std::vector<std::string>& names) {
  std::map<std::string_view, std::uint32_t> first;
  std::vector<std::uint32_t> out;
  for (std::uint32_t i = 0; i < names.size(); ++i) out.push_back(first.try_emplace(names[i], i).first->second);
  return out;
}

/// Index of the name of each row of shapes.
std::vector<std::uint32_t> names_of_shapes(const NameLayers& kind, const SceneNames& names) {
  const std::vector<std::uint32_t> first = first_of_name(names.*kind.names);
  std::vector<std::uint32_t> of_shape = names.*kind.of_shape;
  for (std::uint32_t& index : of_shape) index = first[index];
  return of_shape;
}

std::vector<float> ids_of(const std::vector<std::string>& words) {
  std::vector<float> ids;
  for (const std::string& word : words) ids.push_back(bits_float(cryptomatte_id(word)));
  return ids;
}

void put_names(const PixelNames& pixel, const IdChannels& channels, std::span<const float> ids, float* out) {
  if (channels.number >= 0) out[channels.number] = number_of(pixel);
  if (channels.ranks[0] < 0) return;
  const auto count = std::min(pixel.ranked.size(), static_cast<std::size_t>(kCryptomatteRanks));
  for (std::size_t i = 0; i < count; ++i) {
    out[channels.ranks[2 * i]] = ids[pixel.ranked[i].index];
    out[channels.ranks[2 * i + 1]] = static_cast<float>(pixel.ranked[i].weight / pixel.total);
  }
}

void fill(const NameLayers& kind, const SceneNames& names, const Film& film, const IdChannels& channels, Image& image) {
  const std::vector<std::uint32_t> of_shape = names_of_shapes(kind, names);
  const std::vector<float> ids = ids_of(names.*kind.names);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const PixelNames pixel =
          names_of(film.coverage(x + image.x0, y + image.y0), [&](std::uint32_t shape) { return of_shape.at(shape); });
      put_names(pixel, channels, ids, &image.at(x, y, 0));
    }
}

/// Cryptomatte channel i: even channels hold the ids and odd ones the coverage of rank i / 2.
std::string rank_channel(const NameLayers& kind, int i) {
  return fmt::format("{}0{}.{}", kind.layer, i / 4, "rgba"[i % 4]);
}

/// Channels of add_part_ids(): the weight on nothing, then for each rank a 1-based index and a weight.
std::vector<std::string> part_channels(const NameLayers& kind) {
  std::vector<std::string> channels{kind.part + std::string("nothing")};
  for (int i = 0; i < kPartRanks; ++i)
    for (const char* const what : {"number", "weight"}) channels.push_back(fmt::format("{}{}{}", kind.part, what, i));
  return channels;
}

}  // namespace

std::uint32_t murmur_hash3_32(std::string_view bytes) {
  constexpr std::uint32_t kFirst = 0xcc9e2d51u, kSecond = 0x1b873593u;
  std::uint32_t hash = 0;
  const auto mixed = [](std::uint32_t word) { return std::rotl(word * kFirst, 15) * kSecond; };
  std::size_t at = 0;
  for (; at + 4 <= bytes.size(); at += 4) {
    std::uint32_t word;
    std::memcpy(&word, bytes.data() + at, sizeof word);
    hash = std::rotl(hash ^ mixed(word), 13) * 5 + 0xe6546b64u;
  }
  std::uint32_t rest = 0;
  for (std::size_t i = bytes.size(); i > at; --i) rest = rest << 8 | static_cast<unsigned char>(bytes[i - 1]);
  hash ^= mixed(rest) ^ static_cast<std::uint32_t>(bytes.size());
  hash = (hash ^ hash >> 16) * 0x85ebca6bu;
  hash = (hash ^ hash >> 13) * 0xc2b2ae35u;
  return hash ^ hash >> 16;
}

std::uint32_t cryptomatte_id(std::string_view name) {
  const std::uint32_t hash = murmur_hash3_32(name), exponent = hash >> 23 & 255u;
  return exponent == 0 || exponent == 255 ? hash ^ 1u << 23 : hash;
}

std::vector<std::pair<std::string, std::string>> cryptomatte_attributes(AovSet aovs, const SceneNames& names) {
  std::vector<std::pair<std::string, std::string>> attributes;
  for (const NameLayers& kind : kNameLayers) {
    if (!aovs.contains(kind.cryptomatte)) continue;
    const std::string key = fmt::format("cryptomatte/{:07x}/", murmur_hash3_32(kind.layer) >> 4);
    std::map<std::string, std::uint32_t> ids;
    for (const std::string& name : names.*kind.names) ids.emplace(name, cryptomatte_id(name));
    std::string manifest = "{";
    for (const auto& [name, id] : ids)
      manifest += fmt::format("{}{}:\"{:08x}\"", manifest.size() > 1 ? "," : "", json_string(name), id);
    attributes.emplace_back(key + "name", kind.layer);
    attributes.emplace_back(key + "hash", "MurmurHash3_32");
    attributes.emplace_back(key + "conversion", "uint32_to_float32");
    attributes.emplace_back(key + "manifest", manifest + "}");
  }
  return attributes;
}

void add_id_layers(AovSet aovs, const SceneNames& names, const Film& film, Image& image) {
  if (!aovs.contains(AovSource::kSurfaceId)) return;
  std::vector<std::string> more;
  for (const NameLayers& kind : kNameLayers) {
    if (aovs.contains(kind.number)) more.emplace_back(entry_of(kind.number).channels[0]);
    for (int i = 0; i < 2 * kCryptomatteRanks && aovs.contains(kind.cryptomatte); ++i)
      more.push_back(rank_channel(kind, i));
  }
  image = with_channels(image, more);
  for (std::size_t i = 0; i < kNameKinds; ++i)
    if (const IdChannels channels(image, i); channels.any()) fill(kNameLayers[i], names, film, channels, image);
}

IdChannels::IdChannels(const Image& image, std::size_t kind) {
  const NameLayers& layers = kNameLayers[kind];
  number = image.find_channel(entry_of(layers.number).channels[0]);
  for (int i = 0; i < 2 * kCryptomatteRanks; ++i)
    ranks[static_cast<std::size_t>(i)] = image.find_channel(rank_channel(layers, i));
  // An incomplete set of ranks counts as absent.
  if (std::find(ranks.begin(), ranks.end(), -1) != ranks.end()) ranks.fill(-1);
}

void add_part_ids(AovSet aovs, const SceneNames& names, const Film& film, Image& image) {
  for (const NameLayers& kind : kNameLayers) {
    if (!aovs.contains(kind.number) && !aovs.contains(kind.cryptomatte)) continue;
    const std::size_t first = image.channels.size();
    image = with_channels(image, part_channels(kind));
    const std::vector<std::uint32_t> of_shape = names_of_shapes(kind, names);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        // Sum the weights of each name
        std::map<std::uint32_t, double> weights;
        float* out = &image.at(x, y, static_cast<int>(first));
        for (const IdCoverage::Entry& entry : film.coverage(x + image.x0, y + image.y0).entries())
          entry.shape == IdCoverage::kNothing ? void(*out = static_cast<float>(entry.weight))
                                              : void(weights[of_shape.at(entry.shape)] += entry.weight);
        // Store the names with the largest weights
        std::vector<IdWeight> ranked;
        for (const auto& [index, weight] : weights) ranked.push_back({index, weight});
        std::stable_sort(ranked.begin(), ranked.end(),
                         [](const auto& a, const auto& b) { return std::abs(a.weight) > std::abs(b.weight); });
        ranked.resize(std::min(ranked.size(), static_cast<std::size_t>(kPartRanks)));
        for (const IdWeight& name : ranked) {
          *++out = static_cast<float>(name.index + 1);
          *++out = static_cast<float>(name.weight);
        }
      }
  }
}

PartIds::PartIds(const Image& image, std::size_t kind) {
  for (const std::string& name : part_channels(kNameLayers[kind])) channels_.push_back(image.find_channel(name));
  if (std::find(channels_.begin(), channels_.end(), -1) != channels_.end()) channels_.clear();
}

bool PartIds::add(const float* pixel, IdCoverage& names) const {
  if (const auto nothing = static_cast<double>(pixel[channels_[0]]); nothing != 0.0)
    names.add(IdCoverage::kNothing, nothing);
  for (std::size_t i = 1; i < channels_.size(); i += 2) {
    const float number = pixel[channels_[i]];
    if (number == 0.0f) break;
    if (!(number >= 1.0f && number <= kMaxNames && number == std::floor(number))) return false;
    names.add(static_cast<std::uint32_t>(number) - 1, static_cast<double>(pixel[channels_[i + 1]]));
  }
  return true;
}

bool put_ids(const IdCoverage& names, const IdChannels& channels, std::span<const float> ids, float* pixel) {
  const PixelNames ranked = names_of(names, [](std::uint32_t index) { return index; });
  const auto is_known = [&](const IdWeight& name) { return name.index < ids.size(); };
  if (channels.ranks[0] >= 0 && !std::all_of(ranked.ranked.begin(), ranked.ranked.end(), is_known)) return false;
  put_names(ranked, channels, ids, pixel);
  return true;
}

std::vector<std::pair<std::string, std::string>> part_id_attributes(AovSet aovs, const SceneNames& names) {
  std::vector<std::pair<std::string, std::string>> attributes;
  for (std::size_t i = 0; i < kNameKinds; ++i) {
    if (!aovs.contains(kNameLayers[i].cryptomatte)) continue;
    std::string& ids = attributes.emplace_back(part_id_attribute(i), "").second;
    for (const std::string& name : names.*kNameLayers[i].names) ids += fmt::format("{:08x}", cryptomatte_id(name));
  }
  return attributes;
}

std::string part_id_attribute(std::size_t kind) { return fmt::format("sheaf/ids/{}", kNameLayers[kind].layer); }

std::optional<std::vector<float>> ids_from_attribute(std::string_view text) {
  std::vector<float> ids;
  for (; text.size() >= 8; text.remove_prefix(8)) {
    std::uint32_t id = 0;
    if (std::from_chars(text.data(), text.data() + 8, id, 16).ptr != text.data() + 8) return std::nullopt;
    ids.push_back(bits_float(id));
  }
  return text.empty() ? std::optional(std::move(ids)) : std::nullopt;
}

}  // namespace sheaf
