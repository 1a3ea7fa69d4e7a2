// View, environment and animation time of a model.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace sheaf {

/// View direction for automatic camera placement.
struct ModelView {
  enum class Up { kX, kY, kZ } up = Up::kY;
  float azimuth = 30;             ///< degrees around the up axis
  float elevation = 20;           ///< degrees above the floor, in [-90, 90]
  float fov = 35;                 ///< degrees along the image's shorter side, in (0, 180)
  double aspect_ratio = 4.0 / 3;  ///< width of the image over its height
};

/// What surrounds a model without cameras and lights.
enum class Studio {
  kNone,  ///< a sky with a sun
  kSoft,  ///< a seamless backdrop and three area lights; see studio.h
  kSun,   ///< a floor under a sky with a sun
};

/// The environment of a model.
struct ModelEnvironment {
  bool floor = true;
  /// Image by longitude and latitude, or kNoEnvironment; empty: a sky with a sun
  std::filesystem::path environment;
  std::optional<Studio> studio = {};      ///< as requested
  Studio default_studio = Studio::kSoft;  ///< unless there is a request, an environment, or no floor

  static constexpr const char* kNoEnvironment = "none";

  Studio chosen_studio() const {
    if (studio) return *studio;
    if (!floor) return Studio::kNone;
    return environment.empty() ? default_studio : Studio::kSun;
  }
};

/// The moment at which an animated model is rendered.
struct AnimationTime {
  std::optional<double> time;  ///< seconds; empty: as the file is, without animation
  std::string animation;       ///< name or index; empty: the first
};

}  // namespace sheaf
