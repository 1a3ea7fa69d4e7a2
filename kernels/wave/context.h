// What stages see besides their wave.
#pragma once

#include "kernels/guiding/guide_view.h"
#include "scene/tables/scene.h"

namespace sheaf {

class CameraTask;
class TrainingSamples;
class LightTask;
struct PhotonMaps;

/// The scene, how light is transported in it, and what the pass adds. One for each worker; stages don't change it, but
/// for what its pointers lead to.
struct StageContext {
  SceneView scene;
  IntegratorDescription integrator;  ///< settings of the integrator
  SamplerView sampler;
  bool transports_light = true;      ///< false: a debug view, whose paths carry plain numbers and see no media
  CameraTask* camera = nullptr;      ///< of passes that start at the camera: the samples to take, and where they go
  const PhotonMaps* maps = nullptr;  ///< of passes from the camera that gather photons, else null
  float wavelength_sample = -1;  ///< the number in [0, 1) that all paths' wavelengths are made of; -1: each has its own
  LightTask* photons = nullptr;  ///< of passes that start at the lights, else null: the photons to emit
  bool guides = false;           ///< of the path pass: directions are sampled from `guide` as well
  GuideView guide;
  TrainingSamples* training = nullptr;  ///< of passes from which the guide is to learn, else null: what they tell

  StageContext() = default;
  /// The scene's own settings.
  explicit StageContext(const Scene& of, CameraTask* task = nullptr)
      : scene(of.view()), integrator(of.integrator()), sampler(of.sampler_view()), camera(task) {}
};

/// Whether direct light is sampled at all.
inline bool samples_lights(const StageContext& context) {
  return context.scene.light_count > 0 && context.integrator.strategy != LightStrategy::kBsdfOnly;
}

}  // namespace sheaf
