// The content of a scene file as plain data, independent of the file's dialect. compile.cpp turns it into a Scene.
#pragma once

#include "core/math/animated_transform.h"
#include "scene/description/camera.h"
#include "scene/description/media.h"
#include "scene/description/remarks.h"
#include "scene/description/shapes.h"
#include "scene/lights/list.h"
#include "scene/materials/material.h"
#include "scene/tables/render_settings.h"
#include "scene/textures/list.h"

#include <filesystem>
#include <string>
#include <vector>

namespace sheaf {

/// A whole scene.
struct Description : Remarks, SceneSettings {
  // Defined in description.cpp: these functions take long to compile.
  Description();
  Description(const Description& other);
  Description(Description&& other) noexcept;
  Description& operator=(const Description& other);
  Description& operator=(Description&& other) noexcept;
  ~Description();

  CameraDescription camera;
  std::vector<CameraDescription> more_cameras;  ///< the film is divided into one column of equal width per camera
  std::vector<TextureDescription> textures;
  std::vector<MaterialDescription> materials;
  std::vector<PhaseDescription> phases;
  std::vector<MediumDescription> media;
  std::vector<ShapeDescription> shapes;
  std::vector<ShapeGroup> groups;
  std::vector<InstanceDescription> instances;
  std::vector<LightDescription> lights;
  std::vector<AnimatedTransform> motions;  ///< of objects that name them by MotionId
  ShutterDescription shutter;
  std::filesystem::path file;
  std::vector<std::filesystem::path> files;  ///< all files of the scene, including itself and files not yet read
};

}  // namespace sheaf
