#include "tools/job/apply_arguments.h"

#include "core/io/error.h"
#include "core/simd/saturate.h"
#include "scene/dialects/common/setting_names.h"
#include "scene/dialects/native_color.h"
#include "tools/job/parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <tuple>

namespace sheaf {

namespace {

/// Maximum pixels along a side of the frame, as in scene files.
constexpr int kMaxFrameSide = 1'000'000'000;

/// Minimum samples per pixel at which --denoise nlm uses 4 sample sets instead of 2.
constexpr std::uint32_t kDenoisedSamples = 16;

/// The value of --candidates; empty for auto. Throws Error (exit code 2).
std::optional<int> parse_candidates(const std::string& text) {
  if (text == "auto") return std::nullopt;
  int count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (error != std::errc() || end != text.data() + text.size() || count < 1 || count > kMaxCandidates)
    throw Error(ExitCode::kUsage,
                fmt::format("--candidates {}: expected auto or a number from 1 to {}", text, kMaxCandidates));
  return count;
}

void apply_transport(const RenderArguments& arguments, IntegratorSettings& integrator) {
  if (arguments.max_depth) integrator.max_depth = *arguments.max_depth;
  if (arguments.rr_depth) integrator.rr_depth = *arguments.rr_depth;
  if (!arguments.candidates.empty()) integrator.candidates = parse_candidates(arguments.candidates);
  if (!arguments.light_sampler.empty())
    integrator.light_selector = kLightSelectors.option("light sampler", arguments.light_sampler);
  if (!arguments.medium_estimator.empty())
    integrator.medium_estimator = kMediumEstimators.option("medium estimator", arguments.medium_estimator);
  if (arguments.step_size) integrator.step_size = *arguments.step_size;
}

/// Default maximum of samples per pixel if a noise target or a time limit decides.
constexpr std::uint32_t kMaxAdaptiveSamples = 1 << 16;

/// The requested samples per pixel; empty: those of the scene.
std::optional<std::uint32_t> requested_samples(const RenderArguments& arguments) {
  const bool is_adaptive = arguments.noise_target || arguments.time_limit;
  return arguments.spp || !is_adaptive ? arguments.spp : kMaxAdaptiveSamples;
}

/// Sets the kind of sampler and the samples per pixel.
void apply_sampler(const RenderArguments& arguments, SamplerSettings& sampler, SettingsRemarks& remarks) {
  const auto add = [](std::vector<std::string>& list, std::string text) {
    if (!text.empty()) list.push_back(std::move(text));
  };
  if (arguments.sampler.empty()) {
    add(remarks.details, rendered_sampler_note(sampler.kind));
    sampler.kind = rendered_sampler(sampler.kind);
  } else {
    sampler.kind = kSamplers.option("sampler", arguments.sampler);
    add(remarks.notes, sampler_substitution_note(arguments.sampler));
  }
  const std::uint32_t requested = requested_samples(arguments).value_or(sampler.sample_count);
  sampler.sample_count = rounded_sample_count(sampler.kind, requested);
  add(remarks.notes, rounding_note(sampler.kind, requested));
}

/// Sets the size of the frame. The scene's crop window keeps its relative position. Throws Error (exit code 2) if the
/// frame is too large.
void apply_size(const RenderArguments& arguments, FilmSettings& film) {
  if (arguments.size.empty() && !arguments.scale) return;
  const FilmSettings before = film;
  if (!arguments.size.empty()) std::tie(film.width, film.height) = parse_size(arguments.size);
  const double scale = arguments.scale.value_or(1.0);
  if (std::max(film.width, film.height) * scale > kMaxFrameSide)
    throw Error(ExitCode::kUsage,
                fmt::format("--scale {:g} gives a frame of {:g} x {:g} pixels, expected at most {} per side", scale,
                            film.width * scale, film.height * scale, kMaxFrameSide));
  const auto scaled = [](int pixels, double factor) { return saturate<int>(std::round(pixels * factor)); };
  film.width = std::max(scaled(film.width, scale), 1);
  film.height = std::max(scaled(film.height, scale), 1);
  if (!film.crop) return;
  const double x = static_cast<double>(film.width) / before.width, y = static_cast<double>(film.height) / before.height;
  PixelRect crop{scaled(film.crop->x0, x), scaled(film.crop->y0, y), scaled(film.crop->x1, x),
                 scaled(film.crop->y1, y)};
  crop.x0 = std::min(crop.x0, film.width - 1);
  crop.y0 = std::min(crop.y0, film.height - 1);
  crop.x1 = std::max(crop.x1, crop.x0 + 1);
  crop.y1 = std::max(crop.y1, crop.y0 + 1);
  film.crop = crop;
}

/// Sets how the pixel filter is applied. OIDN expects pixels whose noise is independent.
void apply_filter_mode(const RenderArguments& arguments, FilmSettings& film) {
  if (!arguments.filter_mode.empty())
    film.filter_mode = kFilterModes.option("filter mode", arguments.filter_mode);
  else if (arguments.denoiser == "oidn")
    film.filter_mode = FilterMode::kImportance;
}

/// Number of sets of samples: as requested. By default several if non-local means need variances and the sampler's
/// samples are not independent. Throws Error (exit code 2) if there would be a single set.
int choose_replicates(const RenderArguments& arguments, const SamplerSettings& sampler) {
  if (arguments.denoiser != "nlm") return arguments.replicates;
  if (sampler.sample_count < 2 || arguments.replicates == 1)
    throw Error(ExitCode::kUsage, "--denoise nlm needs at least 2 samples per pixel, and --replicates above 1");
  if (arguments.replicates != 0 || sampler.kind == SamplerKind::kIndependent) return arguments.replicates;
  return sampler.sample_count < kDenoisedSamples ? 2 : 4;
}

/// The requested AOVs plus those that the denoiser uses.
AovSet wanted_aovs(const RenderArguments& arguments) {
  AovSet aovs = aovs_from_names(arguments.aovs);
  if (arguments.denoiser.empty()) return aovs;
  for (const Aov aov : {aov_named("albedo"), aov_named("normal"), aov_named("depth")}) aovs.insert(aov);
  if (arguments.denoiser == "nlm")
    for (const Aov aov : {aov_named("variance"), aov_named("half")}) aovs.insert(aov);
  return aovs;
}

/// The requested color mode; otherwise that of the scene's dialect.
ColorMode choose_color(const RenderArguments& arguments, SettingsRemarks& remarks) {
  const ColorMode native = native_color(arguments.scene);
  if (arguments.color.empty() && native == ColorMode::kSpectral)
    remarks.details.push_back(arguments.scene +
                              ": rendered with --color spectral, as pbrt does; --color rgb is faster");
  return arguments.color.empty() ? native : kColorModes.option("color mode", arguments.color);
}

/// The request for a render of a scene with these settings.
RenderRequest request_of(const RenderArguments& arguments, const SamplerSettings& sampler) {
  RenderRequest request;
  request.samples_per_pixel = requested_samples(arguments);
  request.seed = arguments.seed;
  request.replicates = choose_replicates(arguments, sampler);
  request.spectral_bins = arguments.spectral_bins;
  request.noise_target = static_cast<double>(arguments.noise_target.value_or(0.0f));
  request.time_limit = static_cast<double>(arguments.time_limit.value_or(0.0f));
  request.aovs = wanted_aovs(arguments);
  request.light_groups = arguments.light_groups;
  request.guiding =
      arguments.guiding.empty() ? GuidingMode::kAuto : kGuidingModes.option("guiding mode", arguments.guiding);
  if (!arguments.caustics.empty()) request.caustics = kCausticModes.option("caustics", arguments.caustics);
  if (arguments.clamp_indirect) request.clamp_indirect = *arguments.clamp_indirect;
  if (!arguments.samples.empty()) request.samples = parse_samples(arguments.samples);
  if (const std::vector<int>& crop = arguments.crop; !crop.empty())
    request.crop = PixelRect{crop[0], crop[1], crop[2], crop[3]};
  return request;
}

}  // namespace

void choose_denoiser(std::string& denoiser) {
  if (denoiser == "auto") denoiser = kDenoisers.name_of(best_denoiser());
  if (!denoiser.empty()) check_denoiser(kDenoisers.option("denoiser", denoiser));
}

ReadOptions read_options(const RenderArguments& arguments) {
  ReadOptions options = read_options(arguments.scene, arguments.read);
  if (!arguments.size.empty()) {
    const auto [width, height] = parse_size(arguments.size);
    options.view.aspect_ratio = static_cast<double>(width) / height;
  }
  return options;
}

RenderSettings resolve_settings(const RenderArguments& arguments, const Description& scene, SettingsRemarks& remarks) {
  SceneSettings settings = scene;
  apply_transport(arguments, settings.integrator);
  apply_sampler(arguments, settings.sampler, remarks);
  apply_size(arguments, settings.film);
  apply_filter_mode(arguments, settings.film);
  return resolve_settings(settings, choose_color(arguments, remarks), request_of(arguments, settings.sampler));
}

}  // namespace sheaf
