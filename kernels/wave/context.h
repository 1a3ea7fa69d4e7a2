// The context of a stage: all that it reads besides its wave.
#pragma once

#include "kernels/guiding/guide_view.h"
#include "scene/tables/scene.h"

namespace sheaf {

class CameraTask;
class TrainingSamples;
class LightTask;
struct PhotonMaps;

/// What a pass transports, from where.
enum class PassKind {
  kPath,    ///< radiance along paths from the camera to the film
  kLight,   ///< importance along paths from the lights, whose vertices are connected to the camera
  kPhoton,  ///< photons from the lights, which are stored
  kDebug,   ///< plain values of the first surface, such as normals; no media
};

/// The scene, the settings of the integrator, and the data of the pass. One per worker. Stages do not modify it, except
/// through its pointers.
struct StageContext {
  SceneView scene;
  IntegratorSettings integrator;  ///< settings of the integrator
  SamplerView sampler;
  PassKind pass = PassKind::kPath;
  CameraTask* camera = nullptr;      ///< passes from the camera: the samples to take, and their results
  const PhotonMaps* maps = nullptr;  ///< passes from the camera that gather photons; otherwise null
  /// Number in [0, 1) from which the wavelengths of all paths are derived; -1: each path draws its own.
  float wavelength_sample = -1;
  LightTask* photons = nullptr;  ///< passes from the lights: the photons to emit; otherwise null
  bool guides = false;           ///< path pass: directions are also sampled from `guide`
  GuideView guide;
  TrainingSamples* training = nullptr;  ///< passes that record training samples of the guide; otherwise null

  StageContext() = default;
  /// With the settings of the scene.
  explicit StageContext(const Scene& of, CameraTask* task = nullptr)
      : scene(of.view()),
        integrator(of.integrator()),
        sampler(of.sampler_view()),
        pass(sheaf::transports_light(of.integrator().kind) ? PassKind::kPath : PassKind::kDebug),
        camera(task) {}

  bool transports_light() const { return pass != PassKind::kDebug; }
  bool starts_at_lights() const { return pass == PassKind::kLight || pass == PassKind::kPhoton; }
  /// Whether paths from the camera look photons up.
  bool gathers_photons() const { return maps != nullptr; }
  /// Whether paths record training samples for the guide.
  bool trains_guide() const { return training != nullptr; }
};

/// Whether next-event estimation is used.
inline bool samples_lights(const StageContext& context) {
  return context.scene.lights.count > 0 && context.integrator.strategy != LightStrategy::kBsdfOnly;
}

}  // namespace sheaf
