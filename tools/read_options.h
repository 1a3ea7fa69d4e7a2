// How a scene file is read: what the subcommands that read one have in common.
#pragma once

#include "scene/dialects/read_scene.h"
#include "tools/options.h"

namespace sheaf {

/// The options as given.
struct ReadArguments {
  std::vector<std::string> definitions;
  bool lenient = false;
  std::string nori_camera = "eth", up;
  std::vector<float> view;  ///< empty, or azimuth and elevation
  std::optional<float> fov;
};

/// Adds -D, --lenient and what tells where a model is seen from.
void add_read_options(Command& command, ReadArguments& arguments);

/// What they mean for a file. Throws Error (exit code 2) for what is malformed or means nothing for such a file.
ReadOptions read_options(const std::filesystem::path& file, const ReadArguments& arguments);

/// Width and height of "WxH", in pixels. Throws Error (exit code 2).
std::pair<int, int> parse_size(const std::string& text);

}  // namespace sheaf
