// Reading a scene file of any dialect.
#pragma once

#include "scene/description/description.h"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace sheaf {

/// From where a model is looked at that stands for itself.
struct ModelView {
  enum class Up { kX, kY, kZ } up = Up::kY;
  float azimuth = 30;    ///< degrees around the axis that points up
  float elevation = 20;  ///< degrees above the floor, in [-90, 90]
  float fov = 35;        ///< degrees along the picture's shorter side, in (0, 180)
};

/// Which way Nori's camera space turns: the same files make pictures that mirror each other.
enum class NoriCamera { kEth, kUpstream };

/// Options of reading.
struct ReadOptions {
  std::vector<std::pair<std::string, std::string>> defines;  ///< -D name=value: what `$name` means in the file
  bool lenient = false;  ///< what cannot be read is left out or replaced; Description::stand_ins says what
  NoriCamera nori_camera = NoriCamera::kEth;
  ModelView view;  ///< of models, and leniently of scenes without a camera
};

/// Reads a scene file: pbrt-v4 if its name ends in .pbrt or .pbrt.gz, else of a dialect chosen by content: Nori
/// (`camera`, no version) or Mitsuba 0.6 to 3 (`sensor`, `version`); or a model (.obj, .ply, .serialized), which is put
/// on a floor under a sky. Meshes are found, not read, but for models and OBJ files that bring materials for a shape
/// without one (scene/dialects/obj_materials.h). Throws SceneError.
Description read_scene(const std::filesystem::path& file, const ReadOptions& options = {});

}  // namespace sheaf
