// Warns about images with values that are invalid as reflectances. Kernels clamp these, which changes the result.
#include "core/image/image.h"
#include "core/math/half.h"
#include "scene/compile/textures/compile_textures.h"
#include "scene/spectra/spectrum_rgb.h"
#include "scene/textures/tiled_image.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cstdio>
#include <span>

namespace sheaf {

namespace {

/// Count and range of the texel values outside [0, 1].
struct OutOfRangeTexels {
  std::size_t texels = 0;  ///< number of texels with such a value
  float smallest = 0, largest = 0;

  void add(const OutOfRangeTexels& other) {
    texels += other.texels;
    smallest = std::min(smallest, other.smallest);
    largest = std::max(largest, other.largest);
  }
};

float as_float(float value) { return value; }
float as_float(std::uint16_t half) { return half_to_float(half); }

/// Examines tiles with texels of `kValues` numbers of a type. Padding and unused fourth values are zero and so in
/// range.
template <class Value, std::size_t kValues> OutOfRangeTexels out_of_range_texels(std::span<const TexelLine> tiles) {
  using Range = tbb::blocked_range<std::size_t>;
  const auto add = [&](const Range& range, OutOfRangeTexels sum) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const auto* values = reinterpret_cast<const Value*>(tiles[i].bytes);
      for (std::size_t t = 0; t < sizeof(TexelLine) / sizeof(Value); t += kValues) {
        float low = as_float(values[t]), high = low;
        for (std::size_t k = 1; k < kValues; ++k) {
          const float value = as_float(values[t + k]);
          low = std::min(low, value), high = std::max(high, value);
        }
        sum.texels += low < 0.0f || high > 1.0f ? 1 : 0;
        sum.smallest = std::min(sum.smallest, low);
        sum.largest = std::max(sum.largest, high);
      }
    }
    return sum;
  };
  return tbb::parallel_reduce(Range(0, tiles.size(), 1 << 12), OutOfRangeTexels{}, add,
                              [](OutOfRangeTexels a, const OutOfRangeTexels& b) {
                                a.add(b);
                                return a;
                              });
}

OutOfRangeTexels out_of_range_texels(const TiledImage& image) {
  const std::span<const TexelLine> own(image.tiles.data(), image.tiles.size() - 1);  // without the padding tile
  switch (image.format) {
    case TexelFormat::kHalf1:
      return out_of_range_texels<std::uint16_t, 1>(own);
    case TexelFormat::kHalf4:
      return out_of_range_texels<std::uint16_t, 4>(own);
    case TexelFormat::kFloat1:
      return out_of_range_texels<float, 1>(own);
    case TexelFormat::kFloat4:
      return out_of_range_texels<float, 4>(own);
    default:
      return {};
  }
}

/// The inputs of a texture that shows each of them on a part of the surface (kShowsColors).
std::span<const std::uint32_t> shown_inputs(const TextureRow& texture) {
  bool shows = false;
  TextureKinds::for_each([&]<class Description>() {
    if constexpr (requires { Description::kShowsColors; })
      shows = shows || (texture.kind == kTextureKind<Description> && Description::kShowsColors);
  });
  return shows ? texture.used_inputs() : std::span<const std::uint32_t>();
}

/// Marks the textures whose texels are used directly as reflectances: those bound as reflectances, and the inputs
/// that they show. Mixes are clamped after mixing, so their inputs cannot be checked here.
void mark(const TextureTables& textures, std::uint32_t row, std::vector<bool>& marked) {
  if (marked[row]) return;
  marked[row] = true;
  const TextureRow& texture = textures.rows[row];
  for (const std::uint32_t input : shown_inputs(texture)) mark(textures, input, marked);
}

std::string warning(const TextureDescription& texture, const std::string& message) {
  return SceneError(texture.where,
                    (texture.id.empty() ? "texture: " : fmt::format("texture '{}': ", texture.id)) + message)
      .what();
}

std::string warning(const TextureDescription& texture, const BitmapRow& bitmap, const OutOfRangeTexels& outside) {
  const auto all = static_cast<double>(bitmap.width) * static_cast<double>(bitmap.height);
  const double percentage = 100 * static_cast<double>(outside.texels) / all;
  char text[256];
  std::snprintf(
      text, sizeof(text),
      "%zu of %.0f texels (%.3g %%) are above 1 or below 0, from %g to %g: as reflectances they are clamped to "
      "[0, 1]",
      outside.texels, all, percentage, static_cast<double>(outside.smallest), static_cast<double>(outside.largest));
  const auto& description = std::get<BitmapDescription>(texture.model);
  const std::string file = description.encoded ? description.encoded->name : description.file.string();
  return warning(texture, (file.empty() ? "" : file + ": ") + text);
}

/// Maximum of a texture's own constant colors, without other textures.
float largest_color(const TextureTables& textures, std::uint32_t row) {
  constexpr TextureKind kConstant = kTextureKind<ConstantTextureDescription>;
  float largest = 0;
  const auto add = [&](const TextureRow& texture) {
    if (texture.kind != kConstant) return;
    for (const float value : texture.data<ConstantRow>().rgb) largest = std::max(largest, value);
  };
  add(textures.rows[row]);
  for (const std::uint32_t input : shown_inputs(textures.rows[row])) add(textures.rows[input]);
  return largest;
}

}  // namespace

std::vector<std::string> clamped_texel_warnings(const std::vector<TextureDescription>& descriptions,
                                                const TextureTables& textures,
                                                std::span<const TextureBinding> bindings) {
  std::vector<bool> marked(textures.rows.size());
  for (const TextureBinding& binding : bindings)
    if (binding.role == TextureRole::kReflectance) mark(textures, binding.texture, marked);
  std::vector<std::string> warnings;
  std::map<std::uint32_t, OutOfRangeTexels> known;  // by image, because textures may share images
  for (std::size_t i = 0; i < descriptions.size(); ++i) {
    if (!marked[i]) continue;
    if (const float largest = largest_color(textures, static_cast<std::uint32_t>(i)); largest > 1)
      warnings.push_back(warning(descriptions[i], clamped_reflectance(largest)));
    if (textures.rows[i].kind != kTextureKind<BitmapDescription>) continue;
    const auto bitmap = textures.rows[i].data<BitmapRow>();
    const auto [position, is_new] = known.try_emplace(bitmap.image);
    if (is_new) position->second = out_of_range_texels(*textures.tiled_images[bitmap.image]);
    if (position->second.texels > 0) warnings.push_back(warning(descriptions[i], bitmap, position->second));
  }
  return warnings;
}

}  // namespace sheaf
