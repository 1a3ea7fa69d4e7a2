// The sensor of a scene: its cameras and the pixel filter.
#pragma once

#include "scene/tables/camera.h"
#include "scene/tables/filter.h"

#include <optional>
#include <vector>

namespace sheaf {

/// The cone of directions and positions that a pixel sees.
struct PixelCone {
  float width = 0;   ///< at the origin of camera rays, m
  float spread = 0;  ///< increase of the width per distance
};

/// The sensor for kernels.
struct SensorView {
  Camera camera;                         ///< the first camera
  const Camera* more_cameras = nullptr;  ///< cameras of the film's further columns
  std::uint32_t more_camera_count = 0;
  float column_width = 0;               ///< pixels per camera's column of the film, if there are several
  const FilterTable* filter = nullptr;  ///< placement of samples in a pixel
  /// weights of samples in neighboring pixels; null: samples count only in their own pixel
  const FilterWeights* filter_weights = nullptr;
  PixelCone pixel_cone;  ///< the narrowest of all cameras and pixels; 0: the film is no image
};

/// Owns cameras and filter. The view refers to them.
struct SensorTables {
  Camera camera;
  std::vector<Camera> more_cameras;
  FilterTable filter;
  std::optional<FilterWeights> filter_weights;
  PixelCone pixel_cone;

  /// The camera of a column of the film.
  Camera& camera_of(std::size_t column) { return column == 0 ? camera : more_cameras[column - 1]; }
  const Camera& camera_of(std::size_t column) const { return column == 0 ? camera : more_cameras[column - 1]; }

  /// `film_width`: pixels of all columns.
  SensorView view(int film_width) const {
    return {camera,
            more_cameras.data(),
            static_cast<std::uint32_t>(more_cameras.size()),
            static_cast<float>(film_width) / static_cast<float>(more_cameras.size() + 1),
            &filter,
            filter_weights ? &*filter_weights : nullptr,
            pixel_cone};
  }
};

}  // namespace sheaf
