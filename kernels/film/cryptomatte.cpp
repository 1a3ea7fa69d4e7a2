#include "kernels/film/cryptomatte.h"

#include "core/lanes.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <map>

namespace sheaf {

namespace {

/// A kind of name: what of it there is in layers.
struct NameLayers {
  Aov number, cryptomatte;
  const char* layer;  ///< of Cryptomatte
  const std::vector<std::string> SceneNames::*names;
  const std::vector<std::uint32_t> SceneNames::*of_shape;
};
constexpr NameLayers kNameLayers[] = {
    {Aov::kObjectId, Aov::kCryptomatteObject, "CryptoObject", &SceneNames::objects, &SceneNames::object_of_shape},
    {Aov::kMaterialId, Aov::kCryptomatteMaterial, "CryptoMaterial", &SceneNames::materials,
     &SceneNames::material_of_shape}};

/// So many digits in base 16.
std::string hexadecimal(std::uint32_t value, int digits) {
  std::string text;
  for (int shift = 28; shift > 28 - 4 * digits; shift -= 4) text += "0123456789abcdef"[value >> shift & 15u];
  return text;
}

/// A string of JSON.
std::string json_string(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      out += "\\u" + hexadecimal(static_cast<std::uint32_t>(c) << 16, 4);
    else
      out += c;
  }
  return out + '"';
}

/// A name that covers part of a pixel.
struct Covering {
  std::uint32_t index;  ///< of the name
  double weight;
};

/// What covers a pixel.
struct PixelNames {
  std::vector<Covering> ranked;  ///< those that cover most of it first
  double total = 0;              ///< weight of all samples
  double nothing = 0;            ///< weight of those on no surface
};

PixelNames names_of(const IdCoverage& pixel, const std::vector<std::uint32_t>& of_shape) {
  std::vector<IdCoverage::Entry> entries = pixel.entries();
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) { return a.shape < b.shape; });
  std::map<std::uint32_t, double> weights;
  PixelNames names;
  for (const IdCoverage::Entry& entry : entries) {
    names.total += entry.weight;
    if (entry.shape == IdCoverage::kNothing)
      names.nothing = entry.weight;
    else
      weights[of_shape.at(entry.shape)] += entry.weight;
  }
  // Negative lobes of filters may leave less than nothing.
  for (const auto& [index, weight] : weights)
    if (weight > 0.0 && names.total > 0.0) names.ranked.push_back({index, weight});
  std::stable_sort(names.ranked.begin(), names.ranked.end(),
                   [](const auto& a, const auto& b) { return a.weight > b.weight; });
  return names;
}

/// The name that covers most of the pixel, counted from 1; 0: more of it is covered by none.
float number_of(const PixelNames& names) {
  if (names.ranked.empty() || names.nothing > names.ranked[0].weight) return 0.0f;
  return static_cast<float>(names.ranked[0].index + 1);
}

/// The picture with room for more channels.
Image with_channels(const Image& image, const std::vector<std::string>& more) {
  std::vector<std::string> names = image.channels;
  names.insert(names.end(), more.begin(), more.end());
  Image out(image.width, image.height, std::move(names));
  out.x0 = image.x0;
  out.y0 = image.y0;
  out.frame_width = image.frame_width;
  out.frame_height = image.frame_height;
  const std::size_t from = image.channels.size(), to = out.channels.size();
  for (std::size_t pixel = 0; pixel < image.pixel_count(); ++pixel)
    std::copy_n(image.data.begin() + static_cast<std::ptrdiff_t>(pixel * from), from,
                out.data.begin() + static_cast<std::ptrdiff_t>(pixel * to));
  return out;
}

/// The material of materials that share a name: the first of them.
std::vector<std::uint32_t> first_of_name(const std::vector<std::string>& names) {
  std::map<std::string_view, std::uint32_t> first;
  std::vector<std::uint32_t> out;
  for (std::uint32_t i = 0; i < names.size(); ++i) out.push_back(first.try_emplace(names[i], i).first->second);
  return out;
}

void fill(const NameLayers& kind, AovSet aovs, const SceneNames& names, const Film& film, int channel, Image& image) {
  const std::vector<std::string>& words = names.*kind.names;
  const std::vector<std::uint32_t> first = first_of_name(words);
  std::vector<std::uint32_t> of_shape = names.*kind.of_shape;
  for (std::uint32_t& index : of_shape) index = first[index];
  std::vector<float> ids;
  for (const std::string& word : words) ids.push_back(bits_float(cryptomatte_id(word)));
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const PixelNames pixel = names_of(film.coverage(x + image.x0, y + image.y0), of_shape);
      int at = channel;
      if (aovs.contains(kind.number)) image.at(x, y, at++) = number_of(pixel);
      if (!aovs.contains(kind.cryptomatte)) continue;
      const auto count = std::min(pixel.ranked.size(), static_cast<std::size_t>(kCryptomatteRanks));
      for (std::size_t i = 0; i < count; ++i) {
        image.at(x, y, at++) = ids[pixel.ranked[i].index];
        image.at(x, y, at++) = static_cast<float>(pixel.ranked[i].weight / pixel.total);
      }
    }
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
    const std::string key = "cryptomatte/" + hexadecimal(murmur_hash3_32(kind.layer), 7) + "/";
    std::map<std::string, std::uint32_t> ids;
    for (const std::string& name : names.*kind.names) ids.emplace(name, cryptomatte_id(name));
    std::string manifest = "{";
    for (const auto& [name, id] : ids)
      manifest += (manifest.size() > 1 ? "," : "") + json_string(name) + ":\"" + hexadecimal(id, 8) + '"';
    attributes.emplace_back(key + "name", kind.layer);
    attributes.emplace_back(key + "hash", "MurmurHash3_32");
    attributes.emplace_back(key + "conversion", "uint32_to_float32");
    attributes.emplace_back(key + "manifest", manifest + "}");
  }
  return attributes;
}

void add_id_layers(AovSet aovs, const SceneNames& names, const Film& film, Image& image) {
  if (!aovs.contains(AovSource::kSurfaceId)) return;
  const auto first_new = static_cast<int>(image.channels.size());
  std::vector<std::string> more;
  std::vector<int> first;
  for (const NameLayers& kind : kNameLayers) {
    first.push_back(first_new + static_cast<int>(more.size()));
    const AovEntry& number = kAovList[static_cast<std::size_t>(kind.number)];
    if (aovs.contains(kind.number)) more.emplace_back(number.channels[0]);
    if (!aovs.contains(kind.cryptomatte)) continue;
    for (int i = 0; i < 2 * kCryptomatteRanks; ++i)
      more.push_back(kind.layer + ("0" + std::to_string(i / 4)) + "." + "rgba"[i % 4]);
  }
  image = with_channels(image, more);
  for (std::size_t i = 0; i < first.size(); ++i) {
    const NameLayers& kind = kNameLayers[i];
    if (aovs.contains(kind.number) || aovs.contains(kind.cryptomatte)) fill(kind, aovs, names, film, first[i], image);
  }
}

}  // namespace sheaf
