// The context of a stage: all that it reads besides its wave.
#pragma once

#include "kernels/guiding/guide_view.h"
#include "scene/tables/scene.h"

namespace sheaf {

class CameraTask;
class TrainingSamples;
class LightTask;
struct PhotonMaps;

/// The scene, the settings of the integrator, and the data of the pass. One per worker. Stages do not modify it, except
/// through its pointers.
struct StageContext {
  SceneView scene;
  IntegratorDescription integrator;  ///< settings of the integrator
  SamplerView sampler;
  /// False: a debug view, whose paths carry plain numbers and ignore media.
  bool transports_light = true;
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
      : scene(of.view()), integrator(of.integrator()), sampler(of.sampler_view()), camera(task) {}
};

/// Whether next-event estimation is used.
inline bool samples_lights(const StageContext& context) {
  return context.scene.light_count > 0 && context.integrator.strategy != LightStrategy::kBsdfOnly;
}

}  // namespace sheaf
