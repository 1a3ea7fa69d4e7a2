#include "kernels/denoise/denoise.h"

#include "core/io/error.h"
#include "kernels/denoise/features.h"
#include "kernels/denoise/fireflies.h"
#include "kernels/denoise/oidn.h"
#include "kernels/denoise/select_filters.h"
#include "kernels/denoise/smooth_variance.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

namespace sheaf {

namespace {

/// Negligible difference, relative to the image's mean.
constexpr float kMinDifference = 1e-3f;

constexpr const char* kColorNames[] = {"R", "G", "B"};

/// The channels `prefix` + R, G and B; empty planes if one of them is missing.
Planes3 find_colors(const Image& image, const std::string& prefix) {
  std::vector<Plane> planes = find_planes(image, {prefix + "R", prefix + "G", prefix + "B"});
  if (planes.empty()) return {};
  return {std::move(planes[0]), std::move(planes[1]), std::move(planes[2])};
}

/// Calls f(value of a, value of b) for all pixels and sets a to the result.
template <class F> void combine(Planes3& a, const Planes3& b, F f) {
  for (std::size_t c = 0; c < 3; ++c)
    tbb::parallel_for(0, a[c].height(), [&](int y) {
      for (int x = 0; x < a[c].width(); ++x) a[c].at(x, y) = f(a[c].at(x, y), b[c].at(x, y));
    });
}

double mean_of(const Planes3& color) {
  double sum = 0;
  for (const Plane& plane : color)
    for (int y = 0; y < plane.height(); ++y)
      for (int x = 0; x < plane.width(); ++x) sum += std::abs(plane.at(x, y));
  return sum / (3.0 * color[0].width() * color[0].height());
}

/// Lists the available features, e.g. ", features albedo N Z".
std::string describe_features(const Image& image) {
  std::string text;
  for (const auto& [name, channel] : {std::pair{"albedo", "albedo.R"}, {"N", "N.X"}, {"Z", "Z"}})
    if (image.find_channel(channel) >= 0) text += std::string(text.empty() ? ", features " : " ") + name;
  return text.empty() ? ", no features" : text;
}

Planes3 denoise_nl_means(const Image& image, std::string& description) {
  // Find the noisy color and its variance.
  Planes3 color = find_colors(image, ""), variance = find_colors(image, "variance.");
  if (variance[0].is_empty())
    throw Error(ExitCode::kUsage,
                "the image lacks the layers variance.R/G/B that non-local means require: render it with --replicates "
                "4, or any number above 1");
  combine(variance, variance, [](float v, float) { return std::max(v, 0.0f); });
  // Recover both halves from the mean and one half, and remove fireflies.
  NlMeansInput input;
  input.width = image.width;
  input.height = image.height;
  input.half[0] = find_colors(image, "half.");
  const bool dual = !input.half[0][0].is_empty();
  if (dual) {
    input.halves = 2;
    input.half[1] = color;
    combine(input.half[1], input.half[0], [](float mean, float half) { return 2 * mean - half; });
    const Planes3 first = input.half[0];
    remove_fireflies(input.half[0], variance, &input.half[1]);
    remove_fireflies(input.half[1], variance, &first);
    color = input.half[0];
    combine(color, input.half[1], [](float a, float b) { return 0.5f * (a + b); });
  } else {
    remove_fireflies(color, variance, nullptr);
    input.half[0] = color;
  }
  // Prepare the variance of one half, the noise correlation and the features.
  input.variance = smooth_variance(variance, dual ? input.half : nullptr);
  if (dual) combine(input.variance, input.variance, [](float v, float) { return 2 * v; });
  for (Plane& plane : input.variance) plane.extend();
  for (Planes3& half : input.half)
    if (!half[0].is_empty())
      for (Plane& plane : half) plane.extend();
  if (dual) input.correlation = NoiseCorrelation(input.half[0], input.half[1], input.variance);
  input.features = find_features(image, input.correlation);
  // Run all filters and combine the best ones per pixel.
  input.epsilon = sqr(kMinDifference * static_cast<float>(mean_of(color))) + 1e-20f;
  description = fmt::format("nlm: {}{}", dual ? "two halves" : "one buffer", describe_features(image));
  return select_filters(nl_means(input, NlMeansSettings{}), color, variance);
}

/// The image with denoised.R/G/B, added or replaced.
Image with_denoised(const Image& image, const Planes3& denoised) {
  // Find or add the channels
  Image out = image;
  int index[3];
  for (int c = 0; c < 3; ++c) {
    const std::string name = std::string("denoised.") + kColorNames[c];
    index[c] = out.find_channel(name);
    if (index[c] >= 0) continue;
    index[c] = static_cast<int>(out.channels.size());
    out.channels.push_back(name);
  }
  // Copy the existing values and write the denoised ones
  const std::size_t before = image.channels.size(), after = out.channels.size();
  out.data.assign(out.pixel_count() * after, 0.0f);
  tbb::parallel_for(0, out.height, [&](int y) {
    for (int x = 0; x < out.width; ++x) {
      const float* const from =
          &image
               .data[(static_cast<std::size_t>(y) * static_cast<std::size_t>(out.width) + static_cast<std::size_t>(x)) *
                     before];
      std::copy(from, from + before, &out.at(x, y, 0));
      for (int c = 0; c < 3; ++c) out.at(x, y, index[c]) = denoised[static_cast<std::size_t>(c)].at(x, y);
    }
  });
  return out;
}

}  // namespace

void check_denoiser(Denoiser denoiser) {
  if (denoiser == Denoiser::kOidn) check_oidn();
}

Denoiser best_denoiser() {
  try {
    check_oidn();
    return Denoiser::kOidn;
  } catch (const Error&) { return Denoiser::kNlMeans; }
}

DenoiseResult denoise(const Image& image, Denoiser denoiser, int threads) {
  if (threads > 0) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    return arena.execute([&] { return denoise(image, denoiser); });
  }
  for (const char* name : kColorNames)
    if (image.find_channel(name) < 0)
      throw Error(ExitCode::kUsage, fmt::format("the image has no channel {} to denoise", name));
  DenoiseResult result;
  const Planes3 denoised = denoiser == Denoiser::kOidn ? denoise_oidn(image, result.description)
                                                       : denoise_nl_means(image, result.description);
  result.image = with_denoised(image, denoised);
  return result;
}

void add_denoise_attribute(ExrMetadata& metadata, const DenoiseResult& result) {
  constexpr const char* kName = "sheaf/denoiser";
  std::erase_if(metadata.attributes, [](const ExrMetadata::Attribute& attribute) { return attribute.name == kName; });
  metadata.attributes.push_back({kName, result.description});
}

Image denoised_only(const Image& image) {
  std::vector<std::string> names = {"R", "G", "B"};
  const int alpha = image.find_channel("A");
  if (alpha >= 0) names.emplace_back("A");
  Image out(image.width, image.height, names);
  for (int c = 0; c < static_cast<int>(names.size()); ++c) {
    const int from = c < 3 ? image.find_channel("denoised." + names[static_cast<std::size_t>(c)]) : alpha;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) out.at(x, y, c) = image.at(x, y, from);
  }
  return out;
}

}  // namespace sheaf
