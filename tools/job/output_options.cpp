#include "tools/job/output_options.h"

#include "core/image/display_view.h"
#include "core/io/error.h"
#include "core/io/name_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace sheaf {

namespace {

constexpr double kMaxExposure = 100;
constexpr float kMaxDwaLevel = 100'000;

constexpr NameTable<ExrCompression> kCompressions{{{"zip", ExrCompression::kZip},
                                                   {"zips", ExrCompression::kZips},
                                                   {"piz", ExrCompression::kPiz},
                                                   {"dwaa", ExrCompression::kDwaa},
                                                   {"dwab", ExrCompression::kDwab},
                                                   {"rle", ExrCompression::kRle},
                                                   {"none", ExrCompression::kUncompressed}}};

/// A decimal number; nothing if the text is anything else.
std::optional<double> number_in(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double number = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), number);
  if (parsed.ec != std::errc() || parsed.ptr != text.data() + text.size() || !std::isfinite(number))
    return std::nullopt;
  return number;
}

std::optional<double> parse_exposure(const std::string& text) {
  if (text.empty()) return 0;
  if (text == "auto") return std::nullopt;
  const std::optional<double> stops = number_in(text);
  if (!stops || std::abs(*stops) > kMaxExposure)
    throw Error(ExitCode::kUsage, fmt::format("--exposure '{}': expected a number of stops from {} to {}, or auto",
                                              text, -kMaxExposure, kMaxExposure));
  return stops;
}

void parse_compression(const std::string& text, OutputSettings& settings) {
  const std::size_t colon = text.find(':');
  settings.compression = kCompressions.option("compression", text.substr(0, colon));
  if (colon == std::string::npos) return;
  const bool has_level = settings.compression == ExrCompression::kDwaa || settings.compression == ExrCompression::kDwab;
  const std::optional<double> level = number_in(std::string_view(text).substr(colon + 1));
  if (!has_level || !level || !(*level >= 0 && *level <= static_cast<double>(kMaxDwaLevel)))
    throw Error(ExitCode::kUsage,
                fmt::format("--compression '{}': expected a level from 0 to {} after dwaa or dwab, such as dwaa:45, "
                            "and none after others",
                            text, kMaxDwaLevel));
  settings.dwa_level = static_cast<float>(*level);
}

/// The requested view; null if none is requested.
std::shared_ptr<const ColorProcessor> open_view(const OutputArguments& arguments) {
  if (arguments.ocio_config.empty() && arguments.ocio_display.empty() && arguments.ocio_view.empty()) return nullptr;
  if (arguments.tone_map != "none")
    throw Error(ExitCode::kUsage,
                "--tone-map and a view of OpenColorIO exclude each other: the view maps tones itself");
  std::string problem;
  std::shared_ptr<const ColorProcessor> view =
      open_display_view({arguments.ocio_config, arguments.ocio_display, arguments.ocio_view}, problem);
  if (view) return view;
  const std::string config = arguments.ocio_config.empty() ? "" : fmt::format(" '{}'", arguments.ocio_config);
  std::replace(problem.begin(), problem.end(), '\n', ' ');
  throw Error(ExitCode::kUsage, fmt::format("cannot use the OpenColorIO configuration{}: {}", config, problem));
}

}  // namespace

void add_output_options(Command& command, OutputArguments& arguments) {
  command
      .add_option(
          "--exposure", arguments.exposure,
          "Exposure of .png, .jpg and .tif files and previews, in stops, or auto: the log-average luminance "
          "becomes middle gray. .exr files are not affected. Default: auto for renders of models without cameras "
          "and lights, else 0")
      .only_for_run();
  command
      .add_option("--tone-map", arguments.tone_map,
                  "Tone-mapping curve of .png, .jpg and .tif files and previews: none (clamp, the default), filmic, "
                  "aces or agx. See docs/output.md")
      .one_of(kToneMaps.names())
      .only_for_run();
  command
      .add_option("--ocio-config", arguments.ocio_config,
                  "OpenColorIO configuration whose view replaces the tone map: a file, ocio://default or another "
                  "built-in configuration (OpenColorIO 2.2 and newer), or raw. Default: the file that $OCIO names, if "
                  "--ocio-view or --ocio-display is given")
      .only_for_run();
  command
      .add_option("--ocio-display", arguments.ocio_display,
                  "Display of the OpenColorIO configuration. Default: that of the configuration")
      .only_for_run();
  command
      .add_option("--ocio-view", arguments.ocio_view,
                  "View of the OpenColorIO configuration. Default: that of the display")
      .only_for_run();
  command
      .add_option("--compression", arguments.compression,
                  "Compression of .exr files: zip (default), zips, piz, rle or none; or dwaa or dwab, which are lossy, "
                  "with an optional level, such as dwaa:45")
      .only_for_run();
  command.add_option("--jpeg-quality", arguments.jpeg_quality, "Quality of .jpg files, from 1 to 100. Default: 95")
      .in_range(1, 100)
      .only_for_run();
}

OutputSettings output_settings(const OutputArguments& arguments) {
  OutputSettings settings;
  settings.jpeg_quality = arguments.jpeg_quality;
  parse_compression(arguments.compression, settings);
  DisplaySettings display;
  display.exposure = parse_exposure(arguments.exposure);
  display.tone_map = kToneMaps.option("tone map", arguments.tone_map);
  display.display_view = open_view(arguments);
  settings.display = DisplayTransform(std::move(display));
  return settings;
}

void set_model_defaults(const OutputArguments& arguments, OutputSettings& settings) {
  if (!arguments.exposure.empty()) return;
  DisplaySettings display = settings.display.settings();
  display.exposure.reset();
  settings.display = DisplayTransform(std::move(display));
}

std::string exposure_text(double stops) { return fmt::format("{:+.2f} stops", stops); }

}  // namespace sheaf
