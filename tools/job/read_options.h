// Options for reading scene files, shared by several subcommands.
#pragma once

#include "scene/dialects/read_scene.h"
#include "tools/options/options.h"

namespace sheaf {

/// The options as given.
struct ReadArguments {
  std::vector<std::string> definitions;
  bool lenient = false;
  std::string nori_camera = "eth", up;
  std::vector<float> view;  ///< empty, or azimuth and elevation, degrees
  std::optional<float> fov;
  std::string environment;  ///< image file
  bool no_floor = false;
  std::string studio;         ///< empty: the default
  bool turns_camera = false;  ///< the camera may move behind a backdrop; default to surroundings that it can see
  std::string camera, animation;
  std::optional<float> time;         ///< seconds
  std::string shutter;               ///< OPEN:CLOSE[:RAMP]; empty: that of the scene
  bool from_working_folder = false;  ///< relative paths in the scene refer to the working directory
};

/// Adds -D, --lenient, --nori-camera, --camera and the options for models.
void add_read_options(Command& command, ReadArguments& arguments);

/// Converts the options for a file. Throws Error (exit code 2) for malformed or inapplicable options.
ReadOptions read_options(const std::filesystem::path& file, const ReadArguments& arguments);

/// Parses "OPEN:CLOSE" or "OPEN:CLOSE:RAMP". Throws Error (exit code 2).
ShutterDescription parse_shutter(const std::string& text);

/// Parses "WxH" in pixels. Throws Error (exit code 2).
std::pair<int, int> parse_size(const std::string& text);

}  // namespace sheaf
