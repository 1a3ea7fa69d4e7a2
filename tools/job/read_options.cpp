#include "tools/job/read_options.h"

#include "core/io/error.h"
#include "core/io/name_table.h"
#include "scene/dialects/read_model.h"
#include "scene/formats/model_formats.h"
#include "tools/options/option_groups.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

namespace sheaf {

namespace {

std::pair<std::string, std::string> split_definition(const std::string& definition) {
  const std::size_t equals = definition.find('=');
  if (equals == std::string::npos || equals == 0)
    throw Error(ExitCode::kUsage, fmt::format("-D {}: expected name=value", definition));
  return {definition.substr(0, equals), definition.substr(equals + 1)};
}

constexpr NameTable<NoriCamera> kNoriCameras{{{"eth", NoriCamera::kEth}, {"upstream", NoriCamera::kUpstream}}};
constexpr NameTable<ModelView::Up> kUpAxes{
    {{"x", ModelView::Up::kX}, {"y", ModelView::Up::kY}, {"z", ModelView::Up::kZ}}};
constexpr NameTable<Studio> kStudios{{{"none", Studio::kNone}, {"soft", Studio::kSoft}, {"sun", Studio::kSun}}};

/// Throws Error for options that do not apply to a file of this kind.
void check_model_options(const std::filesystem::path& file, const ReadArguments& arguments) {
  const bool gltf = reads_as_gltf(file), model = find_model_format(file) != nullptr;
  const bool viewed = !arguments.view.empty() || !arguments.up.empty() || arguments.fov;
  if (viewed && !model && !arguments.lenient)
    throw Error(ExitCode::kUsage,
                fmt::format("--view, --up and --fov apply to models ({}), not to scenes", model_extensions()));
  if ((!arguments.environment.empty() || arguments.no_floor || !arguments.studio.empty()) && !model)
    throw Error(ExitCode::kUsage, "--env, --no-floor and --studio apply to models, not to scenes");
  if (arguments.studio == kStudios.name_of(Studio::kSoft) && (!arguments.environment.empty() || arguments.no_floor))
    throw Error(ExitCode::kUsage,
                fmt::format("--studio soft has its own lights and backdrop and excludes {} (expected sun or none)",
                            arguments.no_floor ? "--no-floor" : "--env"));
  if (!gltf && (arguments.time || !arguments.animation.empty()))
    throw Error(ExitCode::kUsage,
                fmt::format("--time and --animation apply to animated models ({})", scene_model_extensions()));
  if (!arguments.animation.empty() && !arguments.time) throw Error(ExitCode::kUsage, "--animation requires --time");
  if (arguments.shutter.empty()) return;
  if (model && !gltf)
    throw Error(ExitCode::kUsage,
                fmt::format("--shutter applies to scenes and animated models ({}), not to models that do not move",
                            scene_model_extensions()));
  if (gltf && !arguments.time) throw Error(ExitCode::kUsage, "--shutter requires --time or --frames for a model");
}

}  // namespace

void add_read_options(Command& command, ReadArguments& arguments) {
  command.begin_group(kSceneOptions);
  command.add_option("-D,--define", arguments.definitions, "name=value: replaces $name in the scene; may be repeated")
      .placeholder("NAME=VALUE");
  command.begin_group(kAdvancedOptions);
  command.add_flag("--lenient", arguments.lenient,
                   "Render malformed or unsupported scenes: substitute or drop what cannot be read, with warnings");
  command
      .add_option("--nori-camera", arguments.nori_camera,
                  "Image orientation of Nori scenes: eth (default), or upstream, the mirror image")
      .one_of(kNoriCameras.names());
  command.begin_group(kSceneOptions);
  command
      .add_option("--view", arguments.view,
                  "Camera direction for a model: azimuth,elevation in degrees. Default: 30,20")
      .list(',', 2)
      .placeholder("AZIMUTH,ELEVATION");
  command.add_option("--up", arguments.up, "Up axis of a model: x, y (default) or z").one_of(kUpAxes.names());
  command.add_option("--fov", arguments.fov, "Field of view for a model, in degrees. Default: 35").in_range(1.f, 170.f);
  command
      .add_option("--env", arguments.environment,
                  "Environment map for a model: an image by longitude and latitude, or none. Default: the lights of "
                  "--studio, or a sky with a sun")
      .file();
  command.add_flag("--no-floor", arguments.no_floor, "Place no floor below a model: --studio none");
  command
      .add_option(
          "--studio", arguments.studio,
          "Surroundings of a model without cameras and lights: soft (a seamless backdrop, with key, fill and rim "
          "light), sun (a floor under a sky with a sun), or none (the model under the sky and the sun). "
          "Default: soft; sun with --env and for 'sheaf watch'")
      .one_of(kStudios.names());
  command
      .add_option("--camera", arguments.camera,
                  "Camera of a Mitsuba scene or model with several: its name or its number, from 0. Default: the first")
      .placeholder("NAME");
  command.add_option("--time", arguments.time,
                     "Moment of an animated model, in seconds. Default: the model without its animation");
  command
      .add_option("--animation", arguments.animation,
                  "Animation of a model for --time: its name or its number, from 0. Default: the first")
      .placeholder("NAME");
  command
      .add_option("--shutter", arguments.shutter,
                  "Times at which the shutter opens and closes, instead of the scene's; relative to --time for models. "
                  "RAMP, 0 to 0.5: part of the interval in which it opens, and again closes; 0 if absent. Default: the "
                  "scene's")
      .placeholder("OPEN:CLOSE[:RAMP]");
}

ReadOptions read_options(const std::filesystem::path& file, const ReadArguments& arguments) {
  ReadOptions options;
  options.lenient = arguments.lenient;
  if (arguments.from_working_folder) options.folder = "";
  for (const std::string& definition : arguments.definitions) options.defines.push_back(split_definition(definition));
  if (!arguments.nori_camera.empty()) options.nori_camera = kNoriCameras.option("camera", arguments.nori_camera);
  check_model_options(file, arguments);
  ModelView& view = options.view;
  if (!arguments.view.empty()) {
    view.azimuth = arguments.view[0];
    view.elevation = arguments.view[1];
    if (!std::isfinite(view.azimuth)) throw Error(ExitCode::kUsage, "--view: expected a finite azimuth in degrees");
    if (!(view.elevation >= -90 && view.elevation <= 90))
      throw Error(ExitCode::kUsage, "--view: expected an elevation from -90 to 90 degrees");
  }
  if (!arguments.up.empty()) view.up = kUpAxes.option("axis", arguments.up);
  if (arguments.fov) view.fov = *arguments.fov;
  options.surroundings.floor = !arguments.no_floor;
  options.surroundings.environment = arguments.environment;
  if (!arguments.studio.empty()) options.surroundings.studio = kStudios.option("studio", arguments.studio);
  if (arguments.turns_camera) options.surroundings.default_studio = Studio::kSun;
  if (arguments.time && !std::isfinite(*arguments.time))
    throw Error(ExitCode::kUsage, "--time: expected a finite number of seconds");
  options.moment = {arguments.time, arguments.animation};
  options.camera = arguments.camera;
  if (!arguments.shutter.empty()) options.shutter = parse_shutter(arguments.shutter);
  return options;
}

ShutterDescription parse_shutter(const std::string& text) {
  const std::string option = fmt::format("--shutter '{}': expected ", text);
  constexpr double kMaxTime = std::numeric_limits<float>::max();
  std::vector<double> numbers;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t colon = std::min(text.find(':', at), text.size());
    const char *const begin = text.data() + at, *const end = text.data() + colon;
    double number = 0;
    const auto [next, error] = std::from_chars(begin, end, number);
    if (error != std::errc() || next != end || !(std::fabs(number) <= kMaxTime) || numbers.size() == 3)
      throw Error(ExitCode::kUsage, option + "OPEN:CLOSE or OPEN:CLOSE:RAMP, such as 0:0.02");
    numbers.push_back(number);
    at = colon + 1;
  }
  if (numbers.size() < 2) throw Error(ExitCode::kUsage, option + "OPEN:CLOSE or OPEN:CLOSE:RAMP, such as 0:0.02");
  if (numbers[1] < numbers[0]) throw Error(ExitCode::kUsage, option + "a shutter that does not close before it opens");
  numbers.resize(3, 0.0);
  if (!(numbers[2] >= 0 && numbers[2] <= 0.5)) throw Error(ExitCode::kUsage, option + "a ramp from 0 to 0.5");
  return {numbers[0], numbers[1], static_cast<float>(numbers[2])};
}

std::pair<int, int> parse_size(const std::string& text) {
  constexpr int kMax = 1'000'000;
  int size[2] = {0, 0};
  const char* const end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size[0]);
  if (width.ec == std::errc() && width.ptr != end && (*width.ptr == 'x' || *width.ptr == 'X')) {
    const auto height = std::from_chars(width.ptr + 1, end, size[1]);
    if (height.ec == std::errc() && height.ptr == end && size[0] > 0 && size[1] > 0 && size[0] <= kMax &&
        size[1] <= kMax)
      return {size[0], size[1]};
  }
  throw Error(ExitCode::kUsage, fmt::format("--size {}: expected WxH, e.g. 640x480, each from 1 to 1000000", text));
}

}  // namespace sheaf
