// The kernels' view of a compiled scene: pointers to flat, immutable tables by subject, which they access by index.
#pragma once

#include "core/math/vec3d.h"
#include "scene/tables/geometry.h"
#include "scene/tables/light_tables.h"
#include "scene/tables/material_tables.h"
#include "scene/tables/medium_tables.h"
#include "scene/tables/motion.h"
#include "scene/tables/render_settings.h"
#include "scene/tables/sensor_tables.h"
#include "scene/tables/spectrum_tables.h"
#include "scene/tables/texture.h"

namespace sheaf {

class Accel;

/// The scene for kernels: pointers to its tables by subject, and small settings by value.
struct SceneView {
  GeometryView geometry;
  MaterialView materials;
  TextureView textures;
  LightView lights;
  MediumView media;
  MotionView motion;
  SensorView sensor;
  SpectralView spectral;  ///< only in spectral mode
  const Accel* accel = nullptr;
  Vec3d origin{};                    ///< see Scene::origin()
  Vec3f center{};                    ///< center of the bounding sphere
  float radius = 0;                  ///< of the bounding sphere
  bool needs_transmittance = false;  ///< whether shadow rays may pass through surfaces, media or lights
  /// Whether shadow rays pass through thin dielectrics. This requires that passing costs no depth, and that no thin
  /// dielectric has a texture or is part of a composite material.
  bool shadow_rays_pass_thin_dielectrics = false;
  LightSelector light_selector = LightSelector::kBvh;
  ColorMode color = ColorMode::kRgb;
};

}  // namespace sheaf
